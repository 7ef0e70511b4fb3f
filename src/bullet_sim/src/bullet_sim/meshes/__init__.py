"""Mesh files of descriptions: checked and converted for the engine."""
