"""The one place where the simulation core and ROS meet."""
