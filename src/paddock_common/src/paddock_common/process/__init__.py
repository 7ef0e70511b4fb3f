"""A process of a node: it starts, gives way to others, ends by signals and with its parent."""
