"""The teleop window of the car, and a demo that drives through its widgets."""
