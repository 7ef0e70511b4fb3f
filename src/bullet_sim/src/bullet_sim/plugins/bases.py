"""Bases that are moved by forces, by a tricycle's wheel or by many wheels."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from bullet_sim.component import Stateful
from bullet_sim.parts.base import part_of
from bullet_sim.parts.outputs import JointStatesOutput, TransformsOutput
from bullet_sim.plugins.drives import (
    BaseSpec,
    DrivenBase,
    PlanarMovePlugin,
    SidesSpec,
    link_frames,
    read_log_level,
    wheel_states_topic,
    with_wheels,
)
from bullet_sim.plugins.joints import movable
from bullet_sim.plugins.registry import model_plugin
from bullet_sim.plugins.rules import BASE, UTILS_OF_MODELS, FrameName
from bullet_sim.plugins.spec import frame_of, not_negative, number, read, reading, switch
from bullet_sim.plugins.xml import PluginXml, library
from bullet_sim.pose import Pose, quaternion_from_yaw
from bullet_sim.sensors import inertial

FORCE_POSE = (1e-3, 1e-3, 1e12, 1e12, 1e12, 0.01)  # variances, where it does not turn
FORCE_TWIST = (1e-3, 1e-3, 1e-3, 1e12, 1e12, 0.01)
UNLIMITED = (float("inf"),) * 3


def _gains(xml: PluginXml) -> tuple[float, ...]:
    axes = (("x", 1e4), ("y", 1e4), ("yaw", 100.0))
    return tuple(xml.number(f"{axis}_velocity_p_gain", default) for axis, default in axes)


@dataclass(frozen=True)
class ForceMoveSpec(BaseSpec):
    """The plugins ..._force_based_move: a force and a torque in proportion to what the velocity
    lacks, odometry by adding up the velocity.

    Attributes:
        link: root link, whose velocity counts.
        base: link on which the force acts.
        gains: of x, y [N s/m] and yaw [N m s/rad].
        maxima: of a command's x, y [m/s] and yaw rate [rad/s]; only upwards, as upstream.
        rate: of odometry [Hz]; 0: none.
        timeout: without a command after which it counts as zero [s]; negative: never.
        holds: after the time-out the model stays at its pose.
        sideways: odometry knows of sideways motion.
        publish_tf: also publish the odometry's transform on /tf.
    """

    NAME = "force_based_move"
    base: str = ""
    gains: tuple[float, ...] = reading(_gains, (1e4, 1e4, 100.0))
    maxima: tuple[float, float, float] = UNLIMITED
    rate: float = number("odometryRate", 20.0, not_negative)
    timeout: float = -1.0
    holds: bool = False
    sideways: bool = True
    publish_tf: bool = switch("publishOdometryTf", True)
    pose_covariance: tuple[float, ...] = FORCE_POSE
    twist_covariance: tuple[float, ...] = FORCE_TWIST


_FORCE_MOVES = (
    "gazebo_ros_force_based_move",
    "ridgeback_ros_force_based_move",
    "nexus_ros_force_based_move",
    "robotnik_force_based_move",
    "r550_force_based_move",
)
# Of those of them that have one: seconds without a command.
_TIMEOUTS = {
    "ridgeback_ros_force_based_move": ("cmdVelTimeOut", 0.25),
    "nexus_ros_force_based_move": ("cmdVelTimeOut", 0.25),
    "robotnik_force_based_move": ("commandWatchdog", 2.0),
}


@model_plugin(*_FORCE_MOVES, rule=BASE)
def force_based_move(xml: PluginXml) -> ForceMoveSpec:
    """ForceMoveSpec; the plugins of the packages differ in time-out, limits and odometry."""
    name = library(xml.element)
    yaw, along = xml.number("max_yaw_velocity", 0.5), xml.number("max_x_velocity", 0.6)
    return read(
        ForceMoveSpec,
        xml,
        base=xml.link("robotBaseFrame", _base(xml)),
        # of y, too, that of x, as upstream
        maxima=(along, along, yaw) if name.startswith("nexus") else UNLIMITED,
        timeout=xml.number(*_TIMEOUTS[name]) if name in _TIMEOUTS else -1.0,
        holds=name.startswith("robotnik"),
        sideways=not name.startswith("ridgeback"),
    )


def _base(xml: PluginXml) -> str:
    """The link on which the force acts without a <robotBaseFrame>."""
    return "base_footprint" if "base_footprint" in xml.model.links else xml.model.root


@dataclass(frozen=True)
class TricycleSpec(BaseSpec):
    """libgazebo_ros_tricycle_drive: one wheel is steered and driven, two have encoders.

    Attributes:
        steering, wheel: joints of the driven wheel.
        encoders: joints of the left and the right wheel.
        diameter, encoder_diameter: of the driven wheel, of those with encoders [m].
        separation: between those with encoders [m].
        torque: maximum of the driven wheel and of its steering [N m].
        acceleration, deceleration: of the driven wheel [rad/s^2]; an acceleration of 0: at once.
        speed_tolerance: [rad/s] below which a difference in speed stays.
        steering_speed: [rad/s]; 0: the wheel is put to its angle.
        angle_tolerance: [rad] within which steering stops.
        from_wheels: odometry by the encoders, from zero; else the true pose.
        wheel_states_topic: of JointState of the four joints; empty: none.
        wheel_frames: (parent, frame) of the four joints, for transforms on /tf; empty: none.
    """

    NAME = "tricycle_drive"
    steering: str = ""
    wheel: str = ""
    encoders: tuple[str, str] = ("", "")
    child_frame_id: str = frame_of("robotBaseFrame", "base_link")
    diameter: float = number("actuatedWheelDiameter", 0.15)
    encoder_diameter: float = number("encoderWheelDiameter", 0.15)
    separation: float = number("encoderWheelSeparation", 0.5)
    torque: float = number("wheelTorque", 5.0, not_negative)
    acceleration: float = number("wheelAcceleration")
    deceleration: float = reading(
        lambda xml: xml.number("wheelDeceleration", xml.number("wheelAcceleration")), 0.0
    )
    speed_tolerance: float = number("wheelSpeedTolerance", 0.01)
    steering_speed: float = number("steeringSpeed")
    angle_tolerance: float = number("steeringAngleTolerance", 0.01)
    from_wheels: bool = reading(lambda xml: xml.text("odometrySource") == "encoder", False)
    rate: float = number("updateRate", 100.0, not_negative)
    wheel_states_topic: str = reading(wheel_states_topic, "")
    wheel_frames: tuple[tuple[str, str], ...] = ()


@model_plugin("gazebo_ros_tricycle_drive", rule=UTILS_OF_MODELS)
def tricycle(xml: PluginXml) -> TricycleSpec | None:
    read_log_level(xml)
    names = [
        xml.in_scope(xml.text(tag, default))
        for tag, default in (
            ("steeringJoint", "front_steering_joint"),
            ("actuatedWheelJoint", "front_wheel_joint"),
            ("encoderWheelLeftJoint", "left_wheel_joint"),
            ("encoderWheelRightJoint", "right_wheel_joint"),
        )
    ]
    if len(movable(xml, names)) < len(names):
        return None
    steering, wheel, *encoders = names
    frames: tuple[tuple[str, str], ...] = ()
    if xml.option("publishWheelTF"):
        parents, prefix = link_frames(xml, names), xml.names.prefix()
        frames = tuple((parents[name][0], FrameName(name, prefix)) for name in names)
    wheels = {"steering": steering, "wheel": wheel, "encoders": tuple(encoders)}
    spec = read(TricycleSpec, xml, **wheels, wheel_frames=frames)
    if spec.diameter and (spec.separation or not spec.from_wheels):
        return spec
    sizes = {
        "actuatedWheelDiameter": spec.diameter,
        "encoderWheelDiameter": spec.encoder_diameter,
        "encoderWheelSeparation": spec.separation,
    }
    xml.warn(f"{xml.label} has {sizes}, must not be 0; it is left out")
    return None


@dataclass(frozen=True)
class ManyWheelsSpec(SidesSpec):
    """libdiffdrive_plugin_6w and _multi_wheel: velocities that the wheels of each side are given.

    Attributes:
        publish_odometry, publish_tf: of the true pose; 6w publishes neither.
        rate: of commands to the wheels and of odometry [Hz]; 0: every physics step.
    """

    NAME = "diffdrive"
    publish_odometry: bool = False
    publish_tf: bool = False
    rate: float = 0.0


def _many_wheels(
    xml: PluginXml, left: tuple[str, ...], right: tuple[str, ...], **given: Any
) -> ManyWheelsSpec | None:
    if any([len(movable(xml, side)) < max(1, len(side)) for side in (left, right)]):
        return None
    return with_wheels(ManyWheelsSpec, xml, left, right, **given)


@model_plugin("diffdrive_plugin_6w")
def six_wheels(xml: PluginXml) -> ManyWheelsSpec | None:
    """ManyWheelsSpec; upstream advertises its odometry and publishes none."""
    left, right = (
        tuple(xml.in_scope(xml.text(f"{place}{side}Joint")) for place in ("front", "mid", "rear"))
        for side in ("Left", "Right")
    )
    return _many_wheels(
        xml,
        left,
        right,
        resets=True,
        link=xml.link("bodyName", xml.model.root),
        command_topic=xml.topic("topicName", "cmd_vel"),
        topic=xml.names.topic("odom"),
        frame_id="odom",
        child_frame_id="base_footprint",
    )


@model_plugin("diffdrive_plugin_multi_wheel", rule=BASE)
def multi_wheel(xml: PluginXml) -> ManyWheelsSpec | None:
    left, right = (
        tuple(xml.in_scope(name) for name in xml.text(f"{side}Joints").split())
        for side in ("left", "right")
    )
    return _many_wheels(
        xml,
        left,
        right,
        rate=max(0.0, xml.number("updateRate", 100.0)),
        publish_odometry=xml.switch("publishOdometryMsg", True),
        publish_tf=xml.switch("publishOdometryTf", True),
    )


STRAIGHT = 1e-4  # [rad/s] yaw rate, and [m] way, below which there is none
RIGHT_ANGLE = math.pi / 2.0
Pose2d = tuple  # x, y [m], yaw [rad]
TURNING = 100.0  # variance of yaw and its rate while a base moved by forces turns
STILL = 1e-4  # [rad/s] below which it does not turn


@part_of(ForceMoveSpec)
class ForceMovePlugin(PlanarMovePlugin):
    """Pushes and turns a link in every step; publishes Odometry and its transform."""

    STATE: ClassVar[tuple[str, ...]] = ("_pose2d", "_sent_at", "_held", "_is_held")
    goes_on = False

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        spec = self.spec
        self._part, _ = self.model.link_in_body(spec.base)
        turning = replace(
            spec,
            pose_covariance=(*spec.pose_covariance[:5], TURNING),
            twist_covariance=(*spec.twist_covariance[:5], TURNING),
        )
        self._senders = [self._sender, self.output(self._odometry(turning))]

    def _sends(self) -> tuple[bool, bool]:
        return True, self.spec.publish_tf

    def start(self, time: float) -> None:
        """Messages from now on."""
        super().start(time)
        self._sent_at = time

    def reset(self, time: float) -> None:
        """Without a command, odometry at zero."""
        self._pose2d = (0.0, 0.0, 0.0)
        self._held: Pose | None = None  # where it stays, without a command
        self._is_held = False
        super().reset(time)

    def update(self, time: float, period: float) -> None:
        spec, model = self.spec, self.model
        if self._new:
            self._since, self._new = time, False
        is_late = 0.0 <= spec.timeout < time - (self._since or 0.0)
        position, orientation, linear, angular = model.link_motion(spec.link)
        if spec.holds and is_late:  # without odometry, as upstream
            if not self._is_held:
                self.log_warning(
                    f"PlanarMovePlugin (ns = {model.name}): Robot stopped and pose forced to "
                    "prevent slipping away."
                )
            self._is_held = True
            model.set_state(self._held or Pose(position, orientation))
            return
        self._held, self._is_held = Pose(position, orientation), False
        if is_late:
            self._command = self.standing
        own, turning = inertial.twist(orientation, linear, angular)
        x, y, yaw_rate = map(min, self._command, spec.maxima)
        gain_x, gain_y, gain_yaw = spec.gains
        push = np.array(((x - own[0]) * gain_x, (y - own[1]) * gain_y, 0.0))
        turn = np.array((0.0, 0.0, (yaw_rate - angular[2]) * gain_yaw))
        if push.any() or turn.any():
            rotation = model.link_state(spec.base)[0].matrix
            model.apply_wrench(self._part, rotation @ push, turn)
        if spec.rate > 0.0 and self._due.due(self.world.step_count):
            self._publish(time, own, turning)

    def _publish(self, time: float, linear: Any, angular: Any) -> None:
        """Add the velocity [m/s, rad/s] since the last message to the odometry, and publish it."""
        elapsed, self._sent_at = time - self._sent_at, time
        sideways = linear[1] if self.spec.sideways else 0.0
        self._pose2d = after_arc(self._pose2d, linear[0], sideways, angular[2], elapsed)
        x, y, yaw = self._pose2d
        self._senders[abs(angular[2]) >= STILL].send(
            time,
            (x, y, 0.0),
            quaternion_from_yaw(yaw),
            (linear[0], sideways, 0.0),
            (0.0, 0.0, angular[2]),
        )


def after_arc(pose: Pose2d, x: float, y: float, yaw_rate: float, seconds: float) -> Pose2d:
    """A pose (x, y [m], yaw [rad]) after some time with a velocity [m/s, rad/s] along its own axes.

    The base moves on a circle, as hector's force_based_move adds it up.
    """
    along, across, turned = x * seconds, y * seconds, 0.0
    if abs(yaw_rate) >= STRAIGHT:
        turned = yaw_rate * seconds
        if abs(along) < STRAIGHT and abs(across) < STRAIGHT:
            along = across = 0.0
        else:
            radius = math.hypot(along, across) / turned
            direction = math.atan2(across, along)
            ahead, aside = math.sin(turned) * radius, radius - math.cos(turned) * radius
            along = math.cos(direction) * ahead - math.sin(direction) * aside
            across = math.sin(direction) * ahead + math.cos(direction) * aside
    c, s = math.cos(pose[2]), math.sin(pose[2])
    return pose[0] + c * along - s * across, pose[1] + s * along + c * across, pose[2] + turned


class TricycleMotion(Stateful):
    """Odometry of a tricycle by its encoders, and what its motors are told."""

    STATE = ("pose", "twist", "_before")

    def __init__(self, spec: TricycleSpec) -> None:
        self._spec = spec
        self.restart()

    def restart(self) -> None:
        """Odometry at zero."""
        self.pose: Pose2d = (0.0, 0.0, 0.0)
        self.twist = (0.0, 0.0, 0.0)  # x, y [m/s] along the odometry's axes, yaw rate [rad/s]
        self._before: float | None = None

    def measure(self, time: float, left: float, right: float) -> None:
        """Add the way since the last call, with the speeds [rad/s] of both wheels now.

        As upstream it turns to the left where the left wheel is faster.
        """
        before, self._before = self._before, time
        elapsed = time - (0.0 if before is None else before)
        if elapsed <= 0.0:
            return
        radius, base = self._spec.encoder_diameter / 2.0, self._spec.separation
        by_left, by_right = left * radius * elapsed, right * radius * elapsed
        turned, way = (by_left - by_right) / base, (by_left + by_right) / 2.0
        x, y, yaw = self.pose
        dx = way * math.cos(yaw + turned / 2.0)
        dy = way * math.sin(yaw + turned / 2.0)
        self.pose = (x + dx, y + dy, yaw + turned)
        self.twist = (dx / elapsed, dy / elapsed, turned / elapsed)

    def wheel_speed(self, target: float, speed: float, elapsed: float) -> float:
        """Speed [rad/s] for the motor of the driven wheel.

        Args:
            target, speed: commanded and present [rad/s].
            elapsed: since the last call [s].
        """
        spec = self._spec
        if spec.acceleration <= 0.0:
            return target
        lead = speed - target
        if abs(lead) < spec.speed_tolerance:
            return speed
        if abs(lead) > spec.acceleration * elapsed:
            if lead > 0.0:
                return speed - spec.acceleration * elapsed
            return speed + spec.deceleration * elapsed
        return target

    def steering_speed(self, target: float, angle: float, speed: float) -> float:
        """Speed [rad/s] for the motor of the steering.

        As upstream the direction comes of a comparison with the wheel's speed, not with zero.

        Args:
            target, angle: commanded and present [rad].
            speed: commanded of the driven wheel [rad/s].
        """
        lead = angle - min(max(target, -RIGHT_ANGLE), RIGHT_ANGLE)
        if abs(lead) < self._spec.angle_tolerance:
            return 0.0
        return self._spec.steering_speed if lead < speed else -self._spec.steering_speed


@part_of(TricycleSpec)
class TricyclePlugin(DrivenBase):
    """Drives and steers one wheel by geometry_msgs/Twist: speed [m/s] and steering angle [rad]."""

    STATE: ClassVar[tuple[str, ...]] = ("_tricycle",)
    resets = False
    waits_for_time = True

    def __init__(self, context: Any) -> None:
        self._tricycle = TricycleMotion(context.spec)
        super().__init__(context)
        spec = self.spec
        topic = spec.wheel_states_topic
        names = self._names = (spec.steering, spec.wheel, *spec.encoders)
        self._wheel_states = self.output(JointStatesOutput(topic, names)) if topic else None
        self._wheel_frames = self.output(TransformsOutput()) if spec.wheel_frames else None

    def reset(self, time: float) -> None:
        """Without a command, odometry at zero."""
        self._tricycle.restart()
        super().reset(time)

    def prepare(self) -> None:
        """The driven wheel and its steering are braked until the first update."""
        for joint in self._names[:2]:
            self.model.joints.set_motor(joint, 0.0, self.spec.torque)

    def update(self, time: float, period: float) -> None:
        spec, joints, motion = self.spec, self.model.joints, self._tricycle
        positions, speeds = joints.state()
        if spec.from_wheels:
            motion.measure(time, *(speeds[name] for name in spec.encoders))
        self._publish(time, positions, speeds)
        elapsed = self._elapsed(time)
        speed, angle = self._command
        target = speed / (spec.diameter / 2.0)
        wheel = motion.wheel_speed(target, speeds[spec.wheel], elapsed)
        joints.set_motor(spec.wheel, wheel, spec.torque)
        if spec.steering_speed > 0.0:
            turn = motion.steering_speed(angle, positions[spec.steering], target)
            joints.set_motor(spec.steering, turn, spec.torque)
        else:
            angle = max(-RIGHT_ANGLE, min(RIGHT_ANGLE, angle))
            joints.set_positions({spec.steering: angle})

    def _publish(self, time: float, positions: Any, speeds: Any) -> None:
        spec, motion = self.spec, self._tricycle
        if spec.from_wheels:
            (x, y, yaw), (vx, vy, rate) = motion.pose, motion.twist
            turn = quaternion_from_yaw(yaw)
            self._sender.send(time, (x, y, 0.0), turn, (vx, vy, 0.0), (0.0, 0.0, rate))
        else:
            self._sender.send(time, *self._motion())
        if self._wheel_frames is not None:
            self._wheel_frames.send(time, self._frames_of(zip(self._names, spec.wheel_frames)))
        if self._wheel_states is not None:
            joints = self.model.joints
            efforts = joints.columns([joints.names.index(name) for name in self._names])[2]
            self._wheel_states.send(
                time,
                [positions[name] for name in self._names],
                [speeds[name] for name in self._names],
                efforts,
            )


@part_of(ManyWheelsSpec)
class ManyWheelsPlugin(DrivenBase):
    """Gives the wheels of each side their velocity, whatever the torque that it takes."""

    waits_for_time = True
    advertises = True

    def _sends(self) -> tuple[bool, bool]:
        return self.spec.publish_odometry, self.spec.publish_tf

    def update(self, time: float, period: float) -> None:
        spec = self.spec
        if spec.publish_odometry or spec.publish_tf:
            position, orientation, linear, angular = self._motion()
            self._sender.send(time, position, orientation, linear, angular, flat=True)
        forward, yaw_rate = self._command
        half = yaw_rate * spec.separation / 2.0
        for wheels, speed in ((spec.left, forward - half), (spec.right, forward + half)):
            speeds = [speed / (spec.diameter / 2.0)] * len(wheels)
            self.model.joints.impose_velocities(wheels, speeds)
