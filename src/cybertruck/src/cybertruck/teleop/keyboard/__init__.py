"""The keyboard teleop: key events from a terminal or an X screen."""
