"""Helpers for the operating system: terminal output, sockets."""
