"""Physics properties that can be read and changed at run time."""

import math
from dataclasses import dataclass, replace

from bullet_sim.description.world import MIN_STEP
from bullet_sim.errors import WorldError

MAX_ITERATIONS = 1000
# ODE settings that are fixed in Bullet: reported, and requests to change them are ignored.
FIXED = dict(
    auto_disable_bodies=False,
    sor_pgs_precon_iters=0,
    sor_pgs_w=1.0,
    sor_pgs_rms_error_tol=0.0,
    contact_surface_layer=0.0,
    contact_max_correcting_vel=0.0,
    cfm=0.0,
    erp=0.2,
    max_contacts=4,
)


@dataclass(frozen=True)
class Properties:
    """Values under gazebo_ros' names.

    Attributes:
        time_step: physics step [s].
        max_update_rate: steps per wall second [Hz]; 0: no limit.
        gravity: (3,) [m/s^2] in the world frame.
        iterations: of the constraint solver per step; 0 in a request: as it is.
    """

    time_step: float
    max_update_rate: float
    gravity: tuple[float, float, float]
    iterations: int

    def check(self):
        """Raise WorldError with name, value and what is valid when a value is impossible."""
        if not MIN_STEP <= self.time_step < 1:
            raise WorldError(
                f"time_step is {self.time_step} s, must be from {MIN_STEP:g} to below 1"
            )
        if not all(math.isfinite(g) for g in self.gravity):
            raise WorldError(f"gravity is {tuple(self.gravity)} m/s^2, must be finite")
        if not (math.isfinite(self.max_update_rate) and self.max_update_rate >= 0):
            raise WorldError(
                f"max_update_rate is {self.max_update_rate} Hz, must be 0 (no limit) or more"
            )
        if not 0 <= self.iterations <= MAX_ITERATIONS:
            raise WorldError(
                f"sor_pgs_iters is {self.iterations}, must be 0 (as it is) to {MAX_ITERATIONS}"
            )


class PhysicsProperties:
    """Reads and changes the properties (simulation thread).

    Args:
        world: of the core.
        server: Server, which keeps the pace.
    """

    def __init__(self, world, server):
        self._world, self._server = world, server

    def read(self):
        """Properties now."""
        step = self._world.time_step
        return Properties(
            step,
            self._server.real_time_factor / step,
            tuple(self._world.gravity),
            self._world.engine.solver_iterations,
        )

    def change(self, **wanted):
        """Change some fields of Properties.

        Raises:
            WorldError: a value is impossible, or the step cannot change now; nothing has changed.
        """
        now = self.read()
        new = replace(now, **wanted)
        new.check()
        if not math.isclose(new.time_step, now.time_step, rel_tol=1e-9):
            self._server.set_time_step(new.time_step)
        self._world.engine.set_gravity(new.gravity)
        factor = new.max_update_rate * self._world.time_step
        if not math.isclose(factor, self._server.real_time_factor, rel_tol=1e-9):
            self._server.set_pace(factor)
        if new.iterations not in (0, now.iterations):
            self._world.engine.set_solver_iterations(new.iterations)
