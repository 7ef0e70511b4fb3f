"""Tracks and the car's model: YAML to SDF, textures and meshes."""
