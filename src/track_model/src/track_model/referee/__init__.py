"""The lap referee: laps and offences of a car on a track, from its ground truth."""
