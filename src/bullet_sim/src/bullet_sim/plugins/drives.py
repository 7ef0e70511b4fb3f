"""Drives: wheels on two sides, bases that move exactly."""

from __future__ import annotations

import math
import operator
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, TypeVar

from bullet_sim.component import Stateful
from bullet_sim.controllers import MAX_COMMAND
from bullet_sim.engine.quickstep.law import ahead
from bullet_sim.parts.base import Part, part_of
from bullet_sim.parts.outputs import BaseOutput, JointStatesOutput, TransformsOutput
from bullet_sim.parts.schedule import NEVER, BatchSchedule, Schedule, whole_rate
from bullet_sim.plugins.joints import movable
from bullet_sim.plugins.registry import model_plugin
from bullet_sim.plugins.rules import BASE, UTILS_OF_MODELS, FrameName
from bullet_sim.plugins.spec import PluginSpec, frame_of, number, read, topic_of
from bullet_sim.plugins.xml import PluginXml
from bullet_sim.pose import Motion, Pose, Vec3, quaternion_from_yaw, rpy_from_quaternion

PLANAR = (1e-5, 1e-5, 1e12, 1e12, 1e12, 1e-3)  # variances of a base's pose
NO_COVARIANCE = (0.0,) * 6
NEARLY = 0.01  # [m/s] by which a rim may lack speed
LOG_LEVELS = ("DEBUG", "INFO", "WARN", "ERROR", "FATAL")


@dataclass(frozen=True)
class BaseSpec(PluginSpec):
    """A base that takes velocity commands and publishes its odometry.

    Attributes:
        link: root link, whose pose the odometry reports.
        command_topic, topic: of velocity commands and of odometry.
        frame_id, child_frame_id: of the odometry.
        pose_covariance, twist_covariance: diagonals of the odometry's.
    """

    command_topic: str = topic_of("commandTopic", "cmd_vel")
    topic: str = topic_of("odometryTopic", "odom")
    frame_id: str = frame_of("odometryFrame", "odom")
    child_frame_id: str = frame_of("robotBaseFrame", "base_footprint")
    pose_covariance: tuple[float, ...] = PLANAR
    twist_covariance: tuple[float, ...] = NO_COVARIANCE


@dataclass(frozen=True)
class SidesSpec(BaseSpec):
    """A base with wheels on two sides.

    Attributes:
        left, right: joints of each side that get that side's speed.
        separation: between the sides [m].
        diameter: of the wheels [m].
        rate: of commands to the wheels and of odometry [Hz].
        publish_odometry, publish_tf: publish the odometry, and its transform on /tf.
        resets: a reset of its model drops its command and restarts its odometry.
    """

    left: tuple[str, ...] = ()
    right: tuple[str, ...] = ()
    separation: float = number("wheelSeparation", 0.34)
    diameter: float = number("wheelDiameter", 0.15)
    rate: float = number("updateRate", 100.0)
    publish_odometry: bool = True
    publish_tf: bool = True
    resets: bool = False


@dataclass(frozen=True)
class WheelDriveSpec(SidesSpec):
    """libgazebo_ros_diff_drive and _skid_steer_drive: velocity commands to wheels, odometry.

    Attributes:
        publish_odometry: False: neither odometry nor its transform.
        torque: maximum of a wheel [N m]; a negative one counts as 0, as in ODE.
        acceleration: of a wheel's rim [m/s^2]; 0: unlimited.
        from_wheels: odometry by the wheels' angles, from zero; else the true pose.
        flat: the height of the odometry is 0.
        wheel_states_topic: of JointState with the wheels' positions; empty: none.
        wheel_frames: joint -> (parent, child), for the wheels' transforms on /tf; empty: none.
    """

    NAME = "drive"
    torque: float = 5.0
    acceleration: float = 0.0
    from_wheels: bool = False
    flat: bool = False
    wheel_states_topic: str = ""
    wheel_frames: Mapping[str, tuple[str, str]] = field(default_factory=dict)


@model_plugin("gazebo_ros_planar_move", rule=BASE)
@dataclass(frozen=True)
class PlanarMoveSpec(BaseSpec):
    """libgazebo_ros_planar_move: a model that follows its velocity commands exactly.

    Attributes:
        rate: of odometry [Hz].
        timeout: without a command after which it stops [s]; negative: never.
    """

    NAME = "planar_move"
    rate: float = number("odometryRate", 20.0)
    timeout: float = number("cmdTimeout", -1.0)


