"""A track's generated files: texture, meshes, world, and their cache."""
