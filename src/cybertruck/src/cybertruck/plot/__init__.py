"""Records poses and plots them: PNG and CSV."""
