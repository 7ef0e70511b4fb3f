"""Joint states, drives, planar move, joint poses, gains of a mimic."""

from __future__ import annotations

import math
import operator
from collections.abc import Iterable
from typing import Any, ClassVar

import rospy
from bullet_sim.controllers import MAX_COMMAND
from bullet_sim.controllers.drive import WheelDrive
from bullet_sim.controllers.pid import PidGains, parse_pid
from bullet_sim.errors import SimError
from bullet_sim.plugins import drives as specs
from bullet_sim.pose import Motion, Vec3, rpy_from_quaternion
from control_toolbox.cfg import ParametersConfig
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import JointState
from tf2_msgs.msg import TFMessage
from trajectory_msgs.msg import JointTrajectory

from bullet_bridge.loop.clock import Schedule, whole_rate
from bullet_bridge.plugins.base import (
    ModelPlugin,
    PluginContext,
    Preparing,
    Sensor,
    has_subscribers,
    ros_side,
)
from bullet_bridge.transport import conversions
from bullet_bridge.transport.packed import PackedBase, PackedJointState
from bullet_bridge.transport.pid_gains import on_change, values_of


@ros_side(specs.JointStatesSpec)
class JointStatesSensor(Sensor):
    """sensor_msgs/JointState of the named joints, without efforts."""

    message = JointState

    def __init__(self, context: PluginContext) -> None:
        super().__init__(context)
        names, joints = list(self.spec.joints), self.model.joints
        self._indices = [joints.names.index(name) for name in names]
        self._sender = PackedJointState(self.pub, names, with_efforts=False)

    def update(self, time: float, period: float) -> None:
        positions, velocities, _ = self.model.joints.columns(self._indices)
        self._sender.send(time, positions, velocities)


class DrivenBase(ModelPlugin):
    """Takes velocity commands, publishes nav_msgs/Odometry and its transform.

    A command acts from the next update until the next command, as in Gazebo's plugins. One that
    comes before the first update (the world is paused, other plugins are being loaded) counts.

    Attributes:
        standing: the command for no motion.
    """

    STATE: ClassVar[tuple[str, ...]] = ("_command", "_before")
    COMMANDS = {"command_topic": (Twist, "_on_command")}
    reports = True
    standing: ClassVar[tuple[float, ...]] = (0.0, 0.0)

    def __init__(self, context: PluginContext) -> None:
        super().__init__(context)
        spec = self.spec
        self._odometry = self._odometry_publisher()
        self._tf = self.publisher("/tf", TFMessage)  # which upstream advertises in any case
        self._sender = PackedBase(*self._outputs(), spec, (spec.frame_id, spec.child_frame_id))

    def _odometry_publisher(self) -> Any:
        return self.publisher(self.spec.topic, Odometry)

    def _outputs(self) -> tuple[Any, Any]:
        """Publishers of odometry and its transform, or None."""
        return self._odometry, self._tf

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
        rospy.logerr_throttle(
            1.0,
            f"{self.spec.command_topic}: command {values}, must be finite numbers, at most "
            f"{MAX_COMMAND:g} either way; the last valid one is kept",
        )

    def _elapsed(self, time: float) -> float:
        """Time since the last update [s]."""
        before, self._before = self._before, time
        return time - before

    def _motion(self) -> Any:
        """The model's pose; its velocity along the axes of its heading, yaw rate in the world."""
        return planar_motion(self.model.motion())

    def _frames_of(self, time: float, frames: Iterable[tuple[str, tuple[str, str]]]) -> TFMessage:
        """Transforms of joints, each with (frame, child frame): the poses of the joints' children
        in the model, as upstream, whatever the frame is."""
        root, joints = self.model.pose.inverse(), self.model.description.joints
        transforms = [
            conversions.transform_to_msg(
                time, frame, child, root * self.model.link_state(joints[name].child)[0]
            )
            for name, (frame, child) in frames
        ]
        return TFMessage(transforms)


@ros_side(specs.WheelDriveSpec)
class WheelDrivePlugin(DrivenBase):
    """Drives the wheels by geometry_msgs/Twist."""

    STATE: ClassVar[tuple[str, ...]] = ("_drive",)

    def __init__(self, context: PluginContext) -> None:
        super().__init__(context)
        spec = self.spec
        self._drive = WheelDrive(spec)
        topic = spec.wheel_states_topic
        self._wheel_states: Any = self.publisher(topic, JointState) if topic else None
        self._wheel_names = [*spec.right, *spec.left]  # in upstream's order

    def _odometry_publisher(self) -> Any:
        return super()._odometry_publisher() if self.spec.publish_odometry else None

    def _outputs(self) -> tuple[Any, Any]:
        with_tf = self.spec.publish_odometry and self.spec.publish_tf
        return self._odometry, self._tf if with_tf else None

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
        if any(map(has_subscribers, self._outputs())):
            position, orientation, linear, angular = self._motion()
            self._sender.send(time, position, orientation, linear, angular, flat=self.spec.flat)

    def _publish_wheels(self, time: float) -> None:
        """Positions of the wheels, and their frames below the links that carry them."""
        names, frames = self._wheel_names, self.spec.wheel_frames
        if has_subscribers(self._wheel_states):
            positions = list(self.model.joints.positions_of(names))
            header = conversions.header(time)
            self._wheel_states.publish(JointState(header=header, name=names, position=positions))
        if frames and has_subscribers(self._tf):
            self._tf.publish(self._frames_of(time, [(name, frames[name]) for name in names]))

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


