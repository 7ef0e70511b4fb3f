"""Driving by hand: held keys and the stick of a pad."""
