"""Mesh files that descriptions name: found, checked, converted for the engine."""