def read_log_level(xml: PluginXml) -> None:
    """Read <rosDebugLevel>, as the plugins do that share upstream's GazeboRos; the last counts."""
    level = xml.text("rosDebugLevel").upper()
    if level in LOG_LEVELS:
        xml.model.log_level = level


@model_plugin("gazebo_ros_diff_drive", rule=UTILS_OF_MODELS)
def diff_drive(xml: PluginXml) -> WheelDriveSpec | None:
    """WheelDriveSpec; <publishTf> false switches the odometry off, too, as upstream.

    <legacyMode>, which once swapped the joints, is no more since gazebo_plugins 2.8.3.
    """
    read_log_level(xml)
    left, right = (
        xml.in_scope(xml.text(f"{side}Joint", f"{side}_joint")) for side in ("left", "right")
    )
    return with_wheels(
        WheelDriveSpec,
        xml,
        (left,),
        (right,),
        torque=max(0.0, xml.number("wheelTorque", 5.0)),
        publish_odometry=xml.switch("publishTf", True),
        publish_tf=xml.option("publishOdomTF", True),
        wheel_states_topic=wheel_states_topic(xml),
        resets=True,
        wheel_frames=link_frames(xml, (right, left)) if xml.option("publishWheelTF") else {},
        acceleration=xml.number("wheelAcceleration"),
        from_wheels=xml.text("odometrySource") == "encoder",
    )


@model_plugin("gazebo_ros_skid_steer_drive", rule=BASE)
def skid_steer(xml: PluginXml) -> WheelDriveSpec | None:
    left, right = (
        tuple(
            xml.in_scope(xml.text(f"{side}{end}Joint", f"{side}_{end.lower()}_joint"))
            for end in ("Front", "Rear")
        )
        for side in ("left", "right")
    )
    along, across, turning = (
        xml.number(f"covariance_{name}", default)
        for name, default in (("x", 1e-4), ("y", 1e-4), ("yaw", 1e-2))
    )
    covariance = (along, across, *PLANAR[2:5], turning)
    return with_wheels(
        WheelDriveSpec,
        xml,
        left,
        right,
        separation=xml.number("wheelSeparation", 0.4),
        torque=max(0.0, xml.number("torque", 5.0)),
        publish_tf=xml.switch("broadcastTF"),
        pose_covariance=covariance,
        twist_covariance=covariance,
        flat=True,
    )


def link_frames(xml: PluginXml, joints: Sequence[str]) -> dict[str, tuple[str, str]]:
    """Joint -> frames of its parent and its child, as the links are called in Gazebo."""
    frames: dict[str, tuple[str, str]] = {}
    for name in joints:
        joint = xml.model.joints.get(name)
        if joint is not None:
            parent, child = (
                FrameName(xml.merged(link), xml.names.prefix())
                for link in (joint.parent, joint.child)
            )
            frames[name] = parent, child
    return frames


def wheel_states_topic(xml: PluginXml) -> str:
    """Of JointState of the wheels; empty: none."""
    return xml.names.topic("joint_states") if xml.option("publishWheelJointState") else ""


S = TypeVar("S", bound=BaseSpec)  # with wheels: left, right, separation, diameter


def with_wheels(
    kind: type[S], xml: PluginXml, left: tuple[str, ...], right: tuple[str, ...], **given: Any
) -> S | None:
    """A specification; None, with a warning, without the joints, or where it would divide by 0."""
    wheels = (*left, *right)
    if len(movable(xml, wheels)) < len(wheels):
        return None
    spec: Any = read(kind, xml, left=left, right=right, **given)
    if spec.diameter and (spec.separation or not getattr(spec, "from_wheels", False)):
        return spec
    xml.warn(
        f"{xml.label} has wheelSeparation {spec.separation} and wheelDiameter {spec.diameter}, "
        "must not be 0; it is left out"
    )
    return None


