"""The lap referee: what a car did on a track, from its ground truth."""
