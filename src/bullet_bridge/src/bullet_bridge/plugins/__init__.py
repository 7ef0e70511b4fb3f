"""What the families of plugins and sensors do in ROS; importing this enters each file of it."""

from bullet_sim.registry import load_files

from bullet_bridge.plugins.base import enter_parts

load_files(__name__, __path__)
enter_parts()
