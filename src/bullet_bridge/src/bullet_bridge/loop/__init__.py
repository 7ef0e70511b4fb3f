"""The simulation thread: steps, pace, clock, schedule, jobs, arrived commands."""
