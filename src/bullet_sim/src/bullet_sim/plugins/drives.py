"""Joint control and states, drives, transforms: their specifications, read from plugins."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from bullet_sim.description.model import DEFAULT_SIM_TYPE, MOVABLE_TYPES, STEER_BOT_SIM_TYPE, Mimic
from bullet_sim.plugins.registry import model_plugin
from bullet_sim.plugins.rules import FrameName
from bullet_sim.plugins.xml import PluginXml, Values


@dataclass(frozen=True)
class JointStatesSpec:
    """libgazebo_ros_joint_state_publisher: positions and velocities of named joints.

    As upstream it has no efforts.
    """

    name: str
    link: str
    joints: tuple[str, ...]
    rate: float = 100.0
    topic: str = "/joint_states"
    frame_id: str = ""


PLANAR = (1e-5, 1e-5, 1e12, 1e12, 1e12, 1e-3)  # variances of a base's pose
NO_COVARIANCE = (0.0,) * 6
LOG_LEVELS = ("DEBUG", "INFO", "WARN", "ERROR", "FATAL")


@dataclass(frozen=True)
class WheelDriveSpec:
    """libgazebo_ros_diff_drive and _skid_steer_drive: velocity commands to wheels, odometry.

    Attributes:
        link: root link, whose pose the odometry reports.
        left, right: joints of each side that get that side's speed.
        separation: between the sides [m].
        diameter: of the wheels [m].
        torque: maximum of a wheel [N m].
        acceleration: of a wheel's rim [m/s^2]; 0: unlimited.
        rate: of commands to the wheels and of odometry [Hz].
        command_topic, topic: of velocity commands and of odometry.
        frame_id, child_frame_id: of the odometry.
        publish_odometry: False: neither odometry nor its transform.
        publish_tf: also publish the odometry's transform on /tf.
        pose_covariance, twist_covariance: diagonals of the odometry's.
        from_wheels: odometry by the wheels' angles, from zero; else the true pose.
        flat: the height of the odometry is 0.
        wheel_states_topic: of JointState with the wheels' positions; empty: none.
        resets: a reset of its model drops its command and restarts its odometry.
        wheel_frames: joint -> (parent, child), for the wheels' transforms on /tf; empty: none.
    """

    name: str
    link: str
    left: tuple[str, ...]
    right: tuple[str, ...]
    separation: float = 0.34
    diameter: float = 0.15
    torque: float = 5.0
    acceleration: float = 0.0
    rate: float = 100.0
    command_topic: str = "/cmd_vel"
    topic: str = "/odom"
    frame_id: str = "odom"
    child_frame_id: str = "base_footprint"
    publish_odometry: bool = True
    publish_tf: bool = True
    pose_covariance: tuple[float, ...] = PLANAR
    twist_covariance: tuple[float, ...] = NO_COVARIANCE
    from_wheels: bool = False
    flat: bool = False
    wheel_states_topic: str = ""
    resets: bool = False
    wheel_frames: Mapping[str, tuple[str, str]] = field(default_factory=dict)


@dataclass(frozen=True)
class PlanarMoveSpec:
    """libgazebo_ros_planar_move: a model that follows its velocity commands exactly.

    Attributes:
        rate: of odometry [Hz].
        timeout: without a command after which it stops [s]; negative: never.
    """

    name: str
    link: str
    rate: float = 20.0
    timeout: float = -1.0
    command_topic: str = "/cmd_vel"
    topic: str = "/odom"
    frame_id: str = "odom"
    child_frame_id: str = "base_footprint"
    pose_covariance: tuple[float, ...] = PLANAR
    twist_covariance: tuple[float, ...] = NO_COVARIANCE


@dataclass(frozen=True)
class JointTransformsSpec:
    """libpaddock_state_publisher: the transforms of all joints, as robot_state_publisher's.

    Attributes:
        prefix: before the links' names.
    """

    name: str
    link: str
    rate: float = 50.0
    topic: str = "/tf"
    prefix: str = ""


@dataclass(frozen=True)
class RootTransformSpec:
    """The true transform of a model's root link.

    Attributes:
        frame_id: name of the world's frame.
        child_frame_id: of the link.
    """

    name: str
    link: str
    frame_id: str
    rate: float = 50.0
    topic: str = "/tf"
    child_frame_id: str = ""


@dataclass(frozen=True)
class MimicPidSpec:
    """<hasPID> of a mimic plugin: its joint follows by a PID's effort.

    Attributes:
        joint: that follows.
        topic: name of the parameters of its gains.
    """

    name: str
    link: str
    joint: str
    topic: str


@model_plugin("gazebo_ros_control")
def control(xml: PluginXml) -> None:
    """Namespace, period and hardware layer of a model's controllers."""
    model, known = xml.model, (DEFAULT_SIM_TYPE, STEER_BOT_SIM_TYPE)
    model.control_namespace = f"/{xml.names.namespace}"
    model.control_period = Values(xml.element, "gazebo_ros_control").number("controlPeriod")
    model.emergency_stop = xml.text("eStopTopic")
    model.robot_param = xml.text("robotParam", "robot_description")
    sim_type = xml.text("robotSimType", DEFAULT_SIM_TYPE).replace("::", "/")
    if sim_type not in known:
        xml.warn(
            f"gazebo_ros_control has robotSimType '{sim_type}', known are {' and '.join(known)}; "
            "the first is used"
        )
    model.robot_sim_type = sim_type if sim_type in known else DEFAULT_SIM_TYPE


