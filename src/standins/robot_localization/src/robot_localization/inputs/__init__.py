"""What the filter is fed with: parameters of the sensors, and their data in its frames."""
