"""A robot of three joints that controllers of tests claim."""
