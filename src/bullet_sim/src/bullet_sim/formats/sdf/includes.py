"""<include> within a <model>: its content becomes the model's, under names with a prefix.

As sdformat 9 does it (addNestedModel of its parser.cc): links, joints, frames, models, plugins and
all else of the included model are copied, and the names of the first four are replaced wherever
they are a whole attribute or a whole text, also in plugins and sensors.
"""

from __future__ import annotations

from typing import Callable, Tuple

from bullet_sim.errors import ModelError
from bullet_sim.formats.joints import Version
from bullet_sim.xml_reader import Node, add_child, child_flag, child_text

OpenInclude = Callable[[Node], Tuple[Node, Version]]  # <include> -> <model> of its file
Warn = Callable[[str, str, str], None]
MAX_DEPTH = 10  # of models included by models
MAX_INCLUDES = 1000  # of models that one model includes directly or indirectly
FRAME = "__model__"
_NAMED = ("link", "model", "joint", "frame")
_IN_PARENT_FRAME: Version = (1, 5)  # before it axes of joints are in the model's frame


class Includes:
    """Replaces the <include>s of one model.

    Args:
        name: of the model, for messages.
        open_include: reads the file of an <include>.
        warn: takes what cannot be included: see ModelDescription.warn.
    """

    def __init__(self, name: str, open_include: OpenInclude, warn: Warn) -> None:
        self._name, self._open, self._warn = name, open_include, warn
        self._included = 0

    def replace(self, model: Node, depth: int = 0) -> None:
        """Put the content of included models into a <model>, and into those that it contains."""
        taken: set[str] = set()
        for child in list(model):
            if child.tag == "model":
                self.replace(child, depth)
            elif child.tag == "include":
                place = list(model).index(child)
                model.remove(child)
                for number, part in enumerate(self._content(child, taken, depth)):
                    model.insert(place + number, part)

    def _content(self, include: Node, taken: set[str], depth: int) -> list[Node]:
        """What takes the place of an <include>: nothing, with a warning, if it cannot be used."""
        uri = child_text(include, "uri", "")
        try:
            if depth >= MAX_DEPTH:
                raise ModelError("models include each other in a circle")
            if self._included >= MAX_INCLUDES:
                raise ModelError(f"{MAX_INCLUDES} models are included already, which is the most")
            self._included += 1
            inner, version = self._open(include)
            if inner.tag == "robot":
                raise ModelError("it is a URDF, which only a <world> can include here")
        except (OSError, ValueError) as error:
            self._warn(
                f"model '{self._name}' includes '{uri}', which cannot be used: {error}",
                "included models cannot be used",
                f"'{uri}'",
            )
            return []
        self.replace(inner, depth + 1)
        name = unused(child_text(include, "name") or inner.get("name") or "model", taken, include)
        taken.add(name)
        _take_over(include, inner)
        for joint in inner.findall("joint"):
            _name_frame_of_axes(joint, version)
        frame = _frame(name, include, inner)
        _rename(inner, name)
        return [frame, *(part for part in inner if part.tag != "pose")]


def unused(name: str, taken: set[str], element: Node) -> str:
    """A name that is not taken: with a number appended and a warning if necessary."""
    free, number = name, 0
    while free in taken:
        number += 1
        free = f"{name}_{number}"
    if number:
        element.warn(
            f"there is a {element.tag} '{name}' already; this one becomes '{free}'",
            f"<{element.tag}>s have a name that is taken and get a number",
            f"'{free}'",
        )
    return free


def _take_over(include: Node, inner: Node) -> None:
    """Give a model the <static> and the <plugin>s of its <include>."""
    static = include.find("static")
    if static is not None:
        for old in inner.findall("static"):
            inner.remove(old)
        inner.append(static)
    for plugin in include.findall("plugin"):
        inner.append(plugin)


def _name_frame_of_axes(joint: Node, version: Version) -> None:
    """Have axes that are in the model's frame say so by name, whatever the version."""
    for axis in (*joint.findall("axis"), *joint.findall("axis2")):
        label = f"joint '{joint.get('name')}' axis"
        of_model = child_flag(axis, "use_parent_model_frame", label, version < _IN_PARENT_FRAME)
        for flag in axis.findall("use_parent_model_frame"):
            axis.remove(flag)
        add_child(axis, "use_parent_model_frame", "false")
        if of_model:
            xyz = axis.find("xyz")
            xyz = add_child(axis, "xyz", "0 0 1") if xyz is None else xyz
            if xyz.get("expressed_in") is None:
                xyz.set("expressed_in", FRAME)


def _frame(name: str, include: Node, inner: Node) -> Node:
    """The <frame> that stands for an included model's own frame."""
    frame = Node("frame", name=f"{name}::{FRAME}")
    frame.document, frame.line = include.document, include.line
    posed = include if include.find("pose") is not None else inner
    pose = posed.find("pose")
    copy = add_child(frame, "pose", "" if pose is None else pose.text or "")
    relative_to = "" if pose is None else pose.get("relative_to") or ""
    copy.set("relative_to", relative_to or FRAME)
    return frame


def _rename(inner: Node, name: str) -> None:
    """Put the prefix before the names of an included model, wherever they occur in it."""
    frame = f"{name}::{FRAME}"
    names = {FRAME: frame}
    for part in inner:
        if part.tag not in _NAMED:
            continue
        own = part.get("name")
        if own:
            names[own] = f"{name}::{own}"
        if part.tag in ("link", "model"):
            pose = part.find("pose")
            pose = add_child(part, "pose", "") if pose is None else pose
            if not pose.get("relative_to"):
                pose.set("relative_to", frame)
        elif part.tag == "frame" and not part.get("attached_to"):
            part.set("attached_to", frame)
    ordered = sorted(names.items())
    for node in inner.iter():
        for key, value in node.attrib.items():
            node.set(key, _renamed(value, ordered, False))
        if node.text and not node.text.isspace():
            node.text = _renamed(node.text.strip(), ordered, True)


def _renamed(text: str, names: list[tuple[str, str]], with_scopes: bool) -> str:
    """An attribute, or a text in which scoped names count as well, with the new names."""
    for old, new in names:
        if text == old:
            text = new
        if with_scopes and text.startswith(f"{old}::"):
            text = new + text[len(old) :]
    return text
