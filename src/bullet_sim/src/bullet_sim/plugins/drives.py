"""Joint control and states, drives: their specifications, read from plugins."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeVar

from bullet_sim.description.model import DEFAULT_SIM_TYPE, MOVABLE_TYPES, STEER_BOT_SIM_TYPE, Mimic
from bullet_sim.plugins.registry import model_plugin
from bullet_sim.plugins.rules import BASE, MODEL, ROOT, UTILS_OF_MODELS, FrameName, Rule
from bullet_sim.plugins.spec import PluginSpec, frame_of, number, read, reading, topic_of
from bullet_sim.plugins.xml import PluginXml, Values

PLANAR = (1e-5, 1e-5, 1e12, 1e12, 1e12, 1e-3)  # variances of a base's pose
NO_COVARIANCE = (0.0,) * 6
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


@dataclass(frozen=True)
class JointStatesSpec(PluginSpec):
    """libgazebo_ros_joint_state_publisher: positions and velocities of named joints.

    As upstream it has no efforts.
    """

    NAME = "joint_states"
    joints: tuple[str, ...]
    rate: float = number("updateRate", 100.0)
    topic: str = reading(lambda xml: xml.names.topic("joint_states"), "/joint_states")
    frame_id: str = ""


@model_plugin("gazebo_ros_joint_pose_trajectory")
@dataclass(frozen=True)
class JointPosesSpec(PluginSpec):
    """libgazebo_ros_joint_pose_trajectory: sets joint positions to the points of a trajectory."""

    NAME = "joint_pose_trajectory"
    rate: float = 0.0
    topic: str = topic_of("topicName", "set_joint_trajectory")


@dataclass(frozen=True)
class MimicPidSpec(PluginSpec):
    """<hasPID> of a mimic plugin: its joint follows by a PID's effort.

    Attributes:
        joint: that follows.
        topic: name of the parameters of its gains.
    """

    NAME = "mimic_joint"
    joint: str
    topic: str


@model_plugin("gazebo_ros_control", rule=Rule(MODEL, ROOT))
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


@model_plugin("gazebo_ros_joint_state_publisher", rule=Rule(MODEL, MODEL))
def joint_states(xml: PluginXml) -> JointStatesSpec | None:
    """JointStatesSpec; without <jointName> its messages are empty, as upstream's."""
    if xml.element.find("jointName") is None:
        xml.warn(f"{xml.label} has no jointName; its messages are empty, as in Gazebo")
        return read(JointStatesSpec, xml, joints=())
    named = [name.strip() for name in xml.text("jointName").replace(" ", "").split(",")]
    joints = movable(xml, [xml.in_scope(name) for name in named if name])
    return read(JointStatesSpec, xml, joints=joints) if joints else None


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
    return read(MimicPidSpec, xml, link=child, joint=follower, topic=where)


def movable(xml: PluginXml, names: Sequence[str]) -> tuple[str, ...]:
    """Those of the named joints that can move; one warning for the others."""
    movable = [name for name, joint in xml.model.joints.items() if joint.kind in MOVABLE_TYPES]
    missing = [name for name in names if name not in movable]
    if missing or not names:
        xml.warn(
            f"{xml.label} names joints {', '.join(missing) or '(none)'}, which do not exist or "
            f"do not move; movable joints are {', '.join(movable) or '(none)'}",
            "plugins name joints that do not exist and are left out",
            xml.label,
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


def wheel_states_topic(xml: PluginXml) -> str:
    """Of JointState of the wheels; empty: none."""
    return xml.names.topic("joint_states") if xml.option("publishWheelJointState") else ""


S = TypeVar("S", bound=SidesSpec)


def with_wheels(
    kind: type[S], xml: PluginXml, left: tuple[str, ...], right: tuple[str, ...], **given: Any
) -> S | None:
    """A specification; None, with a warning, without the joints, or where it would divide by 0."""
    wheels = (*left, *right)
    if len(movable(xml, wheels)) < len(wheels):
        return None
    spec = read(kind, xml, left=left, right=right, **given)
    if spec.diameter and (spec.separation or not getattr(spec, "from_wheels", False)):
        return spec
    xml.warn(
        f"{xml.label} has wheelSeparation {spec.separation} and wheelDiameter {spec.diameter}, "
        "must not be 0; it is left out"
    )
    return None
