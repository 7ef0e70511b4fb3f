"""<plugin> and <sensor> elements for their readers: numbers, names, topics, links, poses."""

from __future__ import annotations

import copy
import re
from collections.abc import Iterable
from typing import Any, TypeVar, cast
from xml.etree.ElementTree import Element

import numpy as np

from bullet_sim.description.model import Joint, ModelDescription
from bullet_sim.errors import ModelError
from bullet_sim.plugins.rules import MODEL, NONE, RULES, FrameName, FramePrefix
from bullet_sim.pose import Pose, PoseTuple, Vec3, vector3
from bullet_sim.xml_reader import (
    Node,
    add_child,
    child_flag,
    child_floats,
    child_number,
    child_text,
    child_whole,
    copied,
    document_root,
    floats,
)

# typing.Self needs Python 3.11
_Plugin = TypeVar("_Plugin", bound="PluginXml")
_Sensor = TypeVar("_Sensor", bound="SensorXml")
DEFAULT_RATE = 30.0  # [Hz] of cameras and lidars without a rate; Gazebo's has no limit then


def library(plugin: Element) -> str:
    """Name of a plugin's library without folder, 'lib' and '.so': gazebo_ros_camera."""
    name = (plugin.get("filename") or "").strip().rsplit("/", 1)[-1]
    return re.sub(r"^lib|\.so$", "", name)


def _lumped(model: ModelDescription) -> dict[str, Joint]:
    """The fixed joints of a URDF that Gazebo leaves out, by their child links."""
    return {
        joint.child: joint
        for joint in model.joints.values()
        if joint.kind == "fixed" and joint.name not in model.kept and joint.parent != "world"
    }


def merged_links(model: ModelDescription) -> dict[str, str]:
    """For each link of a URDF: the one that fixed joints merge it into in Gazebo."""
    joints = _lumped(model)
    found: dict[str, str] = {}
    for name in model.links:
        passed, link = [name], name
        while link in joints and link not in found:
            link = joints[link].parent
            passed.append(link)
        found.update(dict.fromkeys(passed, found.get(link, link)))
    return {name: found[name] for name in model.links}


def _above(link: str, joints: dict[str, Joint]) -> list[str]:
    """Links that a link is merged into one after the other."""
    found: dict[str, None] = {link: None}
    while link in joints and joints[link].parent not in found:
        link = joints[link].parent
        found[link] = None
    return [*found][1:]


def offset_of_merged(
    model: ModelDescription, names: Iterable[str], xyz: Vec3, rpy: Vec3
) -> tuple[Vec3, Vec3]:
    """<xyzOffset> [m] and <rpyOffset> [rad] of a plugin, as sdformat leaves them.

    Each time that it writes the parent of a link that it merges in the place of one of the names,
    the deepest links first, it takes the angles for degrees, turns the offset by the inverse of the
    joint's origin and subtracts that one's position (inverseTransformToParentFrame).
    """
    joints = _lumped(model)
    chains = [[name, *_above(name, joints)][:-1] for name in names]
    depth = {name: len(_above(name, joints)) for chain in chains for name in chain}
    for link in sorted(depth, key=lambda name: (-depth[name], name)):
        for chain in chains:
            if link in chain:
                origin = joints[link].origin
                offset = Pose.from_xyz_rpy(xyz, np.radians(rpy))
                turned = Pose((0.0, 0.0, 0.0), origin.orientation).inverse() * offset
                xyz, rpy = vector3(np.subtract(turned.position, origin.position)), turned.rpy
    return xyz, rpy


class MissingPart(ModelError):
    """A plugin names a link or a joint that its model lacks.

    Args:
        cause, item: see ReadWarning.
    """

    def __init__(self, text: str, cause: str = "", item: str = "") -> None:
        super().__init__(text)
        self.cause, self.item = cause, item


