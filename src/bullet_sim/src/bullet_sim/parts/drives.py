"""Joint states, drives, planar move."""

from __future__ import annotations

import math
import operator
from collections.abc import Iterable
from typing import Any, ClassVar

from bullet_sim.controllers import MAX_COMMAND
from bullet_sim.controllers.drive import WheelDrive
from bullet_sim.parts.base import Part, Sensor, part_of
from bullet_sim.parts.outputs import BaseOutput, JointStatesOutput, TransformsOutput
from bullet_sim.parts.schedule import Schedule, whole_rate
from bullet_sim.plugins import drives as specs
from bullet_sim.pose import Motion, Pose, Vec3, rpy_from_quaternion


@part_of(specs.JointStatesSpec)
class JointStatesSensor(Sensor):
    """sensor_msgs/JointState of the named joints, without efforts."""

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        names, joints = list(self.spec.joints), self.model.joints
        self._indices = [joints.names.index(name) for name in names]
        parts = "position", "velocity"
        self._sender = self.output(JointStatesOutput(self.spec.topic, tuple(names), parts))

    def update(self, time: float, period: float) -> None:
        positions, velocities, _ = self.model.joints.columns(self._indices)
        self._sender.send(time, positions, velocities)


class DrivenBase(Part):
    """Takes velocity commands, publishes nav_msgs/Odometry and its transform.

    A command acts from the next update until the next command, as in Gazebo's plugins. One that
    comes before the first update (the world is paused, other plugins are being loaded) counts.

    Attributes:
        standing: the command for no motion.
        advertises: its topic is there without odometry, too.
    """

    STATE: ClassVar[tuple[str, ...]] = ("_command", "_before")
    COMMANDS = {"command_topic": ("geometry_msgs/Twist", "_on_command")}
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


@part_of(specs.WheelDriveSpec)
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


@part_of(specs.PlanarMoveSpec)
class PlanarMovePlugin(DrivenBase):
    """Sets the model's velocity in every step; publishes Odometry and its transform.

    Upstream sets the vertical velocity and the others of rotation to zero, so does this. The
    odometry's twist is the way since its last message over the time.
    """

    STATE: ClassVar[tuple[str, ...]] = ("_since", "_new", "_due", "_last")
    every_step = True
    resets = False
    standing = (0.0, 0.0, 0.0)

    def __init__(self, context: Any) -> None:
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
