"""A harness, which lowers a model and lets it go, and a projector: specifications."""

from __future__ import annotations

from dataclasses import dataclass
from xml.etree.ElementTree import Element

from bullet_sim.description.model import Joint
from bullet_sim.plugins.registry import model_plugin
from bullet_sim.plugins.spec import PluginSpec, read, topic_of
from bullet_sim.plugins.xml import PluginValues, PluginXml, library
from bullet_sim.pose import Pose
from bullet_sim.xml_reader import sdf_pose

WORLD = "world"
KINDS = ("prismatic", "revolute", "fixed")


@dataclass(frozen=True)
class WinchGains:
    """Gains of Gazebo's PID, whose errors are those of a state less its target.

    Attributes:
        i_min, i_max: bounds of the integral term; none where the first is above the second.
        least, most: bounds of the command; as those.
    """

    p: float = 0.0
    i: float = 0.0
    d: float = 0.0
    i_max: float = -1.0
    i_min: float = 0.0
    most: float = -1.0
    least: float = 0.0


@dataclass(frozen=True)
class HarnessSpec(PluginSpec):
    """Gazebo's HarnessPlugin, and libgazebo_ros_harness: joints that hold a model.

    Attributes:
        joints: from the world, or a link, to a link; each has its frame in the child's as anchor,
            and its axis in that frame (Gazebo reads no use_parent_model_frame here).
        winch, detach: numbers of the joint that is driven and of the one that is let go; -1: none.
        position, velocity: gains by which the winch holds, or lowers.
        velocity_topic, topic: of std_msgs/Float32, the winch's velocity, and of std_msgs/Bool,
            true lets go; empty: none.
    """

    NAME = "harness"
    joints: tuple[Joint, ...]
    winch: int = -1
    detach: int = -1
    position: WinchGains = WinchGains()
    velocity: WinchGains = WinchGains()
    velocity_topic: str = ""
    topic: str = ""


@model_plugin("gazebo_ros_projector")
@dataclass(frozen=True)
class ProjectorSpec(PluginSpec):
    """libgazebo_ros_projector: the topics that would switch a projector and choose its texture;
    nothing is projected.

    Attributes:
        topic, switch_topic: of std_msgs/String and std_msgs/Int32.
    """

    NAME = "projector"
    topic: str = topic_of("textureTopicName", "")
    switch_topic: str = topic_of("projectorTopicName", "")


@model_plugin("HarnessPlugin", "gazebo_ros_harness")
def harness(xml: PluginXml) -> HarnessSpec | None:
    """HarnessSpec; a joint that cannot be made is left out with a warning."""
    usable = [_joint(xml, element) for element in xml.element.findall("joint")]
    joints = {joint.name: joint for joint in usable if joint is not None}
    if not joints:
        xml.warn(f"{xml.label} has no <joint> that it can use; it is left out")
        return None
    topics = {}
    if library(xml.element) == "gazebo_ros_harness":
        namespace = f"/{xml.model.name}/harness"
        topics = {"velocity_topic": f"{namespace}/velocity", "topic": f"{namespace}/detach"}
    names = list(joints)
    return read(
        HarnessSpec,
        xml,
        link=joints[names[0]].child,
        joints=tuple(joints.values()),
        winch=_number(xml, "winch/joint", names),
        detach=_number(xml, "detach", names),
        position=_gains(xml, "winch/pos_pid"),
        velocity=_gains(xml, "winch/vel_pid"),
        **topics,
    )


def _number(xml: PluginXml, path: str, names: list[str]) -> int:
    """Number of the joint that a tag names: the first one where there is none of that name, none
    where the tag is missing."""
    name = xml.text(path)
    if name in names:
        return names.index(name)
    missing = xml.element.find(path) is None
    used = "there is none" if missing else f"'{names[0]}' is used"
    xml.warn(f"{xml.label} has <{path}> '{name}', must be one of {', '.join(names)}; {used}")
    return -1 if missing else 0


def _gains(xml: PluginXml, path: str) -> WinchGains:
    if xml.element.find(path) is None:
        return WinchGains()
    tags = ("p", "i", "d", "i_max", "i_min", "cmd_max", "cmd_min")
    return WinchGains(*(xml.number(f"{path}/{tag}") for tag in tags))


def _joint(xml: PluginXml, element: Element) -> Joint | None:
    """A <joint>, or None, with a warning, where its type or an end is unusable."""
    name, kind = element.get("name") or "", element.get("type") or ""
    values = PluginValues(element, f"{xml.label} <joint> '{name}'")
    parent, child = (
        text if text == WORLD else xml.scope + text
        for text in (values.text("parent"), values.text("child"))
    )
    links = xml.model.links
    exists = xml.scope + name in xml.model.joints
    if kind not in KINDS or exists or child not in links or parent not in (WORLD, *links):
        is_taken = ", of which there is another one," if exists else ""
        xml.warn(
            f"{values.label}{is_taken} has type '{kind}' and goes from '{parent}' to '{child}', "
            f"must be {', '.join(KINDS)} from the world or a link to a link of "
            f"'{xml.model.name}'; it is left out"
        )
        return None
    limits = [
        values.number(f"axis/limit/{tag}")
        if element.find(f"axis/limit/{tag}") is not None
        else None
        for tag in ("lower", "upper")
    ]
    if limits[0] is not None and limits[1] is not None and limits[0] > limits[1]:
        limits = [None, None]
    effort, velocity = (values.number(f"axis/limit/{tag}", -1.0) for tag in ("effort", "velocity"))
    dynamics = "axis/dynamics"
    return Joint(
        name,
        kind,
        parent,
        child,
        axis=values.vector("axis/xyz", default=(0.0, 0.0, 1.0)),
        lower=-1e16 if limits[0] is None and limits[1] is not None else limits[0],
        upper=1e16 if limits[1] is None and limits[0] is not None else limits[1],
        effort=effort,
        velocity=velocity,
        damping=abs(values.number(f"{dynamics}/damping")),
        friction=max(0.0, values.number(f"{dynamics}/friction")),
        stiffness=values.number(f"{dynamics}/spring_stiffness"),
        rest=values.number(f"{dynamics}/spring_reference"),
        anchor=sdf_pose(element, values.label) if element.find("pose") is not None else Pose(),
    )
