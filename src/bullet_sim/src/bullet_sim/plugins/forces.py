"""Forces, applied and measured: their specifications, read from plugins."""

from __future__ import annotations

from dataclasses import dataclass
from xml.etree.ElementTree import Element

from bullet_sim.plugins.registry import model_plugin
from bullet_sim.plugins.rules import PLAIN, FrameName
from bullet_sim.plugins.spec import (
    PluginSpec,
    frame_of,
    given_topic,
    link_of,
    not_negative,
    number,
    read,
    reading,
    text_of,
    topic_of,
)
from bullet_sim.plugins.xml import MissingPart, PluginXml, Values, library
from bullet_sim.pose import Vec3
from bullet_sim.xml_reader import document_root, is_true


@dataclass(frozen=True)
class ForceTorqueSpec(PluginSpec):
    """libgazebo_ros_ft_sensor: the wrench of a joint's child link on its parent.

    Attributes:
        link: the child link, whose frame it is given in.
        rate: messages per simulated second [Hz]; 0: every physics step.
        noise_stddev: on each number [N, N m].
        feedback: the joint has <provide_feedback>; without it all numbers are 0, as in Gazebo.
    """

    joint: str
    rate: float = number("updateRate", 0.0, not_negative)
    topic: str = "/wrench"
    frame_id: str = ""
    noise_stddev: float = number("gaussianNoise", 0.0, abs)
    feedback: bool = True


@model_plugin("gazebo_ros_f3d", rule=PLAIN)
@dataclass(frozen=True)
class LinkForceSpec(PluginSpec):
    """libgazebo_ros_f3d: the net force and torque on a link, along the world's axes."""

    link: str = link_of()
    rate: float = 0.0
    topic: str = given_topic(default="/force")
    frame_id: str = frame_of("frameName", "world", merge=True)


@model_plugin("gazebo_ros_force")
@dataclass(frozen=True)
class ForceSpec(PluginSpec):
    """libgazebo_ros_force: a wrench on a link, by topic."""

    NAME = "force"
    link: str = link_of()
    topic: str = given_topic()


@model_plugin("gazebo_ros_vacuum_gripper")
@dataclass(frozen=True)
class VacuumGripperSpec(PluginSpec):
    """libgazebo_ros_vacuum_gripper: draws what is near a link.

    Attributes:
        topic: of Bool, whether something is drawn.
        namespace: of the services on and off, with a slash before it; empty: the root.
    """

    NAME = "vacuum_gripper"
    link: str = link_of()
    topic: str = given_topic()
    namespace: str = reading(lambda xml: xml.names.topic("").rstrip("/"), "")


@dataclass(frozen=True)
class SlippingWheel:
    """A wheel whose contacts slip.

    Attributes:
        link, joint: of the wheel, and the one above it.
        radius: [m].
        force: normal force that the compliances are meant for [N].
        lateral, longitudinal: compliances, slip over friction.
    """

    link: str
    joint: str
    radius: float
    force: float
    lateral: float = 0.0
    longitudinal: float = 0.0


@dataclass(frozen=True)
class WheelSlipSpec(PluginSpec):
    """Gazebo's WheelSlipPlugin, and gazebo_ros_wheel_slip, whose compliances can be changed.

    Attributes:
        namespace: of its dynamic_reconfigure; empty: it has none.
    """

    NAME = "wheel_slip"
    wheels: tuple[SlippingWheel, ...]
    namespace: str = ""
    topic: str = ""


def _weightless(xml: PluginXml) -> str:
    """The link <linkName>, which gets no gravity."""
    link = xml.link("linkName")
    xml.model.links[link].gravity = False
    return link


@model_plugin("gazebo_ros_hand_of_god")
@dataclass(frozen=True)
class HandOfGodSpec(PluginSpec):
    """libgazebo_ros_hand_of_god: pulls a link to the frame FRAME_desired.

    Attributes:
        frame: FRAME; the link's pose is published as FRAME_actual.
        linear, angular: stiffness [N/m], [N m/rad]; it is critically damped.
    """

    NAME = "hand_of_god"
    link: str = reading(_weightless)
    frame: str = text_of("frameId", "hog")
    linear: float = number("kl", 200.0, abs)
    angular: float = number("ka", 200.0, abs)
    rate: float = 0.0
    topic: str = "/tf"


@dataclass(frozen=True)
class Floating:
    """A link that displaces a volume [m^3], whose center (3,) [m] is in its frame."""

    link: str
    volume: float
    center: Vec3


def _floating(xml: PluginXml) -> tuple[Floating, ...]:
    """The usable <link>s; one without a link, a center or a volume is left out with a warning."""
    given = []
    for element in xml.element.findall("link"):
        values = Values(element, f"{xml.label} <link>")
        link, volume = xml.scope + (element.get("name") or ""), values.number("volume")
        center = element.find("center_of_volume")
        if link in xml.model.links and center is not None and volume > 0.0:
            given.append(Floating(link, volume, values.vector("center_of_volume")))
        else:
            xml.warn(
                f"{values.label} '{link}' has volume {volume:g}, must be a link of "
                f"'{xml.model.name}' with a center_of_volume and a volume above 0; it is left out"
            )
    return tuple(given)


