"""Clients of the simulator's /gazebo services."""
