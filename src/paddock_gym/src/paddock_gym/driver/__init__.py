"""The node that drives the ROS car by a policy; the only part of this package that knows ROS."""
