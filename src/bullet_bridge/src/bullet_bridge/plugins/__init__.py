"""Sensors and plugins of models in ROS: each family's topics, published from the simulation."""