@model_plugin("gazebo_ros_joint_state_publisher")
def joint_states(xml: PluginXml) -> JointStatesSpec | None:
    named = [name.strip() for name in xml.text("jointName").replace(" ", "").split(",")]
    named = [name for name in named if name]
    joints = movable(xml, [xml.in_scope(name) for name in named])
    if not joints:
        return None
    return JointStatesSpec(
        name=xml.name or "joint_states",
        link=xml.model.root,
        joints=joints,
        rate=xml.number("updateRate", 100.0),
        topic=xml.names.topic("joint_states"),
    )


@model_plugin("paddock_state_publisher")
def state_publisher(xml: PluginXml) -> list[Any]:
    """JointTransformsSpec; with a <frameName> of the world RootTransformSpec, too."""
    name, root, prefix = xml.name or "state_publisher", xml.model.root, xml.names.prefix()
    links = JointTransformsSpec(
        name, root, xml.number("updateRate", 50.0), prefix=FrameName("", prefix)
    )
    specs: list[Any] = [links]
    if frame := xml.text("frameName").lstrip("/"):
        rate, child = xml.number("frameRate", 50.0), FrameName(root, prefix)
        specs.append(RootTransformSpec(name, root, frame, rate, child_frame_id=child))
    return specs


def read_log_level(xml: PluginXml) -> None:
    """Read <rosDebugLevel>, as the plugins do that share upstream's GazeboRos; the last counts."""
    level = xml.text("rosDebugLevel").upper()
    if level in LOG_LEVELS:
        xml.model.log_level = level


@model_plugin("gazebo_ros_diff_drive")
def diff_drive(xml: PluginXml) -> WheelDriveSpec | None:
    """WheelDriveSpec; <publishTf> false switches the odometry off, too, as upstream.

    <legacyMode>, which once swapped the joints, is no more since gazebo_plugins 2.8.3.
    """
    read_log_level(xml)
    left, right = (
        xml.in_scope(xml.text(f"{side}Joint", f"{side}_joint")) for side in ("left", "right")
    )
    with_states = xml.option("publishWheelJointState")
    with_frames = xml.option("publishWheelTF")
    return _drive(
        xml,
        (left,),
        (right,),
        0.34,
        xml.number("wheelTorque", 5.0),
        publish_odometry=xml.switch("publishTf", True),
        publish_tf=xml.option("publishOdomTF", True),
        wheel_states_topic=xml.names.topic("joint_states") if with_states else "",
        resets=True,
        wheel_frames=link_frames(xml, (right, left)) if with_frames else {},
        acceleration=xml.number("wheelAcceleration"),
        from_wheels=xml.text("odometrySource") == "encoder",
    )


