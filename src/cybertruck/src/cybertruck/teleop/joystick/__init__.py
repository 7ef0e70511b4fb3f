"""The joystick teleop: pads, their maps and driving schemes."""
