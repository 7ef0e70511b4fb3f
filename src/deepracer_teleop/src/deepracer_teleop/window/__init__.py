"""The teleop window and what its widgets do."""
