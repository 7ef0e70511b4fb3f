"""What is published of a world: sensors, states, pictures, the viewer's feed."""
