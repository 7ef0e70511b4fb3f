"""The world: models in an engine, simulated time, and states to go back to."""

from bullet_sim.world.world import World

__all__ = ["World"]
