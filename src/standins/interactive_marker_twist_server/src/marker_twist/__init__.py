"""The marker that drives: parameters -> scales -> velocity commands."""
