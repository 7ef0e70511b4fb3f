"""ros_control's topics and services of one robot."""
