"""The one import of pybullet, kept silent: it greets on the terminal."""

from bullet_sim.files import silenced

with silenced():
    import pybullet as p

__all__ = ["p"]
