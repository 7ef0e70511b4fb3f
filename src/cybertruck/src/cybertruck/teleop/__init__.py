"""Keyboard and joystick teleop: logic, sources of events, the screen, and the nodes."""
