"""The physics engine: bodies, joints, contacts, rays and images; nothing else imports pybullet.

Poses are those of link frames (not of inertial frames), quaternions are (x, y, z, w).
"""

from typing import Any

from bullet_sim.errors import ModelError
from bullet_sim.files import silenced

with silenced():  # PyBullet prints a banner
    from bullet_sim.engine.engine import Engine

__all__ = ["SOLVERS", "Engine", "make_engine"]
SOLVERS = ("bullet", "ode")


def make_engine(solver: str, *arguments: Any, **options: Any) -> Engine:
    """Make an engine.

    Args:
        solver: 'bullet', or 'ode': steps as Gazebo's ODE makes them.
        arguments, options: of Engine.

    Raises:
        ModelError: no such solver, or it cannot be had.
    """
    if solver not in SOLVERS:
        raise ModelError(f"solver is {solver!r}, must be {' or '.join(SOLVERS)}")
    if solver == "bullet":
        return Engine(*arguments, **options)
    from bullet_sim.engine.ode_engine import OdeEngine  # numba takes a while

    return OdeEngine(*arguments, **options)
