"""Pure simulation core of Paddock: no ROS import, usable as a plain Python library."""
