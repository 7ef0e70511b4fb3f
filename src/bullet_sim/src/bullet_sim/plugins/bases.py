"""Bases that are moved by forces, by a tricycle's wheel or by many wheels: their specifications."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

from bullet_sim.plugins.drives import (
    PLANAR,
    link_frames,
    movable,
    odometry_names,
    read_log_level,
    warn_sizes,
)
from bullet_sim.plugins.registry import model_plugin
from bullet_sim.plugins.rules import FrameName
from bullet_sim.plugins.xml import PluginXml, library

FORCE_POSE = (1e-3, 1e-3, 1e12, 1e12, 1e12, 0.01)  # variances, where it does not turn
FORCE_TWIST = (1e-3, 1e-3, 1e-3, 1e12, 1e12, 0.01)
UNLIMITED = (float("inf"),) * 3


@dataclass(frozen=True)
class ForceMoveSpec:
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

    name: str
    link: str
    base: str
    gains: tuple[float, float, float] = (1e4, 1e4, 100.0)
    maxima: tuple[float, float, float] = UNLIMITED
    rate: float = 20.0
    timeout: float = -1.0
    holds: bool = False
    sideways: bool = True
    publish_tf: bool = True
    command_topic: str = "/cmd_vel"
    topic: str = "/odom"
    frame_id: str = "odom"
    child_frame_id: str = "base_footprint"
    pose_covariance: tuple[float, ...] = FORCE_POSE
    twist_covariance: tuple[float, ...] = FORCE_TWIST


@dataclass(frozen=True)
class TricycleSpec:
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

    name: str
    link: str
    steering: str
    wheel: str
    encoders: tuple[str, str]
    diameter: float = 0.15
    encoder_diameter: float = 0.15
    separation: float = 0.5
    torque: float = 5.0
    acceleration: float = 0.0
    deceleration: float = 0.0
    speed_tolerance: float = 0.01
    steering_speed: float = 0.0
    angle_tolerance: float = 0.01
    from_wheels: bool = False
    rate: float = 100.0
    wheel_states_topic: str = ""
    wheel_frames: tuple[tuple[str, str], ...] = ()
    command_topic: str = "/cmd_vel"
    topic: str = "/odom"
    frame_id: str = "odom"
    child_frame_id: str = "base_link"
    pose_covariance: tuple[float, ...] = PLANAR
    twist_covariance: tuple[float, ...] = (0.0,) * 6


@dataclass(frozen=True)
class ManyWheelsSpec:
    """libdiffdrive_plugin_6w and _multi_wheel: velocities that the wheels of each side are given.

    Attributes:
        left, right: joints of each side.
        separation, diameter: of the wheels [m].
        publish_odometry, publish_tf: of the true pose; 6w publishes neither.
        rate: of commands to the wheels and of odometry [Hz]; 0: every physics step.
    """

    name: str
    link: str
    left: tuple[str, ...]
    right: tuple[str, ...]
    separation: float = 0.34
    diameter: float = 0.15
    publish_odometry: bool = False
    publish_tf: bool = False
    rate: float = 0.0
    resets: bool = False
    command_topic: str = "/cmd_vel"
    topic: str = "/odom"
    frame_id: str = "odom"
    child_frame_id: str = "base_footprint"
    pose_covariance: tuple[float, ...] = PLANAR
    twist_covariance: tuple[float, ...] = (0.0,) * 6


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


@model_plugin(*_FORCE_MOVES)
def force_based_move(xml: PluginXml) -> ForceMoveSpec:
    """ForceMoveSpec; the plugins of the packages differ in time-out, limits and odometry."""
    name = library(xml.element)
    timeout = _TIMEOUTS.get(name)
    limited = name.startswith("nexus")
    yaw = xml.number("max_yaw_velocity", 0.5)
    along = xml.number("max_x_velocity", 0.6)
    return ForceMoveSpec(
        name=xml.name or "force_based_move",
        link=xml.model.root,
        base=xml.link("robotBaseFrame", _base(xml)),
        gains=(
            xml.number("x_velocity_p_gain", 1e4),
            xml.number("y_velocity_p_gain", 1e4),
            xml.number("yaw_velocity_p_gain", 100.0),
        ),
        maxima=(along, along, yaw) if limited else UNLIMITED,  # of y, too, that of x, as upstream
        rate=max(0.0, xml.number("odometryRate", 20.0)),
        timeout=xml.number(*timeout) if timeout else -1.0,
        holds=name.startswith("robotnik"),
        sideways=not name.startswith("ridgeback"),
        publish_tf=xml.switch("publishOdometryTf", True),
        **odometry_names(xml),
    )


def _base(xml: PluginXml) -> str:
    """The link on which the force acts without a <robotBaseFrame>."""
    return "base_footprint" if "base_footprint" in xml.model.links else xml.model.root


@model_plugin("gazebo_ros_tricycle_drive")
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
    sizes = {
        tag: xml.number(tag, default)
        for tag, default in (
            ("actuatedWheelDiameter", 0.15),
            ("encoderWheelDiameter", 0.15),
            ("encoderWheelSeparation", 0.5),
        )
    }
    from_wheels = xml.text("odometrySource") == "encoder"
    if not sizes["actuatedWheelDiameter"] or (from_wheels and not sizes["encoderWheelSeparation"]):
        xml.warn(f"{xml.label} has {sizes}, must not be 0; it is left out")
        return None
    acceleration = xml.number("wheelAcceleration")
    values = odometry_names(xml)
    values["child_frame_id"] = xml.frame("robotBaseFrame", "base_link")
    frames, prefix = link_frames(xml, names), xml.names.prefix()
    return TricycleSpec(
        name=xml.name or "tricycle_drive",
        link=xml.model.root,
        steering=names[0],
        wheel=names[1],
        encoders=(names[2], names[3]),
        diameter=sizes["actuatedWheelDiameter"],
        encoder_diameter=sizes["encoderWheelDiameter"],
        separation=sizes["encoderWheelSeparation"],
        torque=max(0.0, xml.number("wheelTorque", 5.0)),
        acceleration=acceleration,
        deceleration=xml.number("wheelDeceleration", acceleration),
        speed_tolerance=xml.number("wheelSpeedTolerance", 0.01),
        steering_speed=xml.number("steeringSpeed"),
        angle_tolerance=xml.number("steeringAngleTolerance", 0.01),
        from_wheels=from_wheels,
        rate=max(0.0, xml.number("updateRate", 100.0)),
        wheel_states_topic=xml.names.topic("joint_states")
        if xml.option("publishWheelJointState")
        else "",
        wheel_frames=tuple((frames[name][0], FrameName(name, prefix)) for name in names)
        if xml.option("publishWheelTF")
        else (),
        **values,
    )


_SIX = ("front", "mid", "rear")


@model_plugin("diffdrive_plugin_6w")
def six_wheels(xml: PluginXml) -> ManyWheelsSpec | None:
    """ManyWheelsSpec; upstream advertises its odometry and publishes none."""
    left, right = (
        tuple(xml.in_scope(xml.text(f"{place}{side}Joint")) for place in _SIX)
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
    )


@model_plugin("diffdrive_plugin_multi_wheel")
def multi_wheel(xml: PluginXml) -> ManyWheelsSpec | None:
    left, right = (
        tuple(xml.in_scope(name) for name in re.split(r"\s+", xml.text(f"{side}Joints")) if name)
        for side in ("left", "right")
    )
    return _many_wheels(
        xml,
        left,
        right,
        link=xml.model.root,
        rate=max(0.0, xml.number("updateRate", 100.0)),
        publish_odometry=xml.switch("publishOdometryMsg", True),
        publish_tf=xml.switch("publishOdometryTf", True),
        **odometry_names(xml),
    )


def _many_wheels(
    xml: PluginXml, left: tuple[str, ...], right: tuple[str, ...], **values: Any
) -> ManyWheelsSpec | None:
    if any([len(movable(xml, side)) < max(1, len(side)) for side in (left, right)]):
        return None
    separation, diameter = xml.number("wheelSeparation", 0.34), xml.number("wheelDiameter", 0.15)
    if not diameter:
        warn_sizes(xml, separation, diameter)
        return None
    return ManyWheelsSpec(
        name=xml.name or "diffdrive",
        left=left,
        right=right,
        separation=separation,
        diameter=diameter,
        **values,
    )
