"""A page in any browser that shows the running world, drives it and keeps it as a file."""
