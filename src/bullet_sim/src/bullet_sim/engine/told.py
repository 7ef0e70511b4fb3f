"""What an OdeEngine is told of bodies, and their copies in PyBullet, once something asks for it."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import dataclass, field

import pybullet as p

from bullet_sim.description.lump import without_chains
from bullet_sim.errors import ModelError
from bullet_sim.pose import Motion, Pose, Vec3, compose, velocity_at

_MOVABLE = ("revolute", "continuous", "prismatic")  # types of joints
_STILL = (0.0, 0.0, 0.0)
_NOWHERE = (math.nan, math.nan, math.nan)


@dataclass
class Told:
    """A body, and where it was put last.

    Attributes:
        path, fixed_base, self_collide, static: of Engine.load().
        links: names, the root link first, then those below it, each before its children: the
            second one has PyBullet's index 0.
        movable: PyBullet's indices of the joints that move, each that of the link below it.
        joints: their names.
        chain: name -> PyBullet's index of the joints by which loose links and screws move besides,
            see chain_of().
        center: center of mass of the root link in its frame [m].
        pose: of the root link's frame in the world.
        linear, angular: velocity of its center of mass [m/s, rad/s], world axes.
        states: position [rad, m] and velocity of each joint that moves.
    """

    path: str
    fixed_base: bool
    self_collide: bool
    static: bool
    links: list[str]
    movable: list[int]
    joints: list[str]
    chain: dict[str, int]
    center: Vec3
    pose: Pose = Pose()
    linear: Vec3 = _STILL
    angular: Vec3 = _STILL
    states: list[tuple[float, float]] = field(default_factory=list)

    def motion(self) -> Motion:
        """As Engine.link_motion of the root link."""
        position, orientation = self.pose.position, self.pose.orientation
        linear = velocity_at(position, self.middle(), self.linear, self.angular)
        return position, orientation, linear, self.angular

    def middle(self) -> Vec3:
        """The root link's center of mass in the world [m]."""
        return compose(
            self.pose.position, self.pose.orientation, self.center, (0.0, 0.0, 0.0, 1.0)
        )[0]

    def is_finite(self) -> bool:
        """Whether it is known where it is."""
        return math.isfinite(sum(self.linear))

    def lose(self) -> None:
        """Its state is not finite any more: its velocity tells it, and it stays where it was."""
        self.linear = self.angular = _NOWHERE


def read_file(path: str, fixed_base: bool, self_collide: bool, static: bool) -> Told:
    """A body of a prepared URDF file, see Engine.load.

    Raises:
        ModelError: the file cannot be read.
    """
    try:
        robot = ET.parse(path).getroot()
    except (OSError, ET.ParseError) as error:
        raise ModelError(f"{path} cannot be loaded: {error}") from error
    elements = {link.get("name", ""): link for link in robot.iter("link")}
    below: dict[str, list[tuple[str, ET.Element]]] = {name: [] for name in elements}
    children = set()
    for joint in robot.iter("joint"):
        parent, child = (_attribute(joint, tag, "link") for tag in ("parent", "child"))
        if child not in elements or parent not in elements:
            raise ModelError(
                f"{path} cannot be loaded: joint '{joint.get('name')}' has the links {parent!r} "
                f"and {child!r}; links are {', '.join(elements) or '(none)'}"
            )
        below[parent].append((child, joint))
        children.add(child)
    roots = [name for name in elements if name not in children]
    if len(roots) != 1:
        raise ModelError(
            f"{path} cannot be loaded: there are {len(roots)} links without a joint above them "
            f"({', '.join(roots) or 'none'}), must be one"
        )
    links, joints = list(roots), []
    waiting = below[roots[0]][::-1]
    while waiting:
        name, joint = waiting.pop()
        links.append(name)
        joints.append(joint)
        waiting += below[name][::-1]
    moving = [index for index, joint in enumerate(joints) if joint.get("type") in _MOVABLE]
    movable, chain = without_chains({index: joints[index].get("name", "") for index in moving})
    center = _STILL
    if not static:
        text = _attribute(elements[roots[0]], "inertial/origin", "xyz") or "0 0 0"
        x, y, z = map(float, text.split())
        center = x, y, z
    return Told(
        path,
        fixed_base,
        self_collide,
        static,
        links,
        movable,
        [joints[index].get("name", "") for index in movable],
        chain,
        center,
        states=[(0.0, 0.0)] * len(movable),
    )


def _attribute(element: ET.Element, path: str, name: str) -> str:
    found = element.find(path)
    return "" if found is None else found.get(name, "")


def place(client: int, body: int, told: Told, inertial: Pose, chain: Sequence[float]) -> None:
    """Put PyBullet's copy of a body where it is.

    Args:
        inertial: of PyBullet's root link, in its frame.
        chain: positions of the joints of told.chain; empty: they stay.
    """
    pose = told.pose * inertial
    p.resetBasePositionAndOrientation(body, pose.position, pose.orientation, physicsClientId=client)
    if not told.static:
        p.resetBaseVelocity(body, told.linear, told.angular, physicsClientId=client)
    if told.movable:
        p.resetJointStatesMultiDof(
            body,
            told.movable,
            [[position] for position, _ in told.states],
            [[velocity] for _, velocity in told.states],
            physicsClientId=client,
        )
    if chain:
        p.resetJointStatesMultiDof(
            body,
            list(told.chain.values()),
            [[position] for position in chain],
            [[0.0]] * len(chain),
            physicsClientId=client,
        )
