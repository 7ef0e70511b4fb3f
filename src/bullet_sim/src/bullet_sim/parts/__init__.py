"""What the parts of models that act or measure have in common."""
