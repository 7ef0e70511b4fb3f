"""Controllers' topics: commands in, states and odometry out; and a robot's controllers."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar, cast

from bullet_sim.controllers import Controller, drive, joint
from bullet_sim.controllers.trajectory import TrajectoryControl
from bullet_sim.errors import SimError
from bullet_sim.parts.outputs import BaseOutput, JointStatesOutput, Output, Sender
from bullet_sim.parts.schedule import NEVER, SubscribedSchedule
from bullet_sim.registry import ByClass

if TYPE_CHECKING:
    from bullet_sim.controllers.manager import Manager
    from bullet_sim.models.model import Model
    from bullet_sim.world import World

TOPICS: ByClass[type[Topics]] = ByClass()  # of classes of controllers
topics_for = TOPICS.enter


class Robot:
    """Controllers of one model, their commands and what they send.

    Args:
        namespace: e.g. '/racecar'.
        connect: makes what sends an Output.

    Attributes:
        commands: those that wait for the next step, by controller; written by other threads, one
            operation of the dict at a time.
        emergency_stop: the last message about one; None: it has been applied.
    """

    def __init__(
        self,
        world: World,
        model: Model,
        namespace: str,
        connect: Callable[[Output], Sender] | None = None,
    ) -> None:
        self.world, self.model, self.connect = world, model, connect
        self.manager = cast("Manager", model.manager)  # a model without one has no Robot
        self.namespace = "/" + namespace.strip("/") if namespace.strip("/") else ""
        self.commands: dict[str, Any] = {}
        self.emergency_stop: bool | None = None
        self._topics: dict[str, Any] = {}
        # Those of running controllers that publish, and their schedules.
        self._publishing: dict[str, Any] = {}
        self._schedules: list[tuple[bool, SubscribedSchedule]] = []

    def add(self, name: str) -> Topics:
        """Make the topics of a loaded controller."""
        controller = self.manager.get(name)
        topics = TOPICS.of(controller)(self, controller)
        self._topics[name] = topics
        return topics

    def topics(self) -> list[Any]:
        """Topics of all controllers."""
        return list(self._topics.values())

    def apply_commands(self) -> None:
        """Pass the latest commands to the controllers."""
        active, self.emergency_stop = self.emergency_stop, None
        if active is not None:
            self.manager.set_emergency_stop(active)
        for name in list(self.commands):
            try:
                self.manager.command(name, self.commands.pop(name))
            except SimError as error:
                self.refuse(error)

    def refuse(self, error: SimError) -> None:
        """Tell of a command that is not valid."""
        raise error

    def refresh(self) -> None:
        """Update which controllers run and publish, after some were loaded, started or stopped."""
        before, self._publishing = (
            self._publishing,
            {
                name: topics
                for name, topics in self._topics.items()
                if topics.is_periodic() and self.manager.is_running(name)
            },
        )
        for name, topics in self._publishing.items():
            if name not in before:
                topics.restart(self.world.step_count)
        self._schedules = [
            (topics.watches, schedule)
            for topics in self._publishing.values()
            for schedule in topics.schedules
        ]

    def schedules(self) -> list[tuple[bool, SubscribedSchedule]]:
        """Those of its messages, and whether making these only reads the state after a step."""
        return self._schedules

    def publish(self, step: int, time: float) -> None:
        """Send what is due."""
        for topics in self._publishing.values():
            topics.publish(step, time)

    def on_time_step(self) -> None:
        """Continue after a change of the physics step."""
        for topics in self._topics.values():
            topics.on_time_step()

    def restart(self, fresh: bool = True) -> None:
        """Restart the schedules after a reset; fresh: drop the commands that wait, too."""
        if fresh:
            self.commands.clear()
        for topics in self._topics.values():
            topics.restart(self.world.step_count, fresh)


class Topics:
    """Topics of one controller. The base class has none.

    Args:
        robot: of which the controller is one.

    Attributes:
        watches: see Part.watches; of its periodic messages.
        controller, config: the controller and its configuration.
        schedules: of what it publishes periodically.
        waiting: those of them that after simulated time went back are silent until their time of
            before has passed again, as upstream.
    """

    watches: ClassVar[bool] = False

    def __init__(self, robot: Any, controller: Any) -> None:
        self._robot, self.controller, self.config = robot, controller, controller.config
        self.schedules: list[SubscribedSchedule] = []
        self.waiting: list[SubscribedSchedule] = []
        self._asked: dict[SubscribedSchedule, float] = {}  # their rates [Hz]

    def output(self, output: Output) -> Any:
        """What sends on a topic, see Sender."""
        return self._robot.connect(output)

    def commands(self) -> dict[str, tuple[Any, Callable[[Any], None]]]:
        """Topics that it takes commands from: the type of the messages, what gets each one."""
        return {}

    def _every(self, rate: float, *senders: Sender) -> SubscribedSchedule:
        """A SubscribedSchedule [Hz] for senders, at most once per physics step."""
        return self._every_while(rate, lambda: any(each.has_subscribers() for each in senders))

    def _every_while(self, rate: float, has_subscribers: Callable[[], bool]) -> SubscribedSchedule:
        """As _every, due while has_subscribers() is true."""
        world = self._robot.world
        schedule = SubscribedSchedule(
            min(rate, 1.0 / world.time_step),
            world.time_step,
            world.step_count,
            has_subscribers,
        )
        self.schedules.append(schedule)
        self._asked[schedule] = rate
        return schedule

    @property
    def name(self) -> str:
        """Namespace of the controller."""
        return f"{self._robot.namespace}/{self.config.name}"

    def is_periodic(self) -> bool:
        """Whether it publishes periodically."""
        return bool(self.schedules)

    def publish(self, step: int, time: float) -> None:
        """Publish what is due; called only while the controller runs."""

    def measure(self, time: float) -> None:
        """Publish what its controller measures, due or not."""

    def on_time_step(self) -> None:
        """Continue after a change of the physics step."""
        for schedule in self.schedules:
            self._adjust(schedule)

    def _adjust(self, schedule: SubscribedSchedule) -> None:
        """Continue at the rate that is asked for, at most once per physics step."""
        world, rate = self._robot.world, self._asked[schedule]
        schedule.set_step(world.time_step, min(rate, 1.0 / world.time_step), world.step_count)

    def restart(self, step: int, fresh: bool = True) -> None:
        """Restart the schedules at a step, after a reset or a start; fresh: `waiting`, too."""
        for schedule in self.schedules:
            if fresh or schedule not in self.waiting:
                schedule.restart(step)


topics_for(TrajectoryControl, joint.SensorController)(Topics)  # the bridge alone has theirs


@topics_for(joint.JointState)
class JointStates(Topics):
    """sensor_msgs/JointState of a joint state controller."""

    watches = True

    def __init__(self, robot: Any, controller: Any) -> None:
        super().__init__(robot, controller)
        config = self.config
        hardware = robot.manager.hardware
        joints = config.joints or hardware.published_names
        self._numbers = [hardware.names.index(name) for name in joints]
        self._extra = [row for row in config.extra_joints if row[0] not in joints]
        names = (*joints, *(row[0] for row in self._extra))
        self._states = self.output(JointStatesOutput(f"{robot.namespace}/joint_states", names))
        self._schedule = self._every(config.publish_rate, self._states)
        self.waiting.append(self._schedule)

    def publish(self, step: int, time: float) -> None:
        """Publish joint states that are due."""
        if self._schedule.due(step):
            self.measure(time)

    def measure(self, time: float) -> None:
        columns = self._robot.manager.hardware.joints.columns(self._numbers)
        for number, column in enumerate(columns, 1):
            column += [row[number] for row in self._extra]
        self._states.send(time, *columns)


@topics_for(Controller)
class Commands(Topics):
    """std_msgs/Float64, or Float64MultiArray of several joints, into a controller."""

    topic: ClassVar[str] = "command"

    def commands(self) -> dict[str, tuple[Any, Callable[[Any], None]]]:
        """Its command topic."""
        return {f"{self.name}/{self.topic}": (self._message_type(), self._on_command)}

    def _message_type(self) -> Any:
        several = self.controller.group or len(self.config.joints) != 1
        return "std_msgs/Float64MultiArray" if several else "std_msgs/Float64"

    def _on_command(self, message: Any) -> None:
        data = message.data
        values = (data,) if isinstance(data, float) else tuple(data)
        self._robot.commands[self.config.name] = values


@topics_for(drive.Drive)
class Drive(Commands):
    """geometry_msgs/Twist into the controller of a base, odometry and its transform out."""

    topic = "cmd_vel"
    always_with_tf: ClassVar[bool] = False  # its transform may be switched on later

    def __init__(self, robot: Any, controller: Any) -> None:
        super().__init__(robot, controller)
        config = self.config
        with_tf = config.publish_tf or self.always_with_tf
        self._sender = self.output(
            BaseOutput(
                f"{self.name}/odom",
                config.odom_frame,
                config.base_frame,
                config.pose_covariance,
                config.twist_covariance,
                with_tf,
                advertises=False,
            )
        )
        self._schedule = self._every(config.publish_rate, self._sender)
        self.waiting.append(self._schedule)

    def _message_type(self) -> Any:
        return "geometry_msgs/Twist"

    def _on_command(self, message: Any) -> None:
        self._robot.commands[self.config.name] = (message.linear.x, message.angular.z)

    def publish(self, step: int, time: float) -> None:
        """Publish the odometry of this step."""
        if self._schedule.due(step):
            self.measure(time)

    def measure(self, time: float) -> None:
        self._robot.manager.observe()
        odometry = self.controller.odometry
        half = odometry.heading / 2
        position = (odometry.x, odometry.y, 0.0)
        orientation = (0.0, 0.0, math.sin(half), math.cos(half))
        linear, angular = (odometry.linear, odometry.lateral, 0.0), (0.0, 0.0, odometry.angular)
        with_tf = self.controller.config.publish_tf
        self._sender.send(time, position, orientation, linear, angular, with_transform=with_tf)


@topics_for(drive.DiffDrive)
class DiffDrive(Drive):
    """A Drive whose transform may be switched on."""

    always_with_tf = True


class Loop:
    """Controllers and parts of all models: updated and sent when they are due.

    Attributes:
        controls, parts: flat lists of them.
    """

    def __init__(self, world: World) -> None:
        self._world = world
        self.controls: tuple[Any, ...] = ()
        self.parts: tuple[Any, ...] = ()

    def apply_commands(self) -> None:
        """Pass the latest commands of all robots to their controllers."""
        for control in self.controls:
            control.apply_commands()

    def prepare(self) -> None:
        """Prepare models that were reloaded: what parts hold in them is gone."""
        for part in self.parts:
            part.prepare()

    def first_due(self, check: bool) -> int:
        """Physics step after which publish_due() has to be called at the latest, or infinity.

        Args:
            check: check for subscribers; False: as at the last check.
        """
        acting, watched, _ = self.next_steps(check)
        return min(acting, watched)

    def next_steps(self, check: bool) -> tuple[int, int, float]:
        """As first_due(), of what acts or reads more than the state after a step, and of what
        watches alone; the shortest period of the latter [steps]."""
        step = self._world.step_count
        schedules = [pair for control in self.controls for pair in control.schedules()]
        schedules += [(part.watches, part.schedule) for part in self.parts]
        due, period = [NEVER, NEVER], NEVER
        for watches, schedule in schedules:
            due[watches] = min(due[watches], schedule.next_due_subscribed(step, check))
            if watches and schedule.subscribed:
                period = min(period, schedule.period)
        telling = NEVER  # velocities, as they are before a part that comes later sets them
        for part in self.parts:
            if part.goes_on:
                due[0] = min(due[0], telling)
            elif part.tells_velocities and part.watches:
                telling = min(telling, part.schedule.next_due_subscribed(step, check=False))
        return due[0], due[1], period

    def publish_due(self, step: int, time: float) -> None:
        """Update and send what is due at this step."""
        for control in self.controls:
            try:
                control.publish(step, time)
            except (ValueError, ArithmeticError) as error:
                self.cannot_publish(control, error)
        for part in self.parts:
            if part.schedule.due(step):
                self.updates(part, step)
                self.run(part, part.update, time, time - part.updated)
                part.updated = time

    def run(self, part: Any, update: Callable[..., Any], *arguments: Any) -> Any:
        """Update a part, which may fail; what the update returns."""
        try:
            return update(*arguments)
        except (ValueError, ArithmeticError) as error:
            self.cannot_publish(part, error)
        except Exception as error:
            self.fail(part, error)
        return None

    def updates(self, part: Any, step: int) -> None:
        """A part is updated at a step."""

    def cannot_publish(self, item: Any, error: Exception) -> None:
        """A control or a part cannot send a state that is NaN or infinite."""
        raise error

    def fail(self, part: Any, error: Exception) -> None:
        """A part has raised an exception."""
        raise error
