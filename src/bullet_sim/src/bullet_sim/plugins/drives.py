"""Drives, joint states, mimic joints, transforms: their specifications, read from plugins."""

from dataclasses import dataclass

from bullet_sim.description.model import MOVABLE_TYPES, Mimic
from bullet_sim.plugins.xml import plugin_label
from bullet_sim.xml_reader import child_number, child_text, is_true


@dataclass(frozen=True)
class JointStatesSpec:
    """libgazebo_ros_joint_state_publisher: positions and velocities of named joints."""

    name: str
    link: str
    joints: tuple[str, ...]
    rate: float = 100.0
    topic: str = "/joint_states"
    frame_id: str = ""


@dataclass(frozen=True)
class WheelDriveSpec:
    """libgazebo_ros_diff_drive and _skid_steer_drive: velocity commands to wheels, odometry.

    Attributes:
        link: root link, whose pose the odometry reports.
        left, right: joints of each side that get that side's speed.
        separation: between the sides [m].
        diameter: of the wheels [m].
        torque: most a wheel gets [N m].
        acceleration: of a wheel's rim [m/s^2]; 0: at once.
        rate: of commands to the wheels and of odometry [Hz].
        command_topic, topic: of velocity commands and of odometry.
        frame_id, child_frame_id: of the odometry.
        publish_tf: also publish the odometry's transform on /tf.
        from_wheels: odometry by the wheels' angles, from zero; else the true pose.
        wheel_states_topic: of JointState with the wheels' positions; empty: none.
        wheel_transforms: also publish the wheels' transforms on /tf.
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
    publish_tf: bool = True
    from_wheels: bool = False
    wheel_states_topic: str = ""
    wheel_transforms: bool = False


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


@dataclass(frozen=True)
class JointTransformsSpec:
    """libpaddock_state_publisher: the transforms of all joints, as robot_state_publisher's."""

    name: str
    link: str
    rate: float = 50.0
    topic: str = "/tf"


@dataclass(frozen=True)
class RootTransformSpec:
    """The true transform of a model's root link.

    Attributes:
        frame_id: name of the world's frame.
    """

    name: str
    link: str
    frame_id: str
    rate: float = 50.0
    topic: str = "/tf"


def joint_states(element, model, names):
    """Specification of libgazebo_ros_joint_state_publisher.so."""
    what = plugin_label(element)
    if element.find("robotNamespace") is None:
        names = type(names)(element, model.name, model.name)
    listed = ",".join(child.text or "" for child in element.findall("jointName"))
    wanted = tuple(name.strip() for name in listed.split(",") if name.strip())
    joints = _known(wanted, model, what)
    if joints:
        model.sensors.append(
            JointStatesSpec(
                name=element.get("name") or "joint_states",
                link=model.root,
                joints=joints,
                rate=child_number(element, "updateRate", what, 100.0),
                topic=names.topic("joint_states"),
            )
        )


def diff_drive(element, model, names):
    """Specification of libgazebo_ros_diff_drive.so.

    Its <legacyMode>, true by default, swaps the left and the right joint.
    """
    left = (child_text(element, "leftJoint", "left_joint"),)
    right = (child_text(element, "rightJoint", "right_joint"),)
    if is_true(child_text(element, "legacyMode", "true")):
        left, right = right, left
    tf_tag = "publishOdomTF" if element.find("publishOdomTF") is not None else "publishTf"
    source = child_text(element, "odometrySource", "world")
    flags = {
        "wheel_states_topic": names.topic("joint_states")
        if is_true(child_text(element, "publishWheelJointState", "false"))
        else "",
        "wheel_transforms": is_true(child_text(element, "publishWheelTF", "false")),
        "from_wheels": source in ("encoder", "0"),
    }
    _drive(element, model, names, left, right, tf_tag, 0.34, **flags)


def skid_steer(element, model, names):
    """Specification of libgazebo_ros_skid_steer_drive.so."""
    left, right = (
        [
            child_text(element, f"{side}{end}Joint", f"{end.lower()}_{side}_joint")
            for end in ("Front", "Rear")
        ]
        for side in ("left", "right")
    )
    _drive(element, model, names, left, right, "broadcastTF", 0.4)


def planar_move(element, model, names):
    """Specification of libgazebo_ros_planar_move.so."""
    what = plugin_label(element)
    model.sensors.append(
        PlanarMoveSpec(
            name=element.get("name") or "planar_move",
            link=model.root,
            rate=child_number(element, "odometryRate", what, 20.0),
            timeout=child_number(element, "cmdTimeout", what, -1.0),
            command_topic=names.text_topic("commandTopic", "cmd_vel"),
            topic=names.text_topic("odometryTopic", "odom"),
            frame_id=names.frame(child_text(element, "odometryFrame", "odom"), prefixed=False),
            child_frame_id=names.frame(
                child_text(element, "robotBaseFrame", "base_footprint"), prefixed=False
            ),
        )
    )


def mimic_joint(element, model, _):
    """roboticsgroup's mimic joint plugin; with <hasPID> it follows as without."""
    what = plugin_label(element)
    names = [child_text(element, tag, "") for tag in ("joint", "mimicJoint")]
    if len(_known(tuple(names), model, what)) < 2:
        return
    effort = child_number(element, "maxEffort", what, -1.0)
    model.joints[names[1]].mimic = Mimic(
        names[0],
        child_number(element, "multiplier", what, 1.0),
        child_number(element, "offset", what, 0.0),
        effort if effort >= 0.0 else None,
        abs(child_number(element, "sensitiveness", what, 0.0)),
    )


def _known(wanted, model, what):
    """The wanted joints that move; one warning for the others."""
    movable = [name for name, joint in model.joints.items() if joint.kind in MOVABLE_TYPES]
    missing = [name for name in wanted if name not in movable]
    if missing or not wanted:
        model.warn(
            f"{what} names joints {', '.join(missing) or '(none)'}, which do not exist or "
            f"do not move; movable joints are {', '.join(movable) or '(none)'}"
        )
    return tuple(name for name in wanted if name in movable)


def _drive(element, model, names, left, right, tf_tag, separation, **flags):
    what = plugin_label(element)
    separation = child_number(element, "wheelSeparation", what, separation)
    diameter = child_number(element, "wheelDiameter", what, 0.15)
    torque = child_number(element, "wheelTorque", what, child_number(element, "torque", what, 5.0))
    joints = _known((*left, *right), model, what)
    if len(joints) < len((*left, *right)):
        return
    if min(separation, diameter) <= 0:
        model.warn(
            f"{what} has wheelSeparation {separation} and wheelDiameter {diameter}, must "
            "be above 0; it is left out"
        )
        return
    model.sensors.append(
        WheelDriveSpec(
            name=element.get("name") or "drive",
            link=model.root,
            left=tuple(left),
            right=tuple(right),
            separation=separation,
            diameter=diameter,
            torque=abs(torque),
            acceleration=max(0.0, child_number(element, "wheelAcceleration", what, 0.0)),
            rate=child_number(element, "updateRate", what, 100.0),
            command_topic=names.text_topic("commandTopic", "cmd_vel"),
            topic=names.text_topic("odometryTopic", "odom"),
            frame_id=names.frame(child_text(element, "odometryFrame", "odom"), prefixed=False),
            child_frame_id=names.frame(
                child_text(element, "robotBaseFrame", "base_footprint"), prefixed=False
            ),
            publish_tf=is_true(child_text(element, tf_tag, "true")),
            **flags,
        )
    )
