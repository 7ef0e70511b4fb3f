"""Sweeps: many trainings or drives with other settings each, compared. What ./run sweep does."""
