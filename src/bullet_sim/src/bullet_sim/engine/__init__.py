"""PyBullet as plain arrays: bodies, joints, rays and pictures; nothing else imports pybullet.

Poses are those of link frames (not of inertial frames), quaternions are (x, y, z, w).
"""

from bullet_sim.engine.camera import Pictures
from bullet_sim.engine.engine import Bodies, Sensing, Touch


class Engine(Bodies, Sensing, Touch, Pictures):
    """One headless PyBullet client.

    Args:
        time_step: physics step [s].
        gravity: acceleration in the world frame [m/s^2].
        solver_iterations: of the constraint solver per step.
    """
