"""Controllers and plugins that drive a base: kinematics, odometry, limits."""
