"""Paths of robots that were driven by one plan in Gazebo and in Paddock."""
