"""The joystick teleop: parameters -> what axes and buttons mean -> velocity commands."""