class DrivenBase(Part):
    """Takes velocity commands, publishes nav_msgs/Odometry and its transform.

    A command acts from the next update until the next command, as in Gazebo's plugins. One that
    comes before the first update (the world is paused, other plugins are being loaded) counts.

    Attributes:
        standing: the command for no motion.
        advertises: its topic is there without odometry, too.
    """

    STATE: ClassVar[tuple[str, ...]] = ("_command", "_before")
    COMMANDS: ClassVar[Mapping[str, tuple[Any, str]]] = {
        "command_topic": ("geometry_msgs/Twist", "_on_command")
    }
    reports = True
    standing: ClassVar[tuple[float, ...]] = (0.0, 0.0)
    advertises: ClassVar[bool] = False

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        self._sender = self.output(self._odometry(self.spec))

    def _sends(self) -> tuple[bool, bool]:
        """Whether it sends odometry, and its transform."""
        return True, True

    def _odometry(self, spec: Any) -> BaseOutput:
        """Of a specification; upstream advertises /tf in any case."""
        with_odometry, with_transform = self._sends()
        return BaseOutput(
            spec.topic if with_odometry or self.advertises else "",
            spec.frame_id,
            spec.child_frame_id,
            spec.pose_covariance,
            spec.twist_covariance,
            with_transform,
            with_odometry=with_odometry,
        )

    def start(self, time: float) -> None:
        """The next update is the first."""
        self._before = time

    def reset(self, time: float) -> None:
        """Without a command."""
        self._command = self.standing
        super().reset(time)

    def _values(self, message: Any) -> tuple[float, ...]:
        """The command in a geometry_msgs/Twist: forward [m/s], yaw rate [rad/s]."""
        return message.linear.x, message.angular.z

    def _on_command(self, message: Any) -> None:
        values = self._values(message)
        if all(abs(value) <= MAX_COMMAND for value in values):
            self._command = values
            return
        self.log_error(
            f"{self.spec.command_topic}: command {values}, must be finite numbers, at most "
            f"{MAX_COMMAND:g} either way; the last valid one is kept",
            every=1.0,
        )

    def _elapsed(self, time: float) -> float:
        """Time since the last update [s]."""
        before, self._before = self._before, time
        return time - before

    def _motion(self) -> Any:
        """The model's pose; its velocity along the axes of its heading, yaw rate in the world."""
        return planar_motion(self.model.motion())

    def _frames_of(
        self, frames: Iterable[tuple[str, tuple[str, str]]]
    ) -> list[tuple[str, str, Pose]]:
        """Transforms of joints, each with (frame, child frame): the poses of the joints' children
        in the model, as upstream, whatever the frame is."""
        root, joints = self.model.pose.inverse(), self.model.description.joints
        return [
            (frame, child, root * self.model.link_state(joints[name].child)[0])
            for name, (frame, child) in frames
        ]


class WheelDrive(Stateful):
    """Wheel speeds of both sides for a command, and odometry from the wheels' angles."""

    STATE = ("_speeds", "_angles", "_pose2d", "_twist")

    def __init__(self, spec: WheelDriveSpec) -> None:
        self._spec = spec
        self.restart()

    def restart(self) -> None:
        """Restart at rest, odometry at zero."""
        self._speeds = (0.0, 0.0)  # of the rims, left and right, with the acceleration limit [m/s]
        self._angles: tuple[float, float] | None = None
        self._pose2d = (0.0, 0.0, 0.0)  # x, y [m], yaw [rad]
        self._twist = (0.0, 0.0)  # forward [m/s], yaw rate [rad/s]

    def wheel_speeds(
        self, forward: float, turn: float, elapsed: float, turning: tuple[float, float]
    ) -> tuple[float, float]:
        """Speeds [rad/s] of the left and the right wheels.

        As upstream the acceleration limit adds up what the wheels lack, and there is none while
        either side is as fast as commanded.

        Args:
            forward: commanded speed [m/s].
            turn: commanded yaw rate [rad/s], left positive.
            elapsed: simulated time since the last call [s], for the acceleration limit.
            turning: present speeds [rad/s] of a left and a right wheel.
        """
        radius, half = self._spec.diameter / 2.0, turn * self._spec.separation / 2.0
        left, right = wanted = forward - half, forward + half
        lacks = [speed - rate * radius for speed, rate in zip(wanted, turning)]
        if self._spec.acceleration != 0.0 and min(map(abs, lacks)) >= NEARLY:
            change = self._spec.acceleration * elapsed
            left, right = self._speeds = (
                self._speeds[0] + _limited(lacks[0], change, lacks[0] >= 0.0),
                self._speeds[1] + _limited(lacks[1], change, lacks[1] > 0.0),
            )
        return left / radius, right / radius

    def measure(self, left: float, right: float, turning: tuple[float, float]) -> None:
        """Update with the angles [rad] and the speeds [rad/s] of a left and a right wheel."""
        radius, separation = self._spec.diameter / 2.0, self._spec.separation
        if self._angles is not None:
            by_left = (left - self._angles[0]) * radius
            by_right = (right - self._angles[1]) * radius
            forward, turned = (by_left + by_right) / 2.0, (by_right - by_left) / separation
            x, y, yaw = self._pose2d
            mean_yaw = yaw + turned / 2.0
            self._pose2d = (
                x + forward * math.cos(mean_yaw),
                y + forward * math.sin(mean_yaw),
                yaw + turned,
            )
        self._angles = left, right
        slow, fast = (speed * radius for speed in turning)
        self._twist = abs(slow + fast) / 2.0, (fast - slow) / separation

    @property
    def pose(self) -> Pose:
        """Pose in the odometry frame by the wheels."""
        x, y, yaw = self._pose2d
        return Pose((x, y, 0.0), quaternion_from_yaw(yaw))

    @property
    def twist(self) -> tuple[Vec3, Vec3]:
        """Linear (3,) [m/s] and angular (3,) [rad/s] velocity by the wheels, base's axes.

        As upstream the linear one has no sign: backwards, too, it is positive.
        """
        forward, turn = self._twist
        return (forward, 0.0, 0.0), (0.0, 0.0, turn)


