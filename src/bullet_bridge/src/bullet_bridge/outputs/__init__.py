"""Published data of a world: sensors, states, pictures, views for the viewer."""
