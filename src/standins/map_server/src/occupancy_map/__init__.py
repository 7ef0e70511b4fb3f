"""Occupancy grids: map file and picture <-> cells <-> messages."""
