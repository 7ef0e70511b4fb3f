"""URDF texts that PyBullet loads safely: of models, and of what mirrors render."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from bullet_sim.description.lump import MIN_MASS, LumpedModel
from bullet_sim.description.mirrors import links_between, mirrored_joints
from bullet_sim.description.model import Geometry, Joint, Link, Shape, VisualLink
from bullet_sim.pose import Array, Pose, Quat

DEFAULT_COLOR = (0.7, 0.7, 0.7, 1.0)


def _text(values: Iterable[float]) -> str:
    return " ".join(repr(float(v)) for v in values)


def _origin(parent: ET.Element, pose: Pose) -> None:
    ET.SubElement(parent, "origin", xyz=_text(pose.position), rpy=_text(pose.rpy))


def _geometry(parent: ET.Element, geometry: Geometry) -> None:
    element = ET.SubElement(parent, "geometry")
    if geometry.kind == "box":
        ET.SubElement(element, "box", size=_text(geometry.size))
    elif geometry.kind == "cylinder":
        ET.SubElement(
            element, "cylinder", radius=_text(geometry.size[:1]), length=_text(geometry.size[1:])
        )
    elif geometry.kind == "sphere":
        ET.SubElement(element, "sphere", radius=_text(geometry.size))
    elif geometry.kind == "plane":
        ET.SubElement(element, "plane", normal="0 0 1")
    else:
        ET.SubElement(element, "mesh", filename=geometry.path, scale=_text(geometry.scale))


def lumped_urdf(lumped: LumpedModel, static: bool) -> str:
    """Text for PyBullet of what collides and moves: every link that moves with mass and inertia.

    Args:
        static: True: no masses, meshes collide as they are; False: meshes collide as hulls.
    """
    joints = (*lumped.joints, *lumped.welds, *lumped.loose)
    between = [
        Link(name, MIN_MASS, inertia=MIN_MASS * np.eye(3))
        for joint in joints
        for name in links_between(joint)
    ]
    return urdf_text([*lumped.links.values(), *between], mirrored_joints(lumped), static)


def visual_urdf(links: Sequence[VisualLink], shapes: Sequence[Iterable[Shape]]) -> str:
    """Text for PyBullet of what a mirror renders; links and joints have their rows' names.

    Args:
        shapes: of each link, as PyBullet reads them.
    """
    described, joints = [], []
    for row, (link, own) in enumerate(zip(links, shapes)):
        described.append(Link(f"{row}", MIN_MASS, inertia=MIN_MASS * np.eye(3), visuals=list(own)))
        if link.parent >= 0:
            names = f"{row}", link.kind, f"{link.parent}", f"{row}"
            joints.append(Joint(*names, link.origin, link.axis))
    return urdf_text(described, joints, static=False)


def urdf_text(links: Iterable[Link], joints: Iterable[Joint], static: bool) -> str:
    """Text of links and joints; see lumped_urdf()."""
    robot = ET.Element("robot", name="model")
    for link in links:
        element = ET.SubElement(robot, "link", name=link.name)
        _inertial(element, link, static)
        for index, shape in enumerate(link.visuals):
            visual = ET.SubElement(element, "visual")
            _origin(visual, shape.pose)
            _geometry(visual, shape.geometry)
            if shape.color is not None or shape.geometry.kind != "mesh":
                material = ET.SubElement(visual, "material", name=f"{link.name}_{index}")
                ET.SubElement(material, "color", rgba=_text(shape.color or DEFAULT_COLOR))
        for shape in link.collisions:
            collision = ET.SubElement(element, "collision")
            if static and shape.geometry.kind == "mesh":
                collision.set("concave", "yes")
            _origin(collision, shape.pose)
            _geometry(collision, shape.geometry)
    for joint in joints:
        _joint(robot, joint)
    _indent(robot)  # PyBullet reads lines into a small buffer: a long line gets damaged
    return ET.tostring(robot, encoding="unicode")


def _indent(element: ET.Element, end: str = "\n") -> None:
    """Write each element into a line of its own, as ElementTree.indent does from Python 3.9 on."""
    if len(element):
        element.text = inner = end + "  "
        for child in element:
            _indent(child, inner)
            child.tail = inner
        child.tail = end


def _inertial(element: ET.Element, link: Link, static: bool) -> None:
    inertial = ET.SubElement(element, "inertial")
    mass, inertia = (0.0, np.zeros((3, 3))) if static else (link.mass, link.inertia)
    if static:
        _origin(inertial, Pose())
    else:
        moments, axes = principal_inertia(inertia)
        inertia = np.diag(moments)
        x, y, z = link.center.tolist()
        _origin(inertial, Pose((x, y, z), axes))
    ET.SubElement(inertial, "mass", value=repr(float(mass)))
    ET.SubElement(
        inertial,
        "inertia",
        ixx=repr(float(inertia[0, 0])),
        ixy="0",
        ixz="0",
        iyy=repr(float(inertia[1, 1])),
        iyz="0",
        izz=repr(float(inertia[2, 2])),
    )


def principal_inertia(inertia: Array) -> tuple[Array, Quat]:
    """Principal moments (3,) of an inertia (3, 3) and the quaternion of their axes.

    PyBullet reads only the diagonal, so off-diagonal terms go into the inertial frame. It loads 0
    where one moment is greater than the two others together, which no rigid body has (Gazebo takes
    it as it is): the two others become greater then.
    """
    if np.abs(inertia - np.diag(np.diag(inertia))).max() <= 1e-9 * np.abs(inertia).max():
        return _balanced(np.diag(inertia)), (0.0, 0.0, 0.0, 1.0)
    moments, axes = np.linalg.eigh(inertia)
    if np.linalg.det(axes) < 0:
        axes[:, 0] = -axes[:, 0]
    return _balanced(moments), quaternion_from_matrix(axes)


def _balanced(moments: Array) -> Array:
    """Moments (3,) of which the greatest is at most the sum of the others."""
    high, rest = moments.max(), moments.sum() - moments.max()
    if not 0.0 < rest < high:
        return moments
    return np.where(moments == high, high, moments * (high / rest * (1.0 + 1e-9)))


def quaternion_from_matrix(matrix: Any) -> Quat:
    """Unit quaternion (x, y, z, w) of a rotation matrix (3, 3), after Bar-Itzhack (2000).

    The eigenvector of the greatest eigenvalue of a symmetric 4x4 matrix; stable everywhere.
    """
    m = np.asarray(matrix)
    k = np.array(
        [
            [m[0, 0] - m[1, 1] - m[2, 2], m[0, 1] + m[1, 0], m[0, 2] + m[2, 0], m[2, 1] - m[1, 2]],
            [m[0, 1] + m[1, 0], m[1, 1] - m[0, 0] - m[2, 2], m[1, 2] + m[2, 1], m[0, 2] - m[2, 0]],
            [m[0, 2] + m[2, 0], m[1, 2] + m[2, 1], m[2, 2] - m[0, 0] - m[1, 1], m[1, 0] - m[0, 1]],
            [m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], m[0, 0] + m[1, 1] + m[2, 2]],
        ]
    )
    values, vectors = np.linalg.eigh(k / 3.0)
    x, y, z, w = vectors[:, np.argmax(values)].tolist()
    return x, y, z, w


def _joint(robot: ET.Element, joint: Joint) -> None:
    is_endless = joint.kind == "revolute" and joint.lower is None
    joint_type = "continuous" if is_endless else joint.kind
    element = ET.SubElement(robot, "joint", name=joint.name, type=joint_type)
    ET.SubElement(element, "parent", link=joint.parent)
    ET.SubElement(element, "child", link=joint.child)
    _origin(element, joint.origin)
    ET.SubElement(element, "axis", xyz=_text(joint.axis))
    lower, upper = (0.0, -1.0) if joint.lower is None else (joint.lower, joint.upper)
    ET.SubElement(
        element,
        "limit",
        lower=repr(lower),
        upper=repr(upper),
        effort=repr(joint.effort),
        velocity=repr(joint.velocity),
    )
    friction = repr(float(joint.friction))
    ET.SubElement(element, "dynamics", damping=repr(joint.damping), friction=friction)
