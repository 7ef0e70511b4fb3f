"""What a policy sees: arrays from motion, ranges and pictures. No simulator, no ROS."""
