"""Drivers compared: laps, times, where they leave the track. Needs no torch."""
