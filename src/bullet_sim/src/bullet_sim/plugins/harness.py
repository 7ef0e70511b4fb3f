"""A harness, which lowers a model and lets it go, and the topics of a projector."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import partial
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np

from bullet_sim.component import Stateful
from bullet_sim.description.model import Joint
from bullet_sim.engine import WORLD as WORLD_LINK
from bullet_sim.parts.base import Acting, Preparing, part_of
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


STILL = 1e-6  # [rad/s, m/s] of a winch that is to hold its position


class WinchPid(Stateful):
    """Gazebo's PID, of the error of a state less its target."""

    STATE = ("state",)

    def __init__(self, gains: WinchGains) -> None:
        self._gains = gains
        self.state = (0.0, 0.0)  # integral term, last error

    def update(self, error: float, period: float) -> float:
        """The command; the rate of the first error is that of a change from 0, as there."""
        gains, (integral, last) = self._gains, self.state
        if not (period > 0.0 and math.isfinite(error)):
            return 0.0
        integral = _bounded(integral + gains.i * period * error, gains.i_min, gains.i_max)
        self.state = integral, error
        command = -gains.p * error - integral - gains.d * (error - last) / period
        return _bounded(command, gains.least, gains.most)


def _bounded(value: float, least: float, most: float) -> float:
    """A value within bounds, which count where they are in order."""
    return max(least, min(most, value)) if most >= least else value


@part_of(HarnessSpec)
class HarnessPlugin(Acting):
    """Holds its model by joints, of which it drives one and lets one go.

    While its velocity is 0 the winch holds its position. It pulls alone by its velocity's gains,
    which never push. Numbers are in single precision, as there. Without a winch it lets go at once.
    """

    STATE = ("_target", "_held_at", "_is_held", "_positions", "_speeds", "_wanted", "_ends")
    CACHE = ("_joints",)
    COMMANDS = {
        "velocity_topic": ("std_msgs/Float32", "_on_velocity"),
        "topic": ("std_msgs/Bool", "_on_detach"),
    }

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        self._joints: list[Joint] = []

    def reset(self, time: float) -> None:
        """Held where the model is, by a winch that stands."""
        self._target = self._held_at = 0.0
        self._wanted: float | None = None  # velocity that the next update takes
        self._is_held, self._ends = True, False
        self._positions, self._speeds = WinchPid(self.spec.position), WinchPid(self.spec.velocity)
        self._joints = [self._in_body(joint) for joint in self.spec.joints]
        for joint in self._joints:
            self.model.change(self._key(joint), partial(self._attach, joint))
        super().reset(time)

    def _key(self, joint: Joint) -> tuple[str, str]:
        """Of the model's changes."""
        return "harness", joint.name

    def _attachment(self, joint: Joint) -> tuple[str, str, str]:
        """Key of the engine's."""
        return (self.model.name, *self._key(joint))

    def _in_body(self, joint: Joint) -> Joint:
        """A joint with its frame in that of the link of the engine that its child is in."""
        return replace(joint, anchor=self.model.link_in_body(joint.child)[1] * joint.anchor)

    def _attach(self, joint: Joint) -> None:
        number, part = self.model.body.number, self.model.link_in_body
        parent = WORLD_LINK if joint.parent == WORLD else (number, part(joint.parent)[0])
        child, key = (number, part(joint.child)[0]), self._attachment(joint)
        if not self.world.engine.attach_by_joint(key, parent, child, joint):
            text = "the solver 'bullet' has no joints of a HarnessPlugin"
            self.log_warning(text, every=math.inf)

    def _remove(self, joint: Joint) -> None:
        self.world.engine.detach(self._attachment(joint))

    def _on_velocity(self, message: Any) -> None:
        value = float(message.data)
        if not self._is_held or self.spec.winch < 0:
            self.log_error("No known winch joint to set velocity")
        elif not math.isfinite(value):
            self.log_error(f"{self.spec.velocity_topic} is {value:g}, must be a finite number")
        else:
            self._wanted = value

    def _lower(self, velocity: float) -> None:
        """Have the winch move at a velocity, or hold where it is."""
        self._target = float(np.float32(velocity))
        if abs(self._target) <= STILL:
            self._held_at = float(np.float32(self._winch()[0]))
            self._positions.state = (0.0, 0.0)

    def _on_detach(self, message: Any) -> None:
        if message.data:
            self._ends = True

    def _let_go(self) -> None:
        """Remove the joint that is to be detached; the others stay, and nothing is driven."""
        if not self._is_held or self.spec.detach < 0:
            self.log_error("No known joint to detach")
            return
        self._is_held = False
        joint = self._joints[self.spec.detach]
        self.model.change(self._key(joint), partial(self._remove, joint))

    def _winch(self) -> tuple[float, float]:
        """Position and velocity of the winch."""
        key = self._attachment(self._joints[self.spec.winch])
        return self.world.engine.attached_state(key)

    def update(self, time: float, period: float) -> None:
        if self._wanted is not None:
            self._lower(self._wanted)
            self._wanted = None
        if self._ends or (self._is_held and self.spec.winch < 0 <= self.spec.detach):
            self._let_go()
            self._ends = False
        if not self._is_held or self.spec.winch < 0:
            return
        joint, step = self._joints[self.spec.winch], self.world.time_step
        position, speed = self._winch()
        error = position - self._held_at if abs(self._target) <= STILL else 0.0
        effort = self._positions.update(error, step)
        effort += max(0.0, self._speeds.update(speed - self._target, step))
        if joint.velocity >= 0.0 and abs(speed) > joint.velocity and speed * effort > 0.0:
            effort = 0.0
        if joint.effort >= 0.0:
            effort = max(-joint.effort, min(joint.effort, effort))
        self.world.engine.add_attached_effort(self._attachment(joint), effort)

    def close(self) -> None:
        """Let go of everything."""
        super().close()
        for joint in self._joints:
            self._remove(joint)


@part_of(ProjectorSpec)
class ProjectorPlugin(Preparing):
    """Subscribes to what would choose a projector's texture and switch it; nothing is projected."""

    COMMANDS = {
        "topic": ("std_msgs/String", "_ignore"),
        "switch_topic": ("std_msgs/Int32", "_ignore"),
    }

    def _ignore(self, _message: Any) -> None:
        """Nothing is projected."""
