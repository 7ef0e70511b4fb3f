"""Driving a DeepRacer-like car: topic names, the command node and its steering geometry."""
