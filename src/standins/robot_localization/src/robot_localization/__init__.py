"""State estimation: measurements -> an extended Kalman filter -> odometry and frames."""
