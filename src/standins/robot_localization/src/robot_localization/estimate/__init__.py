"""The filter: state, motion model, prediction and correction, measurements in order of time."""