class Names:
    """Namespace of one plugin: that of its <robotNamespace>, or what its Rule says.

    The namespace of a spawn request has been written to that tag.

    Attributes:
        namespace: without slashes at its ends; empty: the root namespace.
        keeps_slash: a leading slash stays in its frames.
    """

    def __init__(self, plugin: Element, model: str) -> None:
        name = library(plugin)
        self._rule = RULES.get(name, NONE)
        self.keeps_slash = name in RULES and self._rule.prefix is None
        missing = plugin.find("robotNamespace") is None
        otherwise = self._rule.missing if missing else self._rule.empty
        default = model if otherwise == MODEL else ""
        self.namespace = _squeezed(child_text(plugin, "robotNamespace", default))

    def prefix(self, group: str = "") -> FramePrefix | None:
        """Where the prefix of its frames is found; None: they have none.

        Args:
            group: sub-namespace from which it is looked for, e.g. a camera's name.
        """
        if self._rule.prefix is None:
            return None
        return FramePrefix(self._rule.prefix, _squeezed(f"{self.namespace}/{group}"))

    def topic(self, name: str, group: str = "") -> str:
        """Full topic name.

        Args:
            name: as in the file; one with a leading slash is used unchanged.
            group: sub-namespace, e.g. a camera's name.
        """
        if name.startswith("/"):
            return "/" + _squeezed(name)
        return "/" + _squeezed("/".join([self.namespace, group, name]))


def _squeezed(text: str) -> str:
    return "/".join(part for part in text.split("/") if part)


class Values:
    """Values in the children of an element.

    An invalid value causes a warning and is replaced by the default. In an element that
    belongs to no document (see PluginXml.strict) it raises a ModelError that names the element,
    the tag, the value and what is valid.

    Args:
        element: e.g. the <camera> of a <sensor>.
        label: its name in messages, e.g. "camera 'front'".

    Paths are tags, or tags below each other: "image/width".
    """

    def __init__(self, element: Element, label: str) -> None:
        self.element, self.label = element, label

    def number(self, path: str, default: float = 0.0) -> float:
        """A finite number; the default where the tag is missing or empty."""
        return child_number(self.element, path, self.label, default)

    def whole(self, path: str, default: int) -> int:
        """A whole number of at least 1; a fraction is truncated."""
        return child_whole(self.element, path, self.label, default)

    def flag(self, path: str, default: bool = False) -> bool:
        """True for true, 1, yes and on; False for false, 0, no and off."""
        return child_flag(self.element, path, self.label, default)

    def text(self, path: str, default: str = "") -> str:
        """A text without the spaces around it; the default where the tag is missing or empty."""
        return child_text(self.element, path, default)

    def vector(
        self,
        path: str,
        count: int = 3,
        default: tuple[float, ...] | None = None,
        broadcast: bool = False,
    ) -> Any:
        """A tuple of finite numbers with spaces between them.

        Args:
            default: where the tag is missing or empty; None: zeros.
            broadcast: a single number counts for all.

        Raises:
            ModelError: with broadcast, for each text that is not usable.
        """
        default = (0.0,) * count if default is None else default
        if not broadcast:
            return child_floats(self.element, path, count, self.label, default)
        text, label = self.text(path), f"{self.label} <{path}>"
        if not text:
            return default
        values = floats(text, None, label)
        return values * count if len(values) == 1 else floats(text, count, label)

    def has_noise(self, path: str) -> bool:
        """Whether there is a <noise>, of another type than none."""
        noise = self.element.find(path)
        return noise is not None and (noise.get("type") or child_text(noise, "type")) != "none"

    def noise(self, path: str) -> tuple[float, float]:
        """(mean, standard deviation) of a Gaussian <noise>; zeros where there is none."""
        noise = self.element.find(path)
        if noise is None or not self.has_noise(path):
            return 0.0, 0.0
        values = Values(noise, self.label)
        return values.number("mean"), abs(values.number("stddev"))


