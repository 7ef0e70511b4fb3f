"""Helpers around the operating system: terminal output, sockets."""
