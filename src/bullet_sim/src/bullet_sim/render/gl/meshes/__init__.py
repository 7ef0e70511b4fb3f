"""Meshes and textures: read, given normals, uploaded once."""
