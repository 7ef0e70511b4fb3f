"""The multiplexer of velocity commands: parameters -> sources and locks -> the active source."""
