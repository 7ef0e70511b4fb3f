"""Completion in bash: the script that a shell sources, and the candidates it asks ./run for."""
