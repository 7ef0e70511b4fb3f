"""Keyboard and joystick teleop: logic, event sources, screen, nodes."""
