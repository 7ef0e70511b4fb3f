"""Files that somebody has written by hand."""