@model_plugin("gazebo_ros_skid_steer_drive")
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
    return _drive(
        xml,
        left,
        right,
        0.4,
        xml.number("torque", 5.0),
        publish_tf=xml.switch("broadcastTF"),
        pose_covariance=covariance,
        twist_covariance=covariance,
        flat=True,
    )


@model_plugin("gazebo_ros_planar_move")
def planar_move(xml: PluginXml) -> PlanarMoveSpec:
    return PlanarMoveSpec(
        name=xml.name or "planar_move",
        link=xml.model.root,
        rate=xml.number("odometryRate", 20.0),
        timeout=xml.number("cmdTimeout", -1.0),
        **odometry_names(xml),
    )


@model_plugin(
    "roboticsgroup_gazebo_mimic_joint_plugin", "roboticsgroup_upatras_gazebo_mimic_joint_plugin"
)
def mimic_joint(xml: PluginXml) -> MimicPidSpec | None:
    """A joint's Mimic, and with <hasPID> where its gains are, which need ROS."""
    leader, follower = (xml.in_scope(xml.text(tag)) for tag in ("joint", "mimicJoint"))
    if len(movable(xml, (leader, follower))) < 2:
        return None
    effort = xml.number("maxEffort", -1.0)
    xml.model.joints[follower].mimic = Mimic(
        leader,
        xml.number("multiplier", 1.0),
        xml.number("offset"),
        effort if effort >= 0.0 else None,
        abs(xml.number("sensitiveness")),
    )
    if xml.element.find("hasPID") is None:
        return None
    own = f"gazebo_ros_control/pid_gains/{xml.text('mimicJoint')}"
    where, child = xml.topic("hasPID", own), xml.model.joints[follower].child
    return MimicPidSpec(xml.name or "mimic_joint", child, follower, where)


def movable(xml: PluginXml, names: Sequence[str]) -> tuple[str, ...]:
    """Those of the named joints that can move; one warning for the others."""
    movable = [name for name, joint in xml.model.joints.items() if joint.kind in MOVABLE_TYPES]
    missing = [name for name in names if name not in movable]
    if missing or not names:
        xml.warn(
            f"{xml.label} names joints {', '.join(missing) or '(none)'}, which do not exist or "
            f"do not move; movable joints are {', '.join(movable) or '(none)'}"
        )
    return tuple(name for name in names if name in movable)


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


def odometry_names(xml: PluginXml) -> dict[str, Any]:
    """Topics and frames of a drive."""
    return dict(
        command_topic=xml.topic("commandTopic", "cmd_vel"),
        topic=xml.topic("odometryTopic", "odom"),
        frame_id=xml.frame("odometryFrame", "odom"),
        child_frame_id=xml.frame("robotBaseFrame", "base_footprint"),
    )


def warn_sizes(xml: PluginXml, separation: float, diameter: float) -> None:
    """Warning for a drive that would divide by zero; one below 0 turns or drives backwards."""
    xml.warn(
        f"{xml.label} has wheelSeparation {separation} and wheelDiameter {diameter}, must not be "
        "0; it is left out"
    )


def _drive(
    xml: PluginXml,
    left: tuple[str, ...],
    right: tuple[str, ...],
    separation: float,
    torque: float,
    **values: Any,
) -> WheelDriveSpec | None:
    separation = xml.number("wheelSeparation", separation)
    diameter = xml.number("wheelDiameter", 0.15)
    if len(movable(xml, (*left, *right))) < len((*left, *right)):
        return None
    if not diameter or not (separation or not values.get("from_wheels")):
        warn_sizes(xml, separation, diameter)
        return None
    return WheelDriveSpec(
        name=xml.name or "drive",
        link=xml.model.root,
        left=left,
        right=right,
        separation=separation,
        diameter=diameter,
        torque=max(0.0, torque),  # as ODE takes a negative one
        rate=xml.number("updateRate", 100.0),
        **odometry_names(xml),
        **values,
    )