@model_plugin("BuoyancyPlugin")
@dataclass(frozen=True)
class BuoyancySpec(PluginSpec):
    """Gazebo's BuoyancyPlugin: everything is in a fluid of a density [kg/m^3].

    Attributes:
        given: links whose volume the file gives.
    """

    NAME = "buoyancy"
    given: tuple[Floating, ...] = reading(_floating, ())
    density: float = number("fluid_density", 999.1026)  # of water
    topic: str = ""


@dataclass(frozen=True)
class ElevatorSpec(PluginSpec):
    """libgazebo_ros_elevator: a lift that goes to floors, and its door.

    Attributes:
        lift, door: joints.
        height: of a floor [m].
        wait: for which the door is open [s].
        topic: of std_msgs/String, the number of a floor.
    """

    NAME = "elevator"
    lift: str
    door: str
    height: float = number("floor_height", 3.0)
    wait: float = number("door_wait_time", 5.0)
    topic: str = topic_of("topic", "elevator")


@model_plugin("gazebo_ros_ft_sensor", rule=PLAIN)
def ft_sensor(xml: PluginXml) -> ForceTorqueSpec:
    joint = xml.joint("jointName")
    child = xml.model.joints[joint].child
    if xml.merged(child) != child:
        raise MissingPart(
            f"{xml.label} has jointName '{joint}', which is a fixed joint that merges its links, "
            "as in Gazebo: give it <preserveFixedJoint>; it is left out",
            "force sensors are at fixed joints that merge their links and are left out",
            f"{xml.label} '{joint}'",
        )
    xml.model.measured.add(joint)
    return read(
        ForceTorqueSpec,
        xml,
        name=xml.name or joint,
        link=child,
        joint=joint,
        topic=xml.given_topic(),
        frame_id=FrameName(child, xml.names.prefix()),
        feedback=_gives_feedback(xml, joint),
    )


def _gives_feedback(xml: PluginXml, joint: str) -> bool:
    """Whether a joint has <provide_feedback> or a force_torque sensor.

    In a URDF the last <provideFeedback> counts, as sdformat writes it before all that it copies.
    """
    gives, names = False, {joint, xml.text("jointName")}
    for holder in document_root(xml.element).iter():
        tag, name = ("provideFeedback", holder.get("reference"))
        if holder.tag == "joint":
            tag, name = "physics/provide_feedback", holder.get("name")
        if holder.tag not in ("joint", "gazebo") or name not in names:
            continue
        if any(node.get("type") == "force_torque" for node in holder.findall("sensor")):
            return True
        said = holder.findall(tag)
        if said:
            gives = is_true(said[-1 if holder.tag == "gazebo" else 0].text)
    return gives


@model_plugin("gazebo_ros_wheel_slip", "WheelSlipPlugin")
def wheel_slip(xml: PluginXml) -> WheelSlipSpec | None:
    """WheelSlipSpec; a <wheel> that cannot be used is left out with a warning."""
    wheels = [_slipping(xml, element) for element in xml.element.findall("wheel")]
    usable = tuple(wheel for wheel in wheels if wheel is not None)
    if not usable:
        xml.warn(f"{xml.label} has no <wheel> that it can use; it is left out")
        return None
    namespace = ""
    if library(xml.element) == "gazebo_ros_wheel_slip":
        own = xml.text("robotNamespace").strip("/") or "wheel_slip"
        namespace = f"/{xml.model.name}/{own}"
    return read(WheelSlipSpec, xml, wheels=usable, namespace=namespace)


def _slipping(xml: PluginXml, element: Element) -> SlippingWheel | None:
    """A <wheel>, or None, with a warning, where its link, joint or a number is unusable."""
    name = element.get("link_name") or ""
    link = xml.scope + name if xml.scope + name in xml.model.links else name
    values = Values(element, f"{xml.label} <wheel> '{name}'")
    joints = [joint.name for joint in xml.model.joints.values() if joint.child == link]
    shapes = xml.model.links[link].collisions if link in xml.model.links else ()
    radius, force = values.number("wheel_radius"), values.number("wheel_normal_force")
    if radius <= 0.0 and len(shapes) == 1 and shapes[0].geometry.kind in ("cylinder", "sphere"):
        radius = float(shapes[0].geometry.size[0])
    if len(shapes) != 1 or len(joints) != 1 or radius <= 0.0 or force <= 0.0:
        xml.warn(
            f"{values.label} has {len(shapes)} collisions, {len(joints)} joints above it, radius "
            f"{radius:g} m and normal force {force:g} N, must be 1, 1 and above 0; it is left out"
        )
        return None
    lateral, longitudinal = (
        values.number(f"slip_compliance_{side}") for side in ("lateral", "longitudinal")
    )
    return SlippingWheel(link, joints[0], radius, force, lateral, longitudinal)


@model_plugin("gazebo_ros_elevator")
def elevator(xml: PluginXml) -> ElevatorSpec:
    lift, door = xml.joint("lift_joint"), xml.joint("door_joint")
    return read(ElevatorSpec, xml, link=xml.model.joints[lift].child, lift=lift, door=door)


@model_plugin("gazebo_ros_template")
def template(_: PluginXml) -> None:
    """The example of gazebo_plugins, which does nothing."""
