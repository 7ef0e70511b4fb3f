"""Comparisons of drivers: laps, times, where they leave the track. Needs no torch."""