def _limited(lack: float, change: float, upwards: bool) -> float:
    """The part of a lack of speed [m/s] that a limited change makes up for."""
    return min(lack, change) if upwards else max(lack, -change)


@part_of(WheelDriveSpec)
class WheelDrivePlugin(DrivenBase):
    """Drives the wheels by geometry_msgs/Twist.

    Without a Reset() of its source, as skid_steer's, it goes on as it was once its time has come.
    """

    STATE: ClassVar[tuple[str, ...]] = ("_drive",)
    waits_for_time = True

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        spec = self.spec
        self._drive = WheelDrive(spec)
        topic = spec.wheel_states_topic
        names = self._wheel_names = (*spec.right, *spec.left)  # in upstream's order
        self._wheel_states = self._wheel_frames = None
        if topic:
            self._wheel_states = self.output(JointStatesOutput(topic, names, ("position",)))
        if spec.wheel_frames:
            self._wheel_frames = self.output(TransformsOutput())

    def _sends(self) -> tuple[bool, bool]:
        spec = self.spec
        return spec.publish_odometry, spec.publish_odometry and spec.publish_tf

    def start(self, time: float) -> None:
        """Odometry at zero."""
        super().start(time)
        self._drive.restart()

    def prepare(self) -> None:
        """The wheels are braked until the first update."""
        self._turn((0.0, 0.0))

    def _turn(self, speeds: tuple[float, float]) -> None:
        for wheels, speed in zip((self.spec.left, self.spec.right), speeds):
            for wheel in wheels:
                self.model.joints.set_motor(wheel, speed, self.spec.torque)

    def update(self, time: float, period: float) -> None:
        elapsed = self._elapsed(time)
        forward, yaw_rate = self._command
        joints, turning = self.model.joints, (0.0, 0.0)
        ends = self.spec.left[0], self.spec.right[0]
        if self.spec.from_wheels or self.spec.acceleration:
            left, right = joints.velocities_of(ends)
            turning = left, right
        self._turn(self._drive.wheel_speeds(forward, yaw_rate, elapsed, turning))
        if self.spec.from_wheels:
            left, right = joints.positions_of(ends)
            self._drive.measure(left, right, turning)
        self._publish_wheels(time)
        if self._sender.has_subscribers():
            position, orientation, linear, angular = self._motion()
            self._sender.send(time, position, orientation, linear, angular, flat=self.spec.flat)

    def _publish_wheels(self, time: float) -> None:
        """Positions of the wheels, and their frames below the links that carry them."""
        names, frames = self._wheel_names, self.spec.wheel_frames
        if self._wheel_states is not None and self._wheel_states.has_subscribers():
            self._wheel_states.send(time, self.model.joints.positions_of(names))
        if self._wheel_frames is not None and self._wheel_frames.has_subscribers():
            self._wheel_frames.send(time, self._frames_of((name, frames[name]) for name in names))

    def _motion(self) -> Any:
        """Position, orientation in the odometry's frame, linear and angular in the base's."""
        if self.spec.from_wheels:
            pose = self._drive.pose
            return (pose.position, pose.orientation, *self._drive.twist)
        return super()._motion()


def planar_motion(motion: Motion) -> Motion:
    """A base's pose as it is; of its velocity what is along its heading and to its left, and the
    yaw rate in the world, which is all that upstream's odometry has."""
    position, orientation, linear, angular = motion
    along = along_heading(rpy_from_quaternion(orientation)[2], linear[0], linear[1])
    return position, orientation, along, (0.0, 0.0, angular[2])


def along_heading(yaw: float, x: float, y: float) -> Vec3:
    """A horizontal velocity (x, y) [m/s] of the world, ahead and to the left of a heading [rad]."""
    c, s = math.cos(yaw), math.sin(yaw)
    return c * x + s * y, c * y - s * x, 0.0


