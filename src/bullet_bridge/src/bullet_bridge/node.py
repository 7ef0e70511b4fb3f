"""The bridge node: its parameters, and its life from the first world to the last message."""

from __future__ import annotations

import functools
import os
import sys
from collections.abc import Callable
from contextlib import ExitStack, suppress
from dataclasses import dataclass, replace
from typing import Any

import rospy
from bullet_sim.description.world import WorldDescription
from bullet_sim.engine import FIXED_JOINTS, SOLVERS
from bullet_sim.errors import SimError
from bullet_sim.files import LIMITS, keep_python_output, variable_of
from bullet_sim.formats.lumping import LEAVE_OUT, MASSLESS
from bullet_sim.formats.resolve import Resolver
from bullet_sim.plugins import cpp
from bullet_sim.render.request import RENDERERS, SWITCHES, Quality
from bullet_sim.sensors.scenes import WorldViews
from bullet_sim.world import World
from bullet_sim.xml_reader import is_true
from paddock_common.nodes import tolerate_log_errors
from paddock_common.process import exit_with_roslaunch
from paddock_common.settings import check, choice, flag, number, read, text

from bullet_bridge.extensions import Extensions
from bullet_bridge.gazebo_host.host import host_of, make_models_by
from bullet_bridge.gazebo_host.libraries import users_libraries
from bullet_bridge.gazebo_host.models import Models
from bullet_bridge.loop.clock import SimClock, set_process_time
from bullet_bridge.loop.jobs import JobQueue
from bullet_bridge.loop.received import ReceivedCounts
from bullet_bridge.loop.server import Server
from bullet_bridge.plugins.cameras import Cameras
from bullet_bridge.resolve import RosPackages, load_world
from bullet_bridge.robots import Robots
from bullet_bridge.services.attaching import LinkAttacher
from bullet_bridge.services.gazebo import GazeboServices
from bullet_bridge.services.models import remove_model
from bullet_bridge.services.simulation import Describer, StepService, advertise_json
from bullet_bridge.transport import publishing
from bullet_bridge.transport.master_monitor import ShutdownMonitor
from bullet_bridge.transport.relay import Relay
from paddock_common import nodes

MISSING_PACKAGES = ("refuse", "warn")
END_LIMIT = 1.5  # [s] wall time after which a shutdown breaks off what is read or spawned


@dataclass(frozen=True)
class Config:
    """Checked parameters.

    Attributes:
        world_file: SDF world to load; empty: an empty world.
        real_time_factor: simulated seconds per wall second; 0: as fast as possible. The default
            is, for launch files that do not pass it on, the environment variable
            PADDOCK_REAL_TIME_FACTOR.
        world_pace: no real_time_factor is given; that of the world file counts.
        lockstep: start paused; time advances only by /gazebo/step, which waits for all images.
        every_picture: wait for each due image, without lockstep, too; time slows down instead.
        solver: ode: steps as Gazebo's ODE makes them, or bullet: PyBullet's own; for launch files
            that do not pass it on, the environment variable PADDOCK_SOLVER.
        fixed_joints: keep: those of an SDF, and those to the world, are joints, as in Gazebo;
            merge: they never yield; for launch files that do not pass it on, the environment
            variable PADDOCK_FIXED_JOINTS.
        renderer: auto, gl or tiny.
        shadows, antialias: auto, true or false: see bullet_sim.render.request.Quality.
        labels: every camera also publishes which model each pixel shows.
        clock_rate: messages on /clock per simulated second [Hz]; 0 or less: one a step, as in
            Gazebo.
        states_rate: of model_states and link_states in simulated time [Hz]; 0: one a step, as in
            Gazebo.
        seed: of all sensor noise.
        monotonic_clock: a reset does not set simulated time back to 0.
        missing_packages: of a URDF's package://NAME: refuse: it is not spawned, as in Gazebo; warn:
            it is spawned without what is missing; for launch files that do not pass it on, the
            environment variable PADDOCK_MISSING_PACKAGES.
        massless_links: of a URDF: leave_out: with all behind them, as in Gazebo; keep: with a small
            mass; for launch files that do not pass it on, the environment variable
            PADDOCK_MASSLESS_LINKS.
        step_timeout: wall time that /gazebo/step waits for commands [s].
        niceness: of the simulation thread and the node's session, where that is allowed; 0: none;
            for launch files that do not pass it on, the environment variable PADDOCK_NICENESS.
        enable_ros_network: False: neither the topics nor the services below the node's name.
        max_mesh_bytes, max_text_bytes, max_pattern_bytes, max_image_pixels: of the files that
            descriptions, worlds and parameters name, see bullet_sim.files.LIMITS.
    """

    world_file: str = text("", empty=True)
    paused: bool = flag(False)
    real_time_factor: float = number(1.0, min=0.0)
    world_pace: bool = False
    lockstep: bool = flag(False)
    every_picture: bool = flag(False)
    solver: str = choice("ode", SOLVERS)
    fixed_joints: str = choice("keep", FIXED_JOINTS)
    renderer: str = choice("auto", RENDERERS)
    shadows: str = choice("auto", SWITCHES)
    antialias: str = choice("auto", SWITCHES)
    labels: bool = flag(False)
    clock_rate: float = number(0.0, unit="Hz", name="pub_clock_frequency")
    states_rate: float = number(0.0, min=0.0, unit="Hz", name="pub_states_frequency")
    seed: int = number(0)
    monotonic_clock: bool = flag(False)
    missing_packages: str = choice("refuse", MISSING_PACKAGES)
    massless_links: str = choice(LEAVE_OUT, MASSLESS)
    step_timeout: float = number(10.0, min=0.0, unit="s")
    niceness: int = number(-10, min=-20, max=0)
    enable_ros_network: bool = flag(True)
    max_mesh_bytes: float = number(LIMITS["mesh_bytes"], min=1.0)
    max_text_bytes: float = number(LIMITS["text_bytes"], min=1.0)
    max_pattern_bytes: float = number(LIMITS["pattern_bytes"], min=1.0)
    max_image_pixels: float = number(LIMITS["image_pixels"], min=1.0)

    def __post_init__(self) -> None:
        check(self, prefix="parameter ")


