"""Physics: services that get and set properties, pause, reset; dynamic_reconfigure."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import rospy
from bullet_sim.description.world import MIN_STEP, OdeSettings
from bullet_sim.errors import SimError, WorldError
from gazebo_msgs import srv
from gazebo_msgs.msg import ODEPhysics
from geometry_msgs.msg import Vector3
from paddock_common.reconfigure import describe
from std_srvs.srv import Empty

from bullet_bridge.services.handlers import empty_service_handler, offer
from bullet_bridge.transport.conversions import vector
from bullet_bridge.transport.reconfigure import ValuesServer

if TYPE_CHECKING:
    from bullet_sim.world import World

    from bullet_bridge.loop.jobs import JobQueue
    from bullet_bridge.loop.server import Server

MAX_ITERATIONS = 10_000
# dynamic_reconfigure's parameters, with the defaults and bounds of gazebo_ros' cfg/Physics.cfg.
_PARAMETERS = (
    ("time_step", "double", 0.001, 0.0, 10.0, "Physics step [s]."),
    ("max_update_rate", "double", 60.0, 0.0, 1000.0, "Steps per wall second [Hz]; 0: no limit."),
    ("gravity_x", "double", 0.0, -100.0, 100.0, "Gravity along x [m/s^2]."),
    ("gravity_y", "double", 0.0, -100.0, 100.0, "Gravity along y [m/s^2]."),
    ("gravity_z", "double", -9.8, -100.0, 100.0, "Gravity along z [m/s^2]."),
    ("auto_disable_bodies", "bool", False, False, True, "Of ODE, without effect."),
    ("sor_pgs_precon_iters", "int", 0, 0, 10000, "Is kept, without effect."),
    ("sor_pgs_iters", "int", 20, 0, 10000, "Iterations of the constraint solver per step."),
    ("sor_pgs_w", "double", 1.3, 0.0, 5.0, "Factor of each correction of the constraint solver."),
    ("sor_pgs_rms_error_tol", "double", -1.0, -1.0, 10000.0, "Of ODE, without effect."),
    ("cfm", "double", 0.0, 0.0, 10.0, "Constraint force mixing of joints [s/kg]."),
    ("erp", "double", 0.2, 0.0, 10.0, "Fraction of a joint's error that is corrected in a step."),
    ("contact_surface_layer", "double", 0.001, 0.0, 10.0, "Is kept, without effect [m]."),
    ("contact_max_correcting_vel", "double", 100.0, 0.0, 1e7, "Of contacts [m/s]; of new models."),
    ("max_contacts", "int", 100, 0, 10000000, "Of a pair of shapes; of new models."),
)
CONFIG = describe(_PARAMETERS)
# Settings of ODE that do not change here, by the solver; requests to change them are ignored. Those
# of 'ode' do not change in Gazebo either (PhysicsEngine::SetAutoDisableFlag is empty, gazebo_ros
# reads no tolerance): set_physics_properties answers neither, dynamic_reconfigure what was asked.
FIXED = {
    "ode": dict(auto_disable_bodies=False, sor_pgs_rms_error_tol=0.0),
    "bullet": dict(
        auto_disable_bodies=False,
        sor_pgs_precon_iters=0,
        sor_pgs_rms_error_tol=0.0,
        contact_surface_layer=0.0,
        max_contacts=4,
        sor_pgs_w=1.0,
        cfm=0.0,
        erp=0.2,
        contact_max_correcting_vel=0.0,
    ),
}
# Those that change with the solver 'ode': name -> field of OdeSettings.
SOLVER = dict(
    sor_pgs_precon_iters="precon_iterations",
    sor_pgs_w="relaxation",
    cfm="cfm",
    erp="erp",
    contact_surface_layer="surface_layer",
    contact_max_correcting_vel="max_speed",
    max_contacts="max_contacts",
)
LARGEST = 10_000_000  # of an integer of CONFIG
KEEPING = ("contact_max_correcting_vel", "max_contacts")  # of which 0 leaves what there is


@dataclass(frozen=True)
class Properties:
    """Values under gazebo_ros' names.

    Attributes:
        time_step: physics step [s].
        max_update_rate: steps per wall second [Hz]; 0: no limit.
        gravity: (3,) [m/s^2] in the world frame.
        iterations: of the constraint solver per step; 0: nothing holds or collides, as in Gazebo.
            In a request to the solver 'bullet' 0 leaves them.
        ode: those of SOLVER and of FIXED, by gazebo_ros' names.
    """

    time_step: float
    max_update_rate: float
    gravity: tuple[float, float, float]
    iterations: int
    ode: Mapping[str, Any] = field(default_factory=dict)

    def check(self) -> None:
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
            raise WorldError(f"sor_pgs_iters is {self.iterations}, must be 0 to {MAX_ITERATIONS}")
        for name in SOLVER:
            value = self.ode.get(name, 0.0)
            if not (math.isfinite(value) and value >= 0.0):
                raise WorldError(f"{name} is {value}, must be finite and 0 or more")


class PhysicsProperties:
    """Reads and changes the properties (simulation thread).

    Args:
        server: whose real time factor is read and set.
    """

    def __init__(self, world: World, server: Server) -> None:
        self._world, self._server = world, server

    def read(self) -> Properties:
        """Properties now."""
        step, engine = self._world.time_step, self._world.engine
        settings = engine.settings
        fixed = FIXED["bullet" if settings is None else "ode"]
        changeable = {} if settings is None else _of_solver(settings)
        return Properties(
            step,
            self._server.real_time_factor / step,
            self._world.gravity,
            engine.solver_iterations,
            {**fixed, **changeable},
        )

    def change(self, **values: Any) -> None:
        """Change some fields of Properties.

        Raises:
            WorldError: a value is impossible, or the step cannot change now; nothing has changed.
        """
        now = self.read()
        asked = values.pop("ode", {})
        new = replace(now, ode={**now.ode, **asked}, **values)
        new.check()
        if not math.isclose(new.time_step, now.time_step, rel_tol=1e-9):
            self._server.set_time_step(new.time_step)
        self._world.engine.set_gravity(new.gravity)
        factor = new.max_update_rate * self._world.time_step
        if not math.isclose(factor, self._server.real_time_factor, rel_tol=1e-9):
            self._server.set_pace(factor)
        settings = self._world.engine.settings
        if new.iterations != now.iterations and (new.iterations or settings is not None):
            self._world.engine.set_solver_iterations(new.iterations)
            settings = self._world.engine.settings
        if settings is not None:
            given = {
                SOLVER[name]: new.ode[name]
                for name in SOLVER
                if new.ode[name] or name not in KEEPING
            }
            self._world.engine.configure(replace(settings, **given))


def _of_solver(settings: OdeSettings) -> dict[str, Any]:
    """Settings of a world by gazebo_ros' names; integers as far as its messages hold them."""
    values = {name: getattr(settings, attribute) for name, attribute in SOLVER.items()}
    return {
        name: min(value, LARGEST) if isinstance(value, int) else value
        for name, value in values.items()
    }


