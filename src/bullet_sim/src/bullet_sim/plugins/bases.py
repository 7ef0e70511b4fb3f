"""Bases that are moved by forces, by a tricycle's wheel or by many wheels: their specifications."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from bullet_sim.plugins.drives import (
    BaseSpec,
    SidesSpec,
    link_frames,
    movable,
    read_log_level,
    wheel_states_topic,
    with_wheels,
)
from bullet_sim.plugins.registry import model_plugin
from bullet_sim.plugins.rules import BASE, UTILS_OF_MODELS, FrameName
from bullet_sim.plugins.spec import frame_of, not_negative, number, read, reading, switch
from bullet_sim.plugins.xml import PluginXml, library

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
