"""The meshes of the car's description."""