@ros_side(specs.PlanarMoveSpec)
class PlanarMovePlugin(DrivenBase):
    """Sets the model's velocity in every step; publishes Odometry and its transform.

    Upstream sets the vertical velocity and the others of rotation to zero, so does this. The
    odometry's twist is the way since its last message over the time.
    """

    STATE: ClassVar[tuple[str, ...]] = ("_since", "_new", "_due", "_last")
    every_step = True
    resets = False
    standing = (0.0, 0.0, 0.0)

    def __init__(self, context: PluginContext) -> None:
        super().__init__(context)
        self._due = Schedule(self._odometry_rate(), self.world.time_step, self.world.step_count)

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
        if 0.0 <= self.spec.timeout < time - (time if self._since is None else self._since):
            self._command = self.standing
        position, orientation = self.model.motion()[:2]
        x, y, yaw_rate = self._command
        yaw = rpy_from_quaternion(orientation)[2]
        c, s = math.cos(yaw), math.sin(yaw)
        self.model.body.set_velocity((c * x - s * y, s * x + c * y, 0.0), (0.0, 0.0, yaw_rate))
        if self.spec.rate > 0.0 and self._due.due(self.world.step_count):
            twist = self._moved(time, yaw_rate)
            self._sender.send(time, position, orientation, *twist, flat=True)


@ros_side(specs.JointPosesSpec)
class JointPosesPlugin(ModelPlugin):
    """Puts joints to the points of a trajectory_msgs/JointTrajectory, one after the other.

    As upstream, each point waits for the time_from_start of the point before it, counted from then,
    and a trajectory whose frame_id is neither the world nor a link is refused.
    """

    STATE = ("_points", "_next")
    COMMANDS = {"topic": (JointTrajectory, "_on_trajectory")}
    every_step = True
    resets = False

    def __init__(self, context: PluginContext) -> None:
        super().__init__(context)
        self._points: list[tuple[dict[str, float], float]] = []
        self._next = 0.0

    def reset(self, time: float) -> None:
        """Without a trajectory."""
        super().reset(time)
        self._points, self._next = [], 0.0

    def needs_update(self) -> bool:
        """While there are points to come."""
        return bool(self._points)

    def _on_trajectory(self, message: Any) -> None:
        known, topic = set(self.model.joints.names), self.spec.topic
        points = []
        frame = message.header.frame_id
        if frame not in ("world", "map", "/map") and not self._is_link(frame):
            rospy.logerr("%s: frame_id '%s' is neither world nor map nor a link", topic, frame)
            return
        for point in message.points:
            values = dict(zip(message.joint_names, point.positions))
            if len(point.positions) < len(message.joint_names):
                rospy.logerr(
                    "%s: a point has %d positions, must have %d",
                    topic,
                    len(point.positions),
                    len(message.joint_names),
                )
                return
            mine = {name: value for name, value in values.items() if name in known}
            points.append((mine, point.time_from_start.to_sec()))
        self._next = max(message.header.stamp.to_sec(), self.world.time)
        self._points = points

    def _is_link(self, frame: str) -> bool:
        """Whether a frame is the name of one of the model's links, MODEL::LINK or LINK."""
        name = self.model.name
        return any(frame in (link, f"{name}::{link}") for link in self.model.rigid_parts)

    def update(self, time: float, period: float) -> None:
        if not self._points or time < self._next:
            return
        values, wait = self._points.pop(0)
        try:
            self.model.joints.set_positions(values)
        except SimError as error:
            rospy.logerr("%s: %s", self.spec.topic, error)
        self._next += wait


@ros_side(specs.MimicPidSpec)
class MimicPidPlugin(Preparing):
    """Gives a joint that follows another one the PID of its parameters, which can be changed.

    As upstream it moves freely without gains.
    """

    STATE = ("_gains",)

    def __init__(self, context: PluginContext) -> None:
        super().__init__(context)
        where = self.spec.topic
        values = rospy.get_param(where, None)
        if not isinstance(values, dict) or "p" not in values:
            rospy.logerr("No p gain specified for pid.  Namespace: %s", where)
            values = {"p": 0.0}
        warnings: list[str] = []
        try:
            gains = parse_pid(values, where, warnings)
        except SimError as error:
            gains = PidGains(0.0)
            warnings.append(f"{error}; the gains are 0")
        for text in warnings:
            rospy.logwarn("%s", text)
        self._gains = gains
        changed = on_change(where, gains, lambda new: self.call(lambda: self._set(new)))
        self.reconfigure(where, ParametersConfig, values_of(gains), changed)

    def _set(self, gains: PidGains) -> None:
        self._gains = gains
        self.model.mimics.set_gains(self.spec.joint, gains)

    def prepare(self) -> None:
        """The gains count."""
        self._set(self._gains)
