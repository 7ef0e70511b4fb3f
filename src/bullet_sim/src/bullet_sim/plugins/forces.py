"""Forces and contacts, applied and measured: their specifications, read from plugins."""

from __future__ import annotations

import math
from dataclasses import dataclass
from xml.etree.ElementTree import Element

from bullet_sim.description.model import ModelDescription
from bullet_sim.plugins.registry import model_plugin, sensor_plugin
from bullet_sim.plugins.rules import FrameName
from bullet_sim.plugins.xml import MissingPart, PluginXml, SensorXml, Values, library
from bullet_sim.pose import Vec3
from bullet_sim.xml_reader import child_text, document_root, is_true


@dataclass(frozen=True)
class ContactSpec:
    """A bumper: contacts of some collision shapes.

    Attributes:
        collisions: names of the monitored collisions in Gazebo, of the link that the sensor is in
            there; empty: all of `link` in the file.
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
        feedback: the joint has <provide_feedback>; without it all numbers are 0, as in Gazebo.
    """

    name: str
    link: str
    joint: str
    rate: float = 0.0
    topic: str = "/wrench"
    frame_id: str = ""
    noise_stddev: float = 0.0
    feedback: bool = True


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
class WheelSlipSpec:
    """Gazebo's WheelSlipPlugin, and gazebo_ros_wheel_slip, whose compliances can be changed.

    Attributes:
        namespace: of its dynamic_reconfigure; empty: it has none.
    """

    name: str
    link: str
    wheels: tuple[SlippingWheel, ...]
    namespace: str = ""
    topic: str = ""


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


@dataclass(frozen=True)
class GraspingArm:
    """A gripper: its name, the link that holds, and those that touch."""

    name: str
    palm: str
    fingers: tuple[str, ...]


@dataclass(frozen=True)
class GraspFixSpec:
    """libgazebo_grasp_fix: attaches what a gripper's links press from opposite sides.

    Attributes:
        link: the palm of the first arm.
        angle: between two forces that are opposite, at least [rad].
        decisions: a second [Hz].
        most: highest count of decisions for which an object was gripped.
        threshold: count above which it is attached.
        tolerance: by which a finger may leave a held object [m].
        passes: a held object collides with nothing.
    """

    name: str
    link: str
    arms: tuple[GraspingArm, ...]
    angle: float
    decisions: float = 5.0
    most: int = 10
    threshold: int = 5
    tolerance: float = 0.005
    passes: bool = False
    topic: str = ""


@dataclass(frozen=True)
class GripperSpec:
    """SDF's <gripper>: attaches what its links touch while it rests relative to the palm.

    Attributes:
        link, fingers: the palm, and the links that touch.
        least: contacts between two decisions with which one counts as touching.
        attach, detach: decisions in a row, more of which attach an object, or let it go.
    """

    name: str
    link: str
    fingers: tuple[str, ...]
    least: int = 2
    attach: int = 20
    detach: int = 40
    topic: str = ""


@dataclass(frozen=True)
class Floating:
    """A link that displaces a volume [m^3], whose center (3,) [m] is in its frame."""

    link: str
    volume: float
    center: Vec3


@dataclass(frozen=True)
class BuoyancySpec:
    """Gazebo's BuoyancyPlugin: everything is in a fluid of a density [kg/m^3].

    Attributes:
        given: links whose volume the file gives.
    """

    name: str
    link: str
    density: float
    given: tuple[Floating, ...] = ()
    topic: str = ""


@dataclass(frozen=True)
class ElevatorSpec:
    """libgazebo_ros_elevator: a lift that goes to floors, and its door.

    Attributes:
        lift, door: joints.
        height: of a floor [m].
        wait: for which the door is open [s].
        topic: of std_msgs/String, the number of a floor.
    """

    name: str
    link: str
    lift: str
    door: str
    height: float
    wait: float
    topic: str


@sensor_plugin("gazebo_ros_bumper", types=("contact",))
def bumper(xml: SensorXml) -> ContactSpec:
    # As sdformat: the name that it gives where there is none is that of no collision.
    named = [(element.text or "").strip() for element in xml.sensor.findall("contact/collision")]
    named = named or ["__default__"]
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
    if xml.merged(child) != child:
        raise MissingPart(
            f"{xml.label} has jointName '{joint}', which is a fixed joint that merges its links, "
            "as in Gazebo: give it <preserveFixedJoint>; it is left out",
            "force sensors are at fixed joints that merge their links and are left out",
            f"{xml.label} '{joint}'",
        )
    xml.model.measured.add(joint)
    return ForceTorqueSpec(
        name=xml.name or joint,
        link=child,
        joint=joint,
        rate=max(0.0, xml.number("updateRate")),
        topic=xml.given_topic(),
        frame_id=FrameName(child, xml.names.prefix()),
        noise_stddev=abs(xml.number("gaussianNoise")),
        feedback=_gives_feedback(xml, joint),
    )


