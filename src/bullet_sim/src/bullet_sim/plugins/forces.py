"""Forces on links, applied and measured: wrenches, a vacuum gripper, slip."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np

from bullet_sim.controllers import MAX_COMMAND
from bullet_sim.parts.base import Acting, Sensor, part_of
from bullet_sim.parts.outputs import NumbersOutput, TransformsOutput
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
)
from bullet_sim.plugins.xml import MissingPart, PluginXml, Values, library
from bullet_sim.pose import Pose
from bullet_sim.sensors.inertial import joint_wrench, net_wrench
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

    INTERFACE = "force_torque"
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


@model_plugin("gazebo_ros_template")
def template(_: PluginXml) -> None:
    """The example of gazebo_plugins, which does nothing."""


@part_of(ForceSpec)
class ForcePlugin(Acting):
    """Applies the last geometry_msgs/Wrench to a link in every step, along the world's axes."""

    STATE = ("_wrench",)
    COMMANDS = {"topic": ("geometry_msgs/Wrench", "_on_wrench")}

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        self._part, _ = self.model.link_in_body(self.spec.link)

    def reset(self, time: float) -> None:
        """Without a wrench."""
        self._wrench = (np.zeros(3), np.zeros(3))
        super().reset(time)

    def _on_wrench(self, message: Any) -> None:
        wrench = np.array([(v.x, v.y, v.z) for v in (message.force, message.torque)])
        if not np.abs(wrench).max() <= MAX_COMMAND:  # also of NaN
            self.log_error(
                f"{self.spec.topic}: wrench {wrench.ravel().tolist()}, must be finite numbers, at "
                f"most {MAX_COMMAND:g} either way; the last valid one is kept",
                every=1.0,
            )
            return
        self._wrench = wrench[0], wrench[1]

    def update(self, time: float, period: float) -> None:
        force, torque = self._wrench
        if force.any() or torque.any():
            self.model.apply_wrench(self._part, force, torque)


REACH = 0.05  # [m] between the origins of two links, below which the gripper draws
NEAR = 0.01  # [m] below which it holds the other's origin at its own
MAX_PULL = 20.0  # [N]


@part_of(VacuumGripperSpec)
class VacuumGripperPlugin(Acting):
    """Draws links of other models that are near its link; std_msgs/Bool tells whether there is one.

    While it is on, such a link gets the gripper's velocity and a force towards it. As upstream the
    force is computed along the other link's axes and acts along the world's. Of models with several
    links only the root link gets the velocity.
    """

    STATE = ("_is_on",)

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        self._is_on = False
        self._grasping = self.output(NumbersOutput(self.spec.topic, "std_msgs/Bool", {"data": 1}))

    def offer(self) -> None:
        for name, is_on in (("on", True), ("off", False)):
            service = f"{self.spec.namespace}/{name}"
            self.service(service, "std_srvs/Empty", partial(self._switch, is_on))

    def _switch(self, is_on: bool, _request: Any) -> None:
        if self._is_on == is_on:
            word = "on" if is_on else "off"
            self.log_warning(f"gazebo_ros_vacuum_gripper: already status is '{word}'")
        self._is_on = is_on

    def update(self, time: float, period: float) -> None:
        draws = False
        if self._is_on:
            pose, linear, angular = self.model.link_state(self.spec.link)
            for model in self.world.models.values():
                if model is not self.model and model.name != self.spec.link:
                    for link in model.rigid_parts:
                        draws |= self._draw(model, link, pose, linear, angular)
        if self._grasping.has_subscribers():
            self._grasping.send(time, (draws,))

    @staticmethod
    def _draw(model: Any, link: str, pose: Pose, linear: Any, angular: Any) -> bool:
        """Draw a model's link to a pose; returns whether it is near enough, static or not."""
        own = model.link_state(link)[0]
        away = np.array((own.inverse() * pose).position)
        distance = float(np.linalg.norm(away))
        if distance >= REACH:
            return False
        if model.is_static:
            return True
        if link != model.description.root:
            pass
        elif distance < NEAR:
            there = Pose(pose.position, own.orientation) * model.description.root_pose.inverse()
            model.set_state(there, linear, angular)
        else:
            model.body.set_velocity(linear, angular)
        if distance > 0.0:
            pull = min(1.0 / distance, MAX_PULL) * away / distance
            model.apply_wrench(model.link_in_body(link)[0], pull, np.zeros(3))
        return True


# As gazebo_plugins' cfg/WheelSlip.cfg: what is below 0 changes nothing.
_SLIP = tuple(
    (
        f"slip_compliance_unitless_{side}",
        "double",
        -1.0,
        -1.0,
        20.0,
        f"Unitless slip compliance (slip over friction), {side}.",
    )
    for side in ("lateral", "longitudinal")
)


