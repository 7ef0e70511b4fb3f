"""The drive node: /cmd_vel to wheels, odometry, joint states."""