class PhysicsServices:
    """Pausing, resetting, gravity, step and pace."""

    def __init__(
        self, prefix: str, jobs: JobQueue, server: Server, properties: PhysicsProperties
    ) -> None:
        self._jobs, self._server, self._properties = jobs, server, properties

        def offer_empty(name: str, job: Callable[[], Any]) -> None:
            handler = empty_service_handler(lambda _: jobs.call(job))
            rospy.Service(f"{prefix}/{name}", Empty, handler)

        offer_empty("pause_physics", lambda: server.set_paused(True))
        offer_empty("unpause_physics", lambda: server.set_paused(False))
        offer_empty("reset_simulation", lambda: server.reset())
        offer_empty("reset_world", lambda: server.reset_models())
        offer_empty("restart", lambda: server.reset(fresh=True))
        offer(
            prefix,
            ("get_physics_properties", srv.GetPhysicsProperties, self._get),
            ("set_physics_properties", srv.SetPhysicsProperties, self._set),
        )

    def _get(self, _: Any) -> srv.GetPhysicsPropertiesResponse:
        now = self._jobs.read(self._properties.read)
        return srv.GetPhysicsPropertiesResponse(
            time_step=now.time_step,
            pause=self._server.paused,
            max_update_rate=now.max_update_rate,
            gravity=Vector3(*now.gravity),
            ode_config=ODEPhysics(sor_pgs_iters=now.iterations, **now.ode),
            status_message="GetPhysicsProperties: got properties",
        )

    def _set(self, request: Any) -> srv.SetPhysicsPropertiesResponse:
        config = request.ode_config
        asked = {name: getattr(config, name) for name in SOLVER}
        self._jobs.call(
            lambda: self._properties.change(
                time_step=request.time_step,
                max_update_rate=request.max_update_rate,
                gravity=tuple(vector(request.gravity).tolist()),
                iterations=config.sor_pgs_iters,
                ode=asked,
            )
        )
        now = self._properties.read().ode
        others = [name for name in asked if asked[name] not in (now[name], type(now[name])())]
        if others:
            rospy.logwarn(
                "set_physics_properties: %s cannot be changed here and are ignored",
                ", ".join(others),
            )
        return srv.SetPhysicsPropertiesResponse(status_message="physics engine updated")


AXES = ("gravity_x", "gravity_y", "gravity_z")


def as_config(properties: Properties) -> dict[str, Any]:
    """dict of CONFIG's names with the values of Properties."""
    return dict(
        properties.ode,
        time_step=properties.time_step,
        max_update_rate=properties.max_update_rate,
        sor_pgs_iters=properties.iterations,
        **dict(zip(AXES, properties.gravity)),
    )


def as_properties(config: Mapping[str, Any]) -> dict[str, Any]:
    """Arguments for PhysicsProperties.change: all of a configuration."""
    return dict(
        time_step=config["time_step"],
        max_update_rate=config["max_update_rate"],
        gravity=tuple(config[axis] for axis in AXES),
        iterations=config["sor_pgs_iters"],
        ode={name: config[name] for name in SOLVER},
    )


class PhysicsServer(ValuesServer):
    """dynamic_reconfigure server of the world; to be created before the simulation runs.

    As GazeboRosApiPlugin::physicsReconfigureCallback it begins with the world's values, and sets
    all of its own whenever one of them is asked for, which undoes what a service has changed.
    """

    def __init__(self, namespace: str, jobs: JobQueue, properties: PhysicsProperties) -> None:
        self._jobs, self._properties = jobs, properties
        super().__init__(CONFIG, as_config(properties.read()), self._changed, namespace)

    def _changed(self, config: Any, _level: int) -> Any:
        try:
            self._jobs.call(lambda: self._properties.change(**as_properties(config)))
        except (SimError, TimeoutError) as error:
            rospy.logerr("physics properties: %s", error)
            config.update(as_config(self._jobs.read(self._properties.read)))
        return config
