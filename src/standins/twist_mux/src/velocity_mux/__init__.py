"""The multiplexer of velocity commands: parameters -> sources and locks -> who passes."""
