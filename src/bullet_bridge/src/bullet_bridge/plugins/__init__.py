"""What the families of plugins and sensors do in ROS; importing this enters each file of it."""

from bullet_sim.registry import load_files

load_files(__name__, __path__)
