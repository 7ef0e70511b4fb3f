"""The physics engine: bodies, joints, contacts, rays and images; nothing else imports pybullet.

Poses are those of link frames (not of inertial frames), quaternions are (x, y, z, w).
"""

from typing import Any

from bullet_sim.errors import ModelError
from bullet_sim.files import silenced

with silenced():  # PyBullet prints a banner
    from bullet_sim.engine.engine import Engine
    from bullet_sim.engine.states import BodiesState, restore_bodies, save_bodies

__all__ = [
    "SOLVERS",
    "BodiesState",
    "Engine",
    "make_engine",
    "restore_bodies",
    "save_bodies",
]
NO_NUMBA = (
    "solver 'ode' cannot be loaded ({}): it needs the Python package numba, which ./run setup "
    "installs as config/requirements.txt pins it. Other physics has to be asked for by name: "
    "solver:=bullet of a launch file, World(solver='bullet')"
)
SOLVERS = ("ode", "bullet")


def make_engine(solver: str, *arguments: Any, **options: Any) -> Engine:
    """Make an engine.

    Args:
        solver: 'ode': steps as Gazebo's ODE makes them; or 'bullet': PyBullet's own.
        arguments, options: of Engine.

    Raises:
        ModelError: no such solver, or 'ode' cannot be imported: nothing else takes its place.
    """
    if solver not in SOLVERS:
        raise ModelError(f"solver is {solver!r}, must be {' or '.join(SOLVERS)}")
    if solver == "bullet":
        return Engine(*arguments, **options)
    try:
        from bullet_sim.engine.ode_engine import OdeEngine  # numba takes a while
    except ImportError as error:
        raise ModelError(NO_NUMBA.format(error)) from error
    return OdeEngine(*arguments, **options)
