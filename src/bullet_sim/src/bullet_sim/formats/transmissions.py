"""<transmission>s of a URDF, as ros_control's transmission_parser.cpp (noetic) reads them."""

from __future__ import annotations

from bullet_sim.description.transmissions import Transmission, Transmissions
from bullet_sim.xml_reader import Node


class _LeftOut(Exception):
    """Why the parser leaves a transmission out."""


def parse_transmissions(robot: Node) -> Transmissions:
    """Read every <transmission> child of <robot>; one of them that lacks something is left out."""
    taken: list[Transmission] = []
    errors: list[str] = []
    for element in robot.findall("transmission"):
        try:
            taken.append(_transmission(element, errors))
        except _LeftOut as error:
            errors.append(str(error))
    return Transmissions(tuple(taken), tuple(errors))


def _transmission(element: Node, errors: list[str]) -> Transmission:
    name = _name(element, "transmission", errors)
    if not name:
        raise _LeftOut(errors.pop())
    kind = element.find("type")
    if kind is None:
        raise _LeftOut(f"No type element found in transmission '{name}'.")
    if not _text(kind):
        raise _LeftOut(f"Skipping empty type element in transmission '{name}'.")
    joints = _joints(element, errors)
    if not joints:
        raise _LeftOut(f"Failed to load joints for transmission '{name}'.")
    if not _actuators(element, errors):
        raise _LeftOut(f"Failed to load actuators for transmission '{name}'.")
    return Transmission(name, tuple(joints))


def _joints(element: Node, errors: list[str]) -> list[tuple[str, tuple[str, ...]]]:
    """Name and interfaces of each joint; none where one has no name."""
    joints = []
    for joint in element.findall("joint"):
        name = _name(joint, "joint", errors)
        if name is None:
            return []
        if not name:
            continue
        interfaces = tuple(filter(None, map(_text, joint.findall("hardwareInterface"))))
        if interfaces:
            joints.append((name, interfaces))
        else:
            errors.append(f"No valid hardware interface element found in joint '{name}'.")
    return joints


def _actuators(element: Node, errors: list[str]) -> list[str]:
    """Names; none where one has no name."""
    names = [_name(actuator, "actuator", errors) for actuator in element.findall("actuator")]
    return [] if None in names else [name for name in names if name]


def _name(element: Node, kind: str, errors: list[str]) -> str | None:
    """The name of a transmission, joint or actuator; "" or None, with an error, for none."""
    name = element.get("name")
    if name is None:
        errors.append(f"No name attribute specified for {kind}.")
    elif not name:
        errors.append(f"Empty name attribute specified for {kind}.")
    return name


def _text(element: Node) -> str:
    """Text of an element as TinyXML's GetText(): without white space around it, "" where an
    element stands before it."""
    return " ".join((element.text or "").split())
