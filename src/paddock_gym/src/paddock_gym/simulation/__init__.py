"""Cars on a track in a world of the core."""
