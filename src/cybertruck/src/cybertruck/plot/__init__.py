"""Records poses and draws them: PNG and CSV."""
