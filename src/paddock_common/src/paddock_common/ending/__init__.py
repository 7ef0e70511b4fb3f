"""Processes end: by signals, and with the one that started them."""
