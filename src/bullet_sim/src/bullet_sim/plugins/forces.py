"""Forces and contacts, applied and measured: their specifications, read from plugins."""

from __future__ import annotations

from dataclasses import dataclass

from bullet_sim.plugins.registry import model_plugin, sensor_plugin
from bullet_sim.plugins.rules import FrameName
from bullet_sim.plugins.xml import MissingPart, PluginXml, SensorXml


@dataclass(frozen=True)
class ContactSpec:
    """A bumper: contacts of some collision shapes.

    Attributes:
        collisions: names of the monitored collisions of the description.
        rate: messages per simulated second [Hz]; 0: every physics step.
    """

    name: str
    link: str
    collisions: tuple[str, ...] = ()
    rate: float = 0.0
    topic: str = "/bumper_states"
    frame_id: str = "world"


@dataclass(frozen=True)
class ForceTorqueSpec:
    """libgazebo_ros_ft_sensor: the wrench of a joint's child link on its parent.

    Attributes:
        link: the child link, whose frame it is given in.
        rate: messages per simulated second [Hz]; 0: every physics step.
        noise_stddev: on each number [N, N m].
    """

    name: str
    link: str
    joint: str
    rate: float = 0.0
    topic: str = "/wrench"
    frame_id: str = ""
    noise_stddev: float = 0.0


@dataclass(frozen=True)
class LinkForceSpec:
    """libgazebo_ros_f3d: the net force and torque on a link, along the world's axes."""

    name: str
    link: str
    rate: float = 0.0
    topic: str = "/force"
    frame_id: str = "world"


@dataclass(frozen=True)
class ForceSpec:
    """libgazebo_ros_force: a wrench on a link, by topic."""

    name: str
    link: str
    topic: str


@dataclass(frozen=True)
class VacuumGripperSpec:
    """libgazebo_ros_vacuum_gripper: draws what is near a link.

    Attributes:
        topic: of Bool, whether something is drawn.
        namespace: of the services on and off, with a slash before it; empty: the root.
    """

    name: str
    link: str
    topic: str
    namespace: str = ""


@dataclass(frozen=True)
class HandOfGodSpec:
    """libgazebo_ros_hand_of_god: pulls a link to the frame FRAME_desired.

    Attributes:
        frame: FRAME; the link's pose is published as FRAME_actual.
        linear, angular: stiffness [N/m], [N m/rad]; it is critically damped.
    """

    name: str
    link: str
    frame: str = "hog"
    linear: float = 200.0
    angular: float = 200.0
    rate: float = 0.0
    topic: str = "/tf"


@dataclass(frozen=True)
class JointPosesSpec:
    """libgazebo_ros_joint_pose_trajectory: sets joint positions to the points of a trajectory."""

    name: str
    link: str
    rate: float = 0.0
    topic: str = "/set_joint_trajectory"


@sensor_plugin("gazebo_ros_bumper", types=("contact",))
def bumper(xml: SensorXml) -> ContactSpec:
    named = [(element.text or "").strip() for element in xml.sensor.findall("contact/collision")]
    return ContactSpec(
        name=xml.name,
        link=xml.parent,
        collisions=tuple(filter(None, named)),
        rate=xml.rate(None),
        topic=xml.topic("bumperTopicName", "bumper_states"),
        frame_id=xml.frame("frameName", "world"),
    )


@model_plugin("gazebo_ros_ft_sensor")
def ft_sensor(xml: PluginXml) -> ForceTorqueSpec:
    joint = xml.joint("jointName")
    child = xml.model.joints[joint].child
    xml.model.measured.add(joint)
    return ForceTorqueSpec(
        name=xml.name or joint,
        link=child,
        joint=joint,
        rate=max(0.0, xml.number("updateRate")),
        topic=xml.topic("topicName", f"{joint}_wrench"),
        frame_id=FrameName(child, xml.names.prefix()),
        noise_stddev=abs(xml.number("gaussianNoise")),
    )


@model_plugin("gazebo_ros_f3d")
def f3d(xml: PluginXml) -> LinkForceSpec:
    link = xml.link("bodyName")
    return LinkForceSpec(
        name=xml.name or link,
        link=link,
        topic=xml.topic("topicName", f"{link}_force"),
        frame_id=xml.frame("frameName", "world", merge=True),
    )


@model_plugin("gazebo_ros_hand_of_god")
def hand_of_god(xml: PluginXml) -> HandOfGodSpec:
    """HandOfGodSpec; the link gets no gravity."""
    link = xml.link("linkName")
    xml.model.links[link].gravity = False
    return HandOfGodSpec(
        name=xml.name or "hand_of_god",
        link=link,
        frame=xml.text("frameId", "hog"),
        linear=abs(xml.number("kl", 200.0)),
        angular=abs(xml.number("ka", 200.0)),
    )


@model_plugin("gazebo_ros_joint_pose_trajectory")
def joint_pose_trajectory(xml: PluginXml) -> JointPosesSpec:
    name, topic = xml.name or "joint_pose_trajectory", "set_joint_trajectory"
    return JointPosesSpec(name, xml.model.root, topic=xml.topic("topicName", topic))


@model_plugin("gazebo_ros_force")
def force(xml: PluginXml) -> ForceSpec:
    return ForceSpec(xml.name or "force", xml.link("bodyName"), _given_topic(xml))


@model_plugin("gazebo_ros_vacuum_gripper")
def vacuum_gripper(xml: PluginXml) -> VacuumGripperSpec:
    namespace = xml.names.topic("").rstrip("/")
    name, link = xml.name or "vacuum_gripper", xml.link("bodyName")
    return VacuumGripperSpec(name, link, _given_topic(xml), namespace)


def _given_topic(xml: PluginXml) -> str:
    """Full name of the <topicName>, without which upstream does not start.

    Raises:
        MissingPart: there is none.
    """
    if not xml.text("topicName"):
        raise MissingPart(f"{xml.label} has no topicName; it is left out")
    return xml.topic("topicName", "")
