"""Occupancy grids: map file and image <-> cells <-> messages."""
