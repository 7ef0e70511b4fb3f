"""Occupancy maps of worlds, and worlds of occupancy maps."""
