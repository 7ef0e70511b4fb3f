"""Reading of robots and worlds: URDF, SDF and what stands in them -> descriptions."""
