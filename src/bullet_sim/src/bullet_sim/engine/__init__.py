"""The physics engine: bodies, joints, contacts, rays and images; nothing else imports pybullet.

Poses are those of link frames (not of inertial frames), quaternions are (x, y, z, w).
"""

from bullet_sim.files import silenced

with silenced():  # PyBullet prints a banner
    from bullet_sim.engine.engine import SOLVERS, Engine

__all__ = ["SOLVERS", "Engine"]