@part_of(PlanarMoveSpec)
class PlanarMovePlugin(DrivenBase):
    """Sets the model's velocity in every step; publishes Odometry and its transform.

    Upstream sets the vertical velocity and the others of rotation to zero, so does this. The
    odometry's twist is the way since its last message over the time.
    """

    STATE: ClassVar[tuple[str, ...]] = ("_since", "_new", "_due", "_last")
    every_step = goes_on = True
    resets = False
    standing = (0.0, 0.0, 0.0)

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        world = self.world
        self._due = Schedule(self._odometry_rate(), world.time_step, world.step_count)
        if self.goes_on:
            self.schedule = BatchSchedule(world, self._needed, lambda: self.start(world.time))

    def _odometry_rate(self) -> float:
        step, rate = self.world.time_step, self.spec.rate
        return whole_rate(rate, step, operator.gt) if rate > 0.0 else 1.0 / step

    def on_time_step(self) -> None:
        """As ModelPlugin; and the odometry's."""
        super().on_time_step()
        self._due.set_step(self.world.time_step, self._odometry_rate(), self.world.step_count)

    def start(self, time: float) -> None:
        """Messages from now on."""
        super().start(time)
        self._due.restart(self.world.step_count)
        self._last = (time, *self._place())  # of the last message

    def _place(self) -> tuple[float, float, float]:
        """x, y [m] and yaw [rad] of the model."""
        position, orientation = self.model.motion()[:2]
        return position[0], position[1], rpy_from_quaternion(orientation)[2]

    def _moved(self, time: float, yaw_rate: float) -> tuple[Vec3, Vec3]:
        """Velocity [m/s] along the heading, yaw rate [rad/s], means since the last message.

        Args:
            yaw_rate: commanded; where half a turn or more would pass the messages' time, it counts.
        """
        before, (x, y, yaw) = self._last, self._place()
        self._last = (time, x, y, yaw)
        elapsed = time - before[0]
        if elapsed <= 0.0:
            return (0.0, 0.0, 0.0), (0.0, 0.0, yaw_rate)
        u, v = (x - before[1]) / elapsed, (y - before[2]) / elapsed
        if yaw_rate <= math.pi / elapsed:
            yaw_rate = math.remainder(yaw - before[3], 2.0 * math.pi) / elapsed
        return along_heading(yaw, u, v), (0.0, 0.0, yaw_rate)

    def go_back(self, time: float) -> None:
        """It drives on; odometry waits for its time of before."""
        self.schedule.restart(self.world.step_count)

    def reset(self, time: float) -> None:
        """Without a command."""
        super().reset(time)
        self._since: float | None = None
        self._new = False

    def _needed(self) -> int:
        """Step after which it has something to do but to go on."""
        world, step = self.world, self.world.step_count + 1
        if self._new or not (self.model.body.is_held and world.makes_steps_at_once):
            return step
        if self._since is not None and self.spec.timeout >= 0.0 and any(self._command):
            late = math.ceil((self._since + self.spec.timeout) / world.time_step) - 1
            while not self._is_late(late * world.time_step):
                late += 1
        else:
            late = NEVER
        return max(step, min(late, self._due.next if self.spec.rate > 0.0 else NEVER))

    def _is_late(self, time: float) -> bool:
        """Whether the last command counts no more."""
        return 0.0 <= self.spec.timeout < time - (time if self._since is None else self._since)

    def _values(self, message: Any) -> tuple[float, ...]:
        """Forward, to the left [m/s], yaw rate [rad/s]."""
        return message.linear.x, message.linear.y, message.angular.z

    def _on_command(self, message: Any) -> None:
        before = self._command
        super()._on_command(message)
        self._new |= self._command is not before

    def update(self, time: float, period: float) -> None:
        if self._new:
            self._since, self._new = time, False
        if self._is_late(time):
            self._command = self.standing
        position, orientation = self.model.motion()[:2]
        forward, left, yaw_rate = self._command
        i, j, k, w = orientation
        x, y = ahead(i, j, k, w, forward, left)
        self.model.body.set_velocity((x, y, 0.0), (0.0, 0.0, yaw_rate))
        if self.model.is_at_root:
            self.model.body.hold_velocity((forward, left, yaw_rate))
        if self.spec.rate > 0.0 and self._due.due(self.world.step_count):
            twist = self._moved(time, yaw_rate)
            self._sender.send(time, position, orientation, *twist, flat=True)