def parse_config(get: Callable[[str, Any], Any]) -> Config:
    """Config from a function get(name, default).

    Raises:
        ValueError: names the parameter, the value and what is valid.
    """
    given: dict[str, Any] = {
        name: os.environ.get(f"PADDOCK_{name.upper()}") or getattr(Config, name)
        for name in ("solver", "fixed_joints", "niceness", "missing_packages", "massless_links")
    }
    for name, default in LIMITS.items():
        given[f"max_{name}"] = os.environ.get(variable_of(name)) or default
    for name, value in given.items():
        if isinstance(value, str) and value.lstrip("-").isdigit():
            given[name] = int(value)
    pace: Any = os.environ.get("PADDOCK_REAL_TIME_FACTOR")
    if pace:
        with suppress(ValueError):  # else it is named as what it is
            pace = float(pace)
        given["real_time_factor"] = pace
    config = read(Config, lambda n, d: get(n, given.get(n, d)), prefix="")
    return replace(
        config,
        world_pace=get("real_time_factor", None) is None and "real_time_factor" not in given,
        paused=config.paused or config.lockstep,
        clock_rate=max(0.0, config.clock_rate),
        seed=int(config.seed),
        niceness=int(config.niceness),
    )


def start_relay() -> Relay | None:
    """The Relay, or None if it does not start."""
    try:
        return Relay()
    except OSError as error:
        rospy.logwarn("the relay does not start: %s; the bridge sends directly", error)
        return None


def end(reason: str) -> None:
    """End the node with a reason, from any thread."""
    rospy.logfatal("%s", reason)
    rospy.signal_shutdown(reason)


def main() -> int:
    """Run the node `gazebo`; returns 1 after logging the reason when it cannot start or go on."""
    keep_python_output()
    tolerate_log_errors()
    # A subscription to its /clock would cost a socket and a thread: SimClock sets the time.
    nodes.init_interruptible("gazebo", disable_rostime=True)
    exit_with_roslaunch()
    master = ShutdownMonitor(end)
    master.start()
    ended = nodes.end_at_latest(END_LIMIT, lambda: 1 if master.reason else 0)
    with ExitStack() as parts:
        try:
            make_server(parts).run()
        except (SimError, ValueError) as error:
            rospy.logfatal("%s", error)
            return 1
        finally:
            ended.set()
            master.close()
    return 1 if master.reason else 0


def make_world(config: Config) -> World:
    """An empty world; its solver is compiled.

    Raises:
        SimError: the solver cannot be loaded; no other one takes its place.
    """
    world = World(
        solver=config.solver,
        fixed_joints=config.fixed_joints,
        massless_links=config.massless_links,
    )
    if not world.engine.is_compiled():
        rospy.loginfo("the solver is being compiled, once; it takes a minute or two")
    world.engine.compile()
    return world


