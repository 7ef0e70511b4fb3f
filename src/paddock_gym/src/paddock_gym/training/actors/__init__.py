"""Workers on a Ray cluster: actors that drive by themselves and report what happened."""
