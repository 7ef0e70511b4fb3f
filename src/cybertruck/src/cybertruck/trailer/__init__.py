"""Truck with trailer: kinematics, steering map, paths and backing control; no ROS in here."""
