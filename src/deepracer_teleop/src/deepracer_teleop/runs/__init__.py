"""Runs with results: the demo, laps, their films and images."""
