"""The joystick driver: pad -> numbers -> messages."""
