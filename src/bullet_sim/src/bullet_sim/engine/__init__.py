"""The physics engine: bodies, joints, contacts and rays; see api.py."""

from __future__ import annotations

from bullet_sim.engine.api import WORLD, Body, BodyLink, Contact, Engine, Motor
from bullet_sim.errors import ModelError
from bullet_sim.pose import Vec3

__all__ = [
    "FIXED_JOINTS",
    "SOLVERS",
    "WORLD",
    "Body",
    "BodyLink",
    "Contact",
    "Engine",
    "Motor",
    "make_engine",
]
NO_NUMBA = (
    "solver 'ode' cannot be loaded ({}): it needs the Python package numba, which ./run setup "
    "installs as config/requirements.txt pins it. Other physics has to be asked for by name: "
    "solver:=bullet of a launch file, World(solver='bullet')"
)
SOLVERS = ("ode", "bullet")
FIXED_JOINTS = ("keep", "merge")


def make_engine(solver: str, time_step: float, gravity: Vec3, fixed_joints: str = "keep") -> Engine:
    """Make an engine.

    Args:
        solver: 'ode': steps as Gazebo's ODE makes them; or 'bullet': PyBullet's own.
        time_step: [s].
        gravity: [m/s^2].
        fixed_joints: of the solver 'ode': 'keep' or 'merge', see World.

    Raises:
        ModelError: no such solver or fixed_joints, or 'ode' cannot be imported: nothing else takes
            its place.
    """
    if solver not in SOLVERS:
        raise ModelError(f"solver is {solver!r}, must be {' or '.join(SOLVERS)}")
    if fixed_joints not in FIXED_JOINTS:
        raise ModelError(f"fixed_joints is {fixed_joints!r}, must be {' or '.join(FIXED_JOINTS)}")
    if solver == "bullet":
        from bullet_sim.engine.bullet.engine import BulletEngine

        return BulletEngine(time_step, gravity)
    try:
        from bullet_sim.engine.ode.engine import OdeEngine  # numba takes a while
    except ImportError as error:
        raise ModelError(NO_NUMBA.format(error)) from error
    return OdeEngine(time_step, gravity, fixed_joints == "merge")