class PluginValues(Values):
    """Values in the children of a <plugin>."""

    def number(self, path: str, default: float = 0.0) -> float:
        """A finite number; the default where the tag is missing.

        As sdformat reads it, any other text than a number and an empty tag are 0.
        """
        return super().number(path, default if self.element.find(path) is None else 0.0)

    def switch(self, path: str, default: bool = False) -> bool:
        """Whether the text is true or 1, as sdformat reads it; the default where it is missing."""
        if self.element.find(path) is None:
            return default
        return self.text(path).lower() in ("true", "1")

    def option(self, path: str, default: bool = False) -> bool:
        """As getParameterBoolean of gazebo_ros_utils: the default, too, where the text is none of
        true, 1, false and 0."""
        known = self.text(path).lower() in ("true", "1", "false", "0")
        return self.switch(path, default) if known else default


class PluginXml(PluginValues):
    """A <plugin> of a model.

    Args:
        scope: before the names of its model's links and joints, where that is inside another one,
            e.g. "arm::".

    Attributes:
        name: its name; empty: it has none.
        label: "plugin 'libNAME.so'", its name in messages.
    """

    def __init__(self, element: Element, model: ModelDescription, scope: str = "") -> None:
        super().__init__(element, f"plugin '{element.get('filename')}'")
        self.model, self.name, self.scope = model, element.get("name") or "", scope
        self.names = Names(element, scope.split("::")[-2] if scope else model.name)

    def warn(self, text: str, cause: str = "", item: str = "") -> None:
        """ModelDescription.warn; raises ModelError in a strict copy."""
        if getattr(self.element, "document", None) is None:
            raise ModelError(text)
        self.model.warn(text, cause, item)

    def strict(self: _Plugin) -> _Plugin:
        """A copy that raises ModelError where this one warns."""
        other = copy.copy(self)
        other.element = copy.deepcopy(self.element)  # which belongs to no document
        return other

    def topic(self, tag: str, default: str, group: str = "") -> str:
        """Full name of the topic that a tag names: see Names.topic."""
        return self.names.topic(self.text(tag, default), group)

    def given_topic(self, tag: str = "topicName") -> str:
        """Full name of the topic of a tag without which upstream does not start.

        Raises:
            MissingPart: there is none.
        """
        if not self.text(tag):
            raise self.lacks(tag)
        return self.topic(tag, "")

    def lacks(self, tag: str) -> MissingPart:
        """The error of a plugin without a tag that it needs."""
        return MissingPart(f"{self.label} has no {tag}; it is left out")

    def frame(self, tag: str, default: str, group: str = "", merge: bool = False) -> FrameName:
        """Name of the frame that a tag names, for headers.

        As in Gazebo an empty tag is an empty frame; the default is that of a missing tag. No
        prefix goes before a name with a leading slash, which tf's resolve() takes away: it stays
        in those of Gazebo's plugins that do not call it.

        Args:
            group: see Names.prefix.
            merge: the name of a link becomes that of the one it is merged into.
        """
        name = self.text(tag) if self.element.find(tag) is not None else default
        prefix = self.names.prefix(group)
        if name.startswith("/") and not self.names.keeps_slash:
            prefix, name = None, name.lstrip("/")
        return FrameName(self.merged(name) if merge else name, prefix)

    def link(self, tag: str, default: str | None = None) -> str:
        """Link that a tag names as 'link', '/link' or 'model::link'.

        Args:
            tag: e.g. "bodyName".
            default: link where the tag is missing; None: it must be there.

        Raises:
            MissingPart: the model has no such link.
        """
        text, links = self.text(tag, default or ""), self.model.links
        scoped = self.scope + text
        name = scoped if scoped in links else text
        name = name if name in links else text.rsplit("::", 1)[-1].lstrip("/")
        if name in links:
            return name
        if default is None:
            raise self.names_no(tag, text, links, "link")
        raise MissingPart(
            f"{self.label} has {tag} '{name}', which is no link; it is left out",
            "plugins name a link that does not exist and are left out",
            self.label,
        )

    def merged(self, link: str) -> str:
        """Link that Gazebo knows a link as: of a URDF, the one that fixed joints merge it into.

        It writes that name into <bodyName> and <frameName> of plugins that are in no sensor. Any
        other name stays.
        """
        robot = document_root(self.element)
        return merged_links(self.model).get(link, link) if robot.tag == "robot" else link

    def in_scope(self, joint: str) -> str:
        """Name that a joint of the plugin's own model has in the outermost one."""
        scoped = self.scope + joint
        return scoped if scoped in self.model.joints else joint

    def joint(self, tag: str) -> str:
        """Joint that a tag names; raises MissingPart where the model has no such joint."""
        name, joints = self.in_scope(self.text(tag)), self.model.joints
        if name not in joints:
            raise self.names_no(tag, name, joints, "joint")
        return name

    def names_no(self, tag: str, name: str, known: Iterable[str], part: str) -> MissingPart:
        """The error of a tag with a name that is none of the known ones of a part of the model."""
        return MissingPart(
            f"{self.label} has {tag} '{name}', which is no {part}; {part}s are "
            f"{', '.join(known) or '(none)'}; it is left out"
        )


