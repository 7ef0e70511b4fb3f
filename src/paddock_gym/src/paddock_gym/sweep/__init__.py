"""Sweeps: compares many trainings or drives, each with other settings. The work of ./run sweep."""
