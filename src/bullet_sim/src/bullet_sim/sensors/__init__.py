"""Sensors as pure functions: simulator state in, numpy arrays out, no messages and no clocks."""
