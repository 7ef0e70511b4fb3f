"""Readers of robots and worlds: URDF and SDF -> descriptions."""
