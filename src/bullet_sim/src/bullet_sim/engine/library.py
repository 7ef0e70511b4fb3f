"""The one import of pybullet, kept silent: it greets on the terminal."""

from bullet_sim.system.quiet import quiet

with quiet():
    import pybullet as p

__all__ = ["p"]