class SensorXml(PluginXml):
    """A <plugin> of a <sensor>.

    Args:
        pose: of the sensor in that link's frame.

    Attributes:
        name: the sensor's name.
        plugin_name: the plugin's; empty: it has none.
        type: the sensor's, e.g. "camera".
        pose: (xyz [m], rpy [rad]).
    """

    def __init__(
        self, element: Element, model: ModelDescription, sensor: Element, parent: str, pose: Pose
    ) -> None:
        super().__init__(element, model)
        self.plugin_name, self.name = self.name, sensor.get("name") or "sensor"
        self.sensor, self.type, self.parent = sensor, sensor.get("type"), parent
        self.pose: PoseTuple = (pose.position, pose.rpy)

    def strict(self: _Sensor) -> _Sensor:
        """A copy that raises ModelError where this one warns."""
        other = super().strict()
        other.sensor = copy.deepcopy(self.sensor)
        return other

    def plugin(self, sensor_name: str) -> PluginValues:
        """The plugin's values; in messages it is e.g. "camera 'front'"."""
        return PluginValues(self.element, f"{sensor_name} '{self.name}'")

    def part(self, tag: str, sensor_name: str) -> Values:
        """The element with the sensor's numbers, e.g. <ray>; without it all have their defaults.

        Args:
            tag: e.g. "ray".
            sensor_name: for messages: "lidar" for "lidar 'front'".
        """
        part = self.sensor.find(tag)
        if part is None:
            part = add_child(copied(cast(Node, self.sensor)), tag, "")
        return Values(part, f"{sensor_name} '{self.name}'")

    def rate(self, tag: str | None = "updateRate", default: float = 0.0) -> float:
        """The lower of the sensor's and the plugin's rate [Hz]; 0: neither gives one.

        Args:
            tag: the plugin's; None: it has none.
            default: the plugin's rate where the tag is missing [Hz].
        """
        rates = [Values(self.sensor, f"sensor '{self.name}'").number("update_rate")]
        if tag is not None:
            rates.append(self.plugin("sensor").number(tag, default))
        return min((rate for rate in rates if rate > 0), default=0.0)

    def output_rate(self, tag: str | None = "updateRate") -> float:
        """As rate, for cameras and lidars: DEFAULT_RATE where none is given."""
        rate = self.rate(tag)
        if not rate:
            self.warn(
                f"sensor '{self.name}' has no update rate; it runs at {DEFAULT_RATE:g} Hz",
                f"sensors have no update rate and run at {DEFAULT_RATE:g} Hz",
                f"'{self.name}'",
            )
        return rate or DEFAULT_RATE
