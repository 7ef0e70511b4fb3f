"""Recordings: a bag and a film, and the button that makes them."""
