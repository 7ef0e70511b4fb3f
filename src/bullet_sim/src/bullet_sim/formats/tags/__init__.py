"""Gazebo's own tags in URDF and SDF: sensors, plugins, drives -> specs."""
