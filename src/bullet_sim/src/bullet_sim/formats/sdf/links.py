"""Mass and surface of SDF's <link> elements."""

import numpy as np

from bullet_sim.description.parts import Surface
from bullet_sim.formats.tags.surface import SDF, read_surface
from bullet_sim.formats.xml_read import child_number, child_text, is_true, sdf_pose


def read_inertial(element, link, what):
    """Set mass, centre and inertia of a Link from a <link>'s <inertial>."""
    link.mass, link.inertia = 1.0, np.eye(3)
    inertial = element.find("inertial")
    if inertial is None:
        return
    link.mass = child_number(inertial, "mass", what, 1.0)
    if link.mass < 0:
        inertial.warn(
            f"{what} mass is {link.mass}, must be 0 or more; 1 is used",
            "masses are below 0; 1 is used",
            what,
        )
        link.mass = 1.0
    pose = sdf_pose(inertial, f"{what} inertial")
    entry = {}
    for key, default in (
        ("ixx", 1.0),
        ("ixy", 0.0),
        ("ixz", 0.0),
        ("iyy", 1.0),
        ("iyz", 0.0),
        ("izz", 1.0),
    ):  # one that is there and no number makes 0, for which lump.py finds an inertia
        given = inertial.find(f"inertia/{key}") is not None
        entry[key] = child_number(inertial, f"inertia/{key}", what, 0.0 if given else default)
    local = np.array(
        [
            [entry["ixx"], entry["ixy"], entry["ixz"]],
            [entry["ixy"], entry["iyy"], entry["iyz"]],
            [entry["ixz"], entry["iyz"], entry["izz"]],
        ]
    )
    link.inertia = pose.matrix @ local @ pose.matrix.T
    link.centre = np.array(pose.position)


def read_surfaces(element, link, what, model):
    """Set the surface of a Link from the <collision>s of a <link>, and how it collides."""
    for number, part in enumerate(element.findall("collision")):
        read = Surface()
        name = part.get("name") or f"collision {number}"
        read_surface(part, SDF, read, f"{what} collision '{name}'", model.warn)
        _combine(link.surface, read, first=number == 0)
    link.self_collide = is_true(child_text(element, "self_collide", "false"))
    if not is_true(child_text(element, "gravity", "true")):
        link.gravity = False


def _combine(into, read, first):
    """A link has one surface here: the lowest friction of its collisions, the bits of all."""
    lowest = 1.0 if read.friction is None else read.friction
    if first or lowest < into.friction:
        into.friction, into.friction2 = lowest, read.friction2
        into.direction = read.direction
    into.bitmask = read.bitmask if first else into.bitmask | read.bitmask
    into.max_speed = into.max_speed if read.max_speed is None else read.max_speed
    into.min_depth = max(into.min_depth, read.min_depth)
