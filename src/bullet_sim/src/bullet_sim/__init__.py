"""Pure simulation core of Paddock: no ROS import, a plain Python library."""
