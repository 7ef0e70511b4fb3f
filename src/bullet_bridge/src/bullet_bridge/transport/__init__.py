"""How a message reaches the sockets of its subscribers."""
