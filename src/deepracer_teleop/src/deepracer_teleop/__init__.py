"""The teleop window of the car, and a demo that drives with its widgets."""