def _gives_feedback(xml: PluginXml, joint: str) -> bool:
    """Whether a joint has <provideFeedback>, <provide_feedback> or a force_torque sensor."""
    tags = ("provideFeedback", "physics/provide_feedback", "physics/ode/provide_feedback")
    names = {joint, xml.text("jointName")}
    for holder in document_root(xml.element).iter():
        if holder.tag == "gazebo":
            name = holder.get("reference")
        else:
            name = holder.get("name") if holder.tag == "joint" else None
        if name in names and (
            any(is_true(child_text(holder, tag)) for tag in tags)
            or any(each.get("type") == "force_torque" for each in holder.findall("sensor"))
        ):
            return True
    return False


@model_plugin("gazebo_ros_f3d")
def f3d(xml: PluginXml) -> LinkForceSpec:
    link = xml.link("bodyName")
    return LinkForceSpec(
        name=xml.name or link,
        link=link,
        topic=xml.given_topic(),
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
    return ForceSpec(xml.name or "force", xml.link("bodyName"), xml.given_topic())


@model_plugin("gazebo_ros_vacuum_gripper")
def vacuum_gripper(xml: PluginXml) -> VacuumGripperSpec:
    namespace = xml.names.topic("").rstrip("/")
    name, link = xml.name or "vacuum_gripper", xml.link("bodyName")
    return VacuumGripperSpec(name, link, xml.given_topic(), namespace)


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
    return WheelSlipSpec(xml.name or "wheel_slip", xml.model.root, usable, namespace)


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


@model_plugin("gazebo_grasp_fix")
def grasp_fix(xml: PluginXml) -> GraspFixSpec:
    """GraspFixSpec; an <arm> that cannot be used is left out with a warning.

    Raises:
        MissingPart: no arm is left.
    """
    found = [_arm(xml, element) for element in xml.element.findall("arm")]
    arms = {arm.name: arm for arm in found if arm is not None}
    if not arms:
        raise MissingPart(f"{xml.label} has no <arm> that it can use; it is left out")
    most = int(xml.number("max_grip_count", 10.0))
    palm = next(iter(arms.values())).palm
    return GraspFixSpec(
        xml.name or "grasp_fix",
        palm,
        tuple(arms.values()),
        math.radians(xml.number("forces_angle_tolerance", 120.0)),
        max(0.0, float(int(xml.number("update_rate", 5.0)))),
        most,
        int(xml.number("grip_count_threshold", float(most // 2))),
        xml.number("release_tolerance", 0.005),
        xml.switch("disable_collisions_on_attach"),
    )


def _arm(xml: PluginXml, element: Element) -> GraspingArm | None:
    """An <arm>, or None, with a warning, without a palm or a link that touches."""
    values = Values(element, f"{xml.label} <arm>")
    name, links = values.text("arm_name"), xml.model.links
    palm = xml.scope + values.text("palm_link")
    wanted = [xml.scope + (each.text or "").strip() for each in element.findall("gripper_link")]
    fingers = tuple(link for link in wanted if link in links)
    if name and palm in links and fingers:
        return GraspingArm(name, palm, fingers)
    xml.warn(
        f"{values.label} '{name}' has palm_link '{palm}' and the gripper_links "
        f"{', '.join(wanted) or '(none)'}, must be links of '{xml.model.name}'; it is left out"
    )
    return None


@model_plugin("BuoyancyPlugin")
def buoyancy(xml: PluginXml) -> BuoyancySpec:
    """BuoyancySpec; a <link> without a link, a center or a volume is left out with a warning."""
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
    density = xml.number("fluid_density", 999.1026)  # of water
    return BuoyancySpec(xml.name or "buoyancy", xml.model.root, density, tuple(given))


@model_plugin("gazebo_ros_elevator")
def elevator(xml: PluginXml) -> ElevatorSpec:
    lift, door = xml.joint("lift_joint"), xml.joint("door_joint")
    return ElevatorSpec(
        xml.name or "elevator",
        xml.model.joints[lift].child,
        lift,
        door,
        xml.number("floor_height", 3.0),
        xml.number("door_wait_time", 5.0),
        xml.topic("topic", "elevator"),
    )


@model_plugin("gazebo_ros_template")
def template(_: PluginXml) -> None:
    """The example of gazebo_plugins, which does nothing."""


def parse_gripper(element: Element, model: ModelDescription, scope: str) -> None:
    """Read a <gripper> of a model into its description; an unusable one is a warning.

    Args:
        scope: prefix of the names of its model's links.
    """
    values = Values(element, f"gripper '{element.get('name')}' of '{model.name}'")
    palm = scope + values.text("palm_link")
    named = [scope + (each.text or "").strip() for each in element.findall("gripper_link")]
    fingers = tuple(name for name in named if name in model.links)
    if palm not in model.links or not fingers:
        model.warn(
            f"{values.label} has palm_link '{palm}' and the gripper_links {', '.join(named)}, must "
            "be links of the model; it is left out",
            "grippers name links that do not exist and are left out",
            values.label,
        )
        return
    least, attach, detach = (
        int(values.number(f"grasp_check/{tag}", default))
        for tag, default in (("min_contact_count", 2), ("attach_steps", 20), ("detach_steps", 40))
    )
    name = element.get("name") or "gripper"
    model.sensors.append(GripperSpec(name, palm, fingers, least, attach, detach))