@part_of(WheelSlipSpec)
class WheelSlipPlugin(Acting):
    """Sets slip1 and slip2 of wheels' contacts: their rims' speed times compliance over force."""

    STATE = ("_lateral", "_longitudinal")

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        wheels, model = self.spec.wheels, self.model
        self._lateral = [wheel.lateral for wheel in wheels]
        self._longitudinal = [wheel.longitudinal for wheel in wheels]
        self._links = [model.link_in_body(wheel.link)[0] for wheel in wheels]

    def offer(self) -> None:
        if self.spec.namespace:
            values = {row[0]: row[2] for row in _SLIP}
            self.reconfigure(self.spec.namespace, _SLIP, values, self._on_values)

    def _on_values(self, config: Any, _level: int) -> Any:
        lateral, longitudinal = (config[row[0]] for row in _SLIP)
        self.call(lambda: self._set(lateral, longitudinal))
        return config

    def _set(self, lateral: float, longitudinal: float) -> None:
        """New compliances of all wheels; below 0: as they are."""
        count = len(self.spec.wheels)
        if lateral >= 0.0:
            self._lateral = [lateral] * count
        if longitudinal >= 0.0:
            self._longitudinal = [longitudinal] * count

    def update(self, time: float, period: float) -> None:
        model = self.model
        slips = zip(self.spec.wheels, self._links, self._lateral, self._longitudinal)
        for wheel, link, lateral, longitudinal in slips:
            joint = model.description.joints[wheel.joint]
            pose, _, angular = model.link_state(wheel.link)
            axis = pose.matrix @ np.asarray(joint.axis) / np.linalg.norm(joint.axis)
            scale = wheel.radius * abs(float(angular @ axis)) / wheel.force
            model.body.set_slip(link, scale * lateral, scale * longitudinal)


@part_of(HandOfGodSpec)
class HandOfGodPlugin(Acting):
    """Pulls a link to the frame FRAME_desired by a critically damped spring; sends FRAME_actual."""

    needs_ros = True
    CACHE = ("_missing",)  # whether it was logged

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        spec, model = self.spec, self.model
        self._part, _ = model.link_in_body(spec.link)
        part = model.rigid_parts[self._part]
        self._damping = (
            2.0 * math.sqrt(spec.linear * part.mass),
            2.0 * math.sqrt(spec.angular * part.inertia[0, 0]),
        )
        self._missing = False
        self._actual = self.output(TransformsOutput(spec.topic))
        self._frames = self.transforms()

    def _desired(self) -> Pose | None:
        """Pose to pull to, or None, logged once."""
        try:
            pose: Pose = self._frames.pose_in("world", f"{self.spec.frame}_desired")
        except LookupError as error:
            if not self._missing:
                self.log_error(f"hand of god: {error}")
            self._missing = True
            return None
        self._missing = False
        return pose

    def update(self, time: float, period: float) -> None:
        desired = self._desired()
        if desired is None:
            return
        pose, linear, angular = self.model.link_state(self.spec.link)
        away = np.subtract(desired.position, pose.position)
        x, y, z, w = (pose.inverse() * desired).orientation
        sign = -1.0 if w < 0.0 else 1.0
        sine = math.sqrt(x * x + y * y + z * z)
        half = math.atan2(sine, sign * w) / sine if sine > 1e-12 else 1.0
        rotation = sign * half * np.array((x, y, z))  # half the vector, as upstream takes it
        force = self.spec.linear * away - self._damping[0] * linear
        torque = pose.matrix @ (self.spec.angular * rotation) - self._damping[1] * angular
        self.model.apply_wrench(self._part, force, torque)
        if self._actual.has_subscribers():
            self._actual.send(time, [("world", f"{self.spec.frame}_actual", pose)])


_WRENCH = {"wrench.force": 3, "wrench.torque": 3}


@part_of(ForceTorqueSpec)
class ForceTorqueSensor(Sensor):
    """geometry_msgs/WrenchStamped of a joint: its child link on its parent, child's axes.

    Zeros of a joint without <provide_feedback>.
    """

    MESSAGE, FIELDS = "geometry_msgs/WrenchStamped", _WRENCH
    whole_periods = True
    waits_for_time = True

    def measure(self, time: float) -> Any:
        wrench: Any = (np.zeros(3), np.zeros(3))
        if self.spec.feedback:
            wrench = joint_wrench(self.model, self.spec.joint)
        if self.spec.noise_stddev:
            wrench = [v + self.rng.normal(0.0, self.spec.noise_stddev, 3) for v in wrench]
        return wrench


@part_of(LinkForceSpec)
class LinkForceSensor(Sensor):
    """geometry_msgs/WrenchStamped of the net force on a link, mean over a step, world axes."""

    STATE = ("_before",)
    MESSAGE, FIELDS = "geometry_msgs/WrenchStamped", _WRENCH

    def start(self, time: float) -> None:
        """Measure from now on."""
        self._before: Any = None  # (velocity, angular velocity, time) at the last measurement

    def measure(self, time: float) -> Any:
        part = self.model.description.links[self.spec.link]
        pose, linear, angular = self.model.link_state(self.spec.link)
        speed = linear + np.cross(angular, pose.matrix @ part.center)
        before, self._before = self._before, (speed, angular, time)
        if before is None or not time > before[2]:
            return None
        inertia = pose.matrix @ part.inertia @ pose.matrix.T
        return net_wrench(part.mass, inertia, before[:2], (speed, angular), time - before[2])
