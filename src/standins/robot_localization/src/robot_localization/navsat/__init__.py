"""Satellite fixes in the robot's world: latitude and longitude -> a grid -> the world frame."""
