"""The keyboard teleop: terminal -> keys -> velocity commands."""
