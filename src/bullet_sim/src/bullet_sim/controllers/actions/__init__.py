"""Controllers whose goals come by an action: trajectories of several joints, grippers."""
