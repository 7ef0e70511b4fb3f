"""Drivers: nodes that steer the car on /cmd_vel."""
