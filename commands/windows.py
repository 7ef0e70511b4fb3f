"""Programs that need a screen or a terminal, which ./run check does not have."""

# How their names start, and what is in them.
WITH_SCREEN = ("rviz", "rqt", "gzclient", "joint_state_publisher_gui", "image_view", "xterm")
AT_KEYBOARD = ("keyboard", "keyop", "teleop_key")


def needs_screen(program):
    """Whether a program opens a window or reads a terminal's keys."""
    return program.startswith(WITH_SCREEN) or any(word in program for word in AT_KEYBOARD)
