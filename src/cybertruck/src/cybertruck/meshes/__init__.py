"""Meshes of truck and trailer: flat folded faces, written as Wavefront OBJ by a script."""