def make_server(parts: ExitStack) -> Server:
    """Make everything that the node's parameters request.

    Args:
        parts: ExitStack that closes it, in reverse order.
    """
    config = parse_config(lambda name, default: rospy.get_param(f"~{name}", default))
    for name in LIMITS:  # also of the processes that it starts
        os.environ[variable_of(name)] = str(int(getattr(config, f"max_{name}")))
    world = make_world(config)
    parts.callback(world.close)
    world.on_implausible = rospy.logerr
    publishing.set_lockstep(config.lockstep)
    relay = None if config.lockstep else start_relay()
    if relay is not None:
        parts.callback(relay.close)
    publishing.set_relay(relay)
    resolve = Resolver(RosPackages())
    extensions = Extensions()
    extensions.enter()
    cpp.use(users_libraries())
    described = load_world(world, config.world_file, resolve)
    if config.world_pace and described is not None:
        config = replace(config, real_time_factor=described.real_time_factor)
    jobs = JobQueue()
    rospy.on_shutdown(jobs.close)
    cameras = make_cameras(world, config)
    parts.callback(cameras.close)
    received = ReceivedCounts()
    robots = Robots(jobs, world, cameras, config.seed, received, extensions)
    set_time = set_process_time if uses_sim_time() else None
    clock = SimClock(config.clock_rate, world.time_step, set_time=set_time, latch=config.lockstep)
    server = Server(world, jobs, robots, config, clock, relay=relay)
    advertise(config, world, jobs, robots, server, resolve, described)
    if config.enable_ros_network or config.lockstep:
        StepService(jobs, server, received, config.step_timeout)
    remove = functools.partial(remove_model, world, jobs, robots)
    make_models_by(Models(world, robots.connect, remove))
    if described is not None:
        load_world_plugins(world, described)
    robots.connect_world_models()
    if described is not None and "gazebo_ros_link_attacher" in described.plugins:
        LinkAttacher(world, jobs)
    factor = config.real_time_factor
    pace = f"real time x {factor:g}" if factor else "as fast as possible"
    rospy.loginfo("world '%s' is up: step %g s, %s", world.name, world.time_step, pace)
    return server


def advertise(
    config: Config,
    world: World,
    jobs: JobQueue,
    robots: Robots,
    server: Server,
    resolve: Resolver,
    described: WorldDescription | None,
) -> None:
    """Advertise what is below the node's name, unless enable_ros_network is false."""
    if not config.enable_ros_network:
        rospy.loginfo("ROS topics and services of the world are disabled (enable_ros_network)")
        return
    missing = resolve.missing_package if config.missing_packages == "refuse" else lambda text: None
    rate, prefix = config.states_rate, rospy.get_name()
    GazeboServices(world, jobs, robots, server, resolve, rate, prefix, missing)
    advertise_json("~statistics", jobs, server.statistics)
    advertise_json("~describe", jobs, Describer(world, robots, described).describe)
    advertise_views(world, jobs, server)


def load_world_plugins(world: World, described: WorldDescription) -> None:
    """Load the world's plugins in C++, before those of its models; errors are logged."""
    for spec in described.cpp_plugins:
        try:
            host_of(world).load(spec, None)
        except SimError as error:
            rospy.logerr("world '%s': %s", world.name, error)


def uses_sim_time() -> bool:
    """Whether nodes have simulated time; sets it, as gazebo_ros does, where nobody has said so."""
    if not rospy.has_param("/use_sim_time"):
        rospy.set_param("/use_sim_time", True)
    return is_true(rospy.get_param("/use_sim_time"))


def advertise_views(world: World, jobs: JobQueue, server: Server) -> None:
    """Advertise what pages show: see WorldViews."""
    views = WorldViews(world)

    def view() -> dict[str, Any]:
        return {**views.view(), "paused": server.paused, "pace": server.real_time_factor}

    advertise_json("~scene", jobs, views.scene)
    advertise_json("~view", jobs, view)
    advertise_json("~contacts", jobs, views.contacts)


def make_cameras(world: World, config: Config) -> Cameras:
    """The Cameras, with labels where they are requested."""
    wait = config.lockstep or config.every_picture
    quality = Quality(config.shadows, config.antialias)
    cameras = Cameras(config.renderer, wait, quality, lambda: world.scene)
    if config.labels:
        cameras.publish_labels(lambda: {m.source.key: m.name for m in world.models.values()})
    return cameras


if __name__ == "__main__":
    sys.exit(main())
