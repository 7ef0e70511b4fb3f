"""SDF worlds and models, their frames and shapes -> descriptions."""
