"""The joystick teleop: pads, their maps and schemes."""
