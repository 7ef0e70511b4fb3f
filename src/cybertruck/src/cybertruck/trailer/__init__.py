"""Truck with trailer: kinematics, steering map, paths and backing control; without ROS."""
