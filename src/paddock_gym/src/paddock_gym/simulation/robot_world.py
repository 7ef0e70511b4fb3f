"""A world of robots with their topics, in one process, without ROS: what the bridge's node runs."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np
from bullet_sim.controllers import steer_bot
from bullet_sim.controllers.interfaces import GAINS, Registered, register
from bullet_sim.controllers.pid import parse_pid
from bullet_sim.description.model import STEER_BOT_SIM_TYPE
from bullet_sim.errors import SimError
from bullet_sim.formats.sdf.world import parse_model
from bullet_sim.formats.spawn_text import SpawnText
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.models.model import Model
from bullet_sim.parts.base import PARTS, PartContext, noise_seed
from bullet_sim.parts.outputs import Fields, Output
from bullet_sim.pose import Pose
from bullet_sim.render.request import CameraRequest, Frame
from bullet_sim.robots import Loop, Robot
from bullet_sim.world import World

from paddock_gym.errors import GymError
from paddock_gym.simulation.recipe import Recipe, Spawn
from paddock_gym.simulation.renderer import SceneRenderer


class Topic:
    """Keeps the last message that is sent on a topic, while it is observed.

    Attributes:
        time: of the message [s]; NaN: none since the start.
        fields: its arrays; those of zeros before the first one.
        observed: whether what is sent is kept; what nobody observes is not computed.
        owner: the part or controller's topics that sends.
    """

    def __init__(self, output: Output, owner: Any = None) -> None:
        self.output, self.owner, self.observed = output, owner, False
        self._values: tuple[Any, ...] | None = None
        self._options: dict[str, Any] = {}
        self.time = math.nan

    def has_subscribers(self) -> bool:
        """Whether it is observed."""
        return self.observed

    def send(self, time: float, *values: Any, **options: Any) -> None:
        """Keep a message of a simulated time [s]."""
        if self.observed:
            self.time, self._values, self._options = time, values, options

    def set_variances(self, *_: Any) -> None:
        """Covariances are not observed."""

    def clear(self) -> None:
        """Forget the message."""
        self.time, self._values = math.nan, None

    @property
    def fields(self) -> Fields:
        """Arrays of the message, see Output."""
        if self._values is not None:
            return self.output.fields(*self._values, **self._options)
        shapes = self.output.shapes().items()
        return {name: np.zeros(shape.shape, shape.dtype) for name, shape in shapes}


class Command(NamedTuple):
    """A topic that takes commands.

    Attributes:
        message: type of its messages.
        take: gets each one.
        owner: the part or the controller's topics.
        model: of the robot.
    """

    message: str
    take: Callable[[Any], None]
    owner: Any
    model: Model


class Cameras:
    """Renders the images of all cameras in this process.

    Args:
        world: whose models they show.
    """

    def __init__(self, world: World) -> None:
        self._world, self._cameras, self._due = world, {}, []  # type: ignore[var-annotated]
        self._renderer: SceneRenderer | None = None

    @property
    def renderer(self) -> SceneRenderer:
        """Made on first use."""
        if self._renderer is None:
            self._renderer = SceneRenderer(self._world)
        return self._renderer

    def add(self, camera: Any) -> None:
        """Add a CameraSensor."""
        self._cameras[camera.request.name] = camera

    def remove(self, camera: Any) -> None:
        """Remove it."""
        self._cameras.pop(camera.request.name, None)

    def request(self, request: CameraRequest) -> None:
        """Have an image rendered with the next flush()."""
        self._due.append(request)

    def flush(self) -> None:
        """Render what was requested, as the world is now."""
        due, self._due = self._due, []
        for request in due:
            rgb, depth = self.renderer.render_with_depth(request)
            frame = Frame(request.name, self._world.time, self._world.step_count, rgb, depth)
            self._cameras[request.name].publish_frame(frame)

    def close(self) -> None:
        """Free the renderer."""
        if self._renderer is not None:
            self._renderer.close()


class RobotLoop(Loop):
    """The loop over parts and controllers; a state that is no number ends it."""

    def cannot_publish(self, item: Any, error: Exception) -> None:
        raise GymError(
            f"model '{item.model.name}' cannot be measured at {self._world.time:.3f} s: {error}; "
            "its motion is not finite: look at its masses, inertias, gains and where it starts"
        ) from error


class RobotWorld:
    """A world of robots, stepped as the bridge steps it in lockstep.

    Args:
        recipe: what it is made of.

    Attributes:
        world: bullet_sim.world.World.
        topics: what is sent, by the topic's name.
        commands: what takes commands, by the topic's name.
        warnings: what was read otherwise than it stands, or left out.

    Raises:
        GymError: a model or a controller cannot be loaded.
    """

    def __init__(self, recipe: Recipe) -> None:
        self.recipe = recipe
        self.world = World(massless_links=recipe.massless_links, fixed_joints=recipe.fixed_joints)
        if not self.world.engine.is_compiled():
            text = "paddock: the solver is being compiled, once; it takes a minute or two"
            print(text, file=sys.stderr, flush=True)
        self.warnings: list[str] = []
        self.topics: dict[str, Topic] = {}
        self.commands: dict[str, Command] = {}
        self._parts: list[Any] = []
        self._robots: dict[str, Robot] = {}  # by the namespace of their controllers
        self.cameras = Cameras(self.world)
        self._loop = RobotLoop(self.world)
        self._actions = 0
        try:
            self.warnings += map(str, self.world.load(recipe.described_world()))
            for model in list(self.world.models.values()):
                self._connect(model, "")
            for spawn in recipe.spawns:
                self._connect(self._spawn(spawn), spawn.namespace)
            self._load_controllers()
        except SimError as error:
            self.close()
            raise GymError(str(error)) from error
        except BaseException:
            self.close()
            raise
        self.world.engine.unlocked = True  # one thread alone has this world
        self._loop.parts, self._loop.controls = tuple(self._parts), tuple(self._robots.values())
        if self.world.sort_before_start():
            self._loop.prepare()

    # making -----------------------------------------------------------------------------------
    def _spawn(self, spawn: Spawn) -> Model:
        text = SpawnText.read(spawn.text, spawn.namespace)
        if text.kind not in ("urdf", "sdf"):
            raise GymError(f"the root of '{spawn.name}' is <{text.tag}>, must be <robot> or <sdf>")
        resolve = self.recipe.resolve
        if text.kind == "urdf":
            massless = self.recipe.massless_links
            described = parse_urdf(text.text, resolve, spawn.name, massless)
            origin = described.origin
        else:
            label = f"SDF of '{spawn.name}'"
            described, origin = parse_model(text.text, resolve, label, spawn.name)
        pose = spawn.pose if text.takes_request else Pose()
        model = self.world.spawn(described, self._frame(spawn.frame) * pose * origin)
        self.warnings += map(str, described.warnings)
        if spawn.joints:
            model.joints.set_positions(dict(spawn.joints))
        return model

    def _frame(self, name: str) -> Pose:
        if name in ("", "world", "map", "/map"):
            return Pose()
        model, _, link = name.partition("::")
        found = self.world.model(model)
        return found.link_state(link)[0] if link else found.pose

    def _connect(self, model: Model, namespace: str) -> None:
        """Make a model's parts and controllers, as bullet_bridge.robots.Robots."""
        parts: list[Any] = []
        for index, spec in enumerate(model.description.sensors):
            kind = next((PARTS[base] for base in type(spec).__mro__ if base in PARTS), None)
            if kind is None or kind.needs_ros:
                self.warnings.append(f"model '{model.name}': {spec.name} acts with ROS alone")
                continue
            owner: list[Any] = []
            try:
                part = kind(
                    PartContext(
                        self.world,
                        model,
                        spec,
                        noise_seed(self.recipe.seed, model.name, index),
                        index,
                        self.cameras,
                        lambda output, owner=owner: self._topic(output, owner),
                    )
                )
            except (ValueError, ArithmeticError) as error:
                self.warnings.append(f"model '{model.name}': {spec.name} is left out: {error}")
                continue
            owner.append(part)
            part.reset(self.world.time)
            parts.append(part)
            for topic, (message, take) in part.commands().items():
                self._add_command(topic, Command(message, take, part, model))
        if model.manager is not None:
            own = model.description.control_namespace or namespace or model.name
            robot = Robot(self.world, model, own.strip("/"))
            if robot.namespace in self._robots:
                self.warnings.append(
                    f"model '{model.name}' has no controllers: another one's are in "
                    f"'{robot.namespace}'"
                )
            else:
                self._robots[robot.namespace] = robot
                self._set_hardware(robot)
        for part in parts:
            part.prepare()
        self._parts += parts

    def _topic(self, output: Output, owner: list[Any]) -> Topic:
        topic = Topic(output, owner)
        name = self.recipe.remaps.get(output.topic, output.topic)
        if name:
            self.topics.setdefault(name, topic)
            topic = self.topics[name] if type(self.topics[name].output) is type(output) else topic
        return topic

    def _add_command(self, topic: str, command: Command) -> None:
        self.commands[self.recipe.remaps.get(topic, topic)] = command

    def _set_hardware(self, robot: Robot) -> None:
        """The parameters of the hardware layer, as bullet_bridge.control.reconfigure."""
        hardware, model = robot.manager.hardware, robot.model
        if model.description.robot_sim_type == STEER_BOT_SIM_TYPE:
            where = f"{robot.namespace}/{steer_bot.NAMESPACE}"
            config = steer_bot.parse_steer_bot(
                self.recipe.parameter(where), where, model.joints.names, model.description
            )
            joints = steer_bot.SteerBotJoints(model.joints, config)
            hardware.put_before(joints, Registered(config.interfaces()))
            return
        description, limits = model.description, f"{robot.namespace}/joint_limits"
        registered = register(
            description.transmissions,
            description,
            model.joints.limits,
            self.recipe.parameter(limits),
        )
        hardware.set_registered(registered)
        self.warnings += [text for level, text in registered.messages if level != GAINS]
        where = f"{robot.namespace}/gazebo_ros_control/pid_gains"
        for joint, values in (self.recipe.parameter(where) or {}).items():
            try:
                hardware.set_gains(joint, parse_pid(values, f"{where}/{joint}", self.warnings))
            except SimError as error:
                self.warnings.append(f"{error}; the gains are not used")
        hardware.restart()

    def _load_controllers(self) -> None:
        """Load and start the controllers of the recipe."""
        for namespace, name in self.recipe.controllers:
            robot = self._robots.get(namespace) or self._only_robot(namespace)
            if robot is None:
                self.warnings.append(
                    f"controller '{namespace}/{name}' is left out: robots have controllers in "
                    f"{', '.join(map(repr, self._robots)) or 'no namespace'}"
                )
                continue
            robot.connect = lambda output, robot=robot: self._topic(output, [robot])
            try:
                robot.manager.load(name, self.recipe.parameter(f"{namespace}/{name}"))
                topics = robot.add(name)
                robot.manager.switch([name], [])
            except SimError as error:
                self.warnings.append(f"{error}; the controller is left out")
                continue
            for topic, (message, take) in topics.commands().items():
                self._add_command(topic, Command(message, take, topics, robot.model))

    def _only_robot(self, namespace: str) -> Robot | None:
        """Of plain files, whose controllers have no namespace: the only robot."""
        only = len(self._robots) == 1 and not namespace and len(self.recipe.spawns) == 1
        return next(iter(self._robots.values())) if only else None

    # time -------------------------------------------------------------------------------------
    def observe(self, names: Iterable[str]) -> None:
        """Keep what is sent on these topics."""
        for name in names:
            self.topics[name].observed = True
        self._start()

    def _start(self) -> None:
        """Have the subscriptions act, as the bridge's loop does when there are subscribers."""
        for robot in self._robots.values():
            robot.refresh()
        self._loop.first_due(check=True)

    def advance(self, steps: int) -> None:
        """Make physics steps; topics send what is due."""
        world, loop = self.world, self._loop
        end = world.step_count + steps
        while world.step_count < end:
            loop.apply_commands()
            due = loop.first_due(check=False)
            world.step(max(1, min(end, due) - world.step_count))
            loop.publish_due(world.step_count, world.time)
            self.cameras.flush()

    def measure(self) -> None:
        """Send all that is observed now, whatever is due; parts and controllers stay as they are.

        Used at a start, at which no message has come yet.
        """
        for part in self._parts:
            if any(sender.has_subscribers() for sender in part.senders) and not part.every_step:
                state = part.get_state()
                if not part.always:
                    part.start(self.world.time)
                part.update(self.world.time, 0.0)
                part.set_state(state)
        for robot in self._robots.values():
            state = robot.manager.get_state()
            for topics in robot.topics():
                topics.measure(self.world.time)
            robot.manager.set_state(state)
        self.cameras.flush()

    # states -----------------------------------------------------------------------------------
    def save(self) -> tuple[Any, ...]:
        """The state of everything."""
        schedules = [
            (schedule, schedule.get_state())
            for robot in self._robots.values()
            for topics in robot.topics()
            for schedule in topics.schedules
        ]
        parts = [(part, part.get_state()) for part in self._parts]
        return self.world.save_state(), parts, schedules

    def restore(self, state: tuple[Any, ...]) -> None:
        """Return to the result of save(), to the bit."""
        world, parts, schedules = state
        self.world.restore_state(world)
        for item, saved in (*parts, *schedules):
            item.set_state(saved)
        for robot in self._robots.values():
            robot.commands.clear()
        for topic in self.topics.values():
            topic.clear()

    def reseed(self, rng: np.random.Generator) -> None:
        """Give the noise of all parts new seeds."""
        for part in self._parts:
            part.rng = np.random.default_rng(int(rng.integers(2**63)))

    @property
    def robot_models(self) -> Mapping[str, Model]:
        """Models that take commands, by their names."""
        return {command.model.name: command.model for command in self.commands.values()}

    @property
    def controllers(self) -> list[tuple[str, str]]:
        """Namespace and name of each running controller."""
        return [
            (robot.namespace, config.name)
            for robot in self._robots.values()
            for _, config, state in robot.manager.list()
            if state == "running"
        ]

    def close(self) -> None:
        """Free engine and renderer."""
        self.cameras.close()
        self.world.close()
