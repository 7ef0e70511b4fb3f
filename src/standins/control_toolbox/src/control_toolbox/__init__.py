"""Configuration of PIDs that are tuned through dynamic_reconfigure."""
