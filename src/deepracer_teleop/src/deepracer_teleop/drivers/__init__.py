"""Drivers that use the window's own widgets."""
