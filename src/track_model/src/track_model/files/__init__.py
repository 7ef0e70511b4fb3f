"""A track's generated files: texture, meshes, world, and the cache they live in."""
