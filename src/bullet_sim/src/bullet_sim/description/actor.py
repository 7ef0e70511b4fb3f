"""How an actor moves, and the person of simple shapes that takes the place of its skin."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bullet_sim.description.model import (
    RGBA,
    Geometry,
    Joint,
    Link,
    ModelDescription,
    Shape,
)
from bullet_sim.pose import Pose, Vec3

STANDING = ("stand", "sit", "talk", "idle")  # in the name of an animation whose limbs rest


@dataclass(frozen=True)
class Trajectory:
    """A part of an actor's script.

    Attributes:
        animation: its name.
        duration: [s].
        times, poses: of the waypoints, the first at 0; none: it stays where it is.
        tension: 0: a spline after Catmull and Rom; 1: it stops at each waypoint.
    """

    animation: str
    duration: float
    times: tuple[float, ...] = ()
    poses: tuple[Pose, ...] = ()
    tension: float = 0.0


@dataclass(frozen=True)
class ActorMotion:
    """The script of an actor.

    Attributes:
        trajectories: one after the other.
        loop: it begins again at the end, else it stays there.
        delay: until it begins [s].
        starts: it begins by itself.
        by_distance: animations whose limbs move with the distance (interpolate_x), not the time.
        pose: where it stands before it begins.
        scale: of the person.
    """

    trajectories: tuple[Trajectory, ...] = ()
    loop: bool = True
    delay: float = 0.0
    starts: bool = True
    by_distance: frozenset[str] = frozenset()
    pose: Pose = Pose()
    scale: float = 1.0


SKIN: RGBA = (0.85, 0.66, 0.54, 1.0)
SHIRT: RGBA = (0.16, 0.35, 0.62, 1.0)
TROUSERS: RGBA = (0.18, 0.18, 0.22, 1.0)
SHOES: RGBA = (0.08, 0.08, 0.08, 1.0)
HAIR: RGBA = (0.2, 0.13, 0.08, 1.0)
HIP, SHOULDER = 0.92, 1.42  # heights [m]
THIGH, ARM = 0.44, 0.30  # lengths [m]
LIMBS = {  # link -> the link above it, the joint's place in its frame [m]
    "LeftUpLeg": ("", (0.0, 0.09, HIP)),
    "LeftLeg": ("LeftUpLeg", (0.0, 0.0, -THIGH)),
    "RightUpLeg": ("", (0.0, -0.09, HIP)),
    "RightLeg": ("RightUpLeg", (0.0, 0.0, -THIGH)),
    "LeftArm": ("", (0.0, 0.23, SHOULDER)),
    "LeftForeArm": ("LeftArm", (0.0, 0.0, -ARM)),
    "RightArm": ("", (0.0, -0.23, SHOULDER)),
    "RightForeArm": ("RightArm", (0.0, 0.0, -ARM)),
}
_PARTS: dict[str, tuple[tuple[str, tuple[float, ...], Vec3, RGBA], ...]] = {
    "": (
        ("box", (0.20, 0.32, 0.16), (0.0, 0.0, 0.97), TROUSERS),
        ("box", (0.22, 0.38, 0.46), (0.0, 0.0, 1.25), SHIRT),
        ("cylinder", (0.055, 0.12), (0.0, 0.0, 1.52), SKIN),
        ("sphere", (0.11,), (0.01, 0.0, 1.64), SKIN),
        ("sphere", (0.105,), (-0.015, 0.0, 1.665), HAIR),
    ),
    "UpLeg": (("cylinder", (0.08, THIGH), (0.0, 0.0, -THIGH / 2), TROUSERS),),
    "Leg": (
        ("cylinder", (0.06, 0.42), (0.0, 0.0, -0.21), TROUSERS),
        ("box", (0.26, 0.09, 0.07), (0.06, 0.0, -0.445), SHOES),
    ),
    "Arm": (("cylinder", (0.05, ARM), (0.0, 0.0, -ARM / 2), SHIRT),),
    "ForeArm": (
        ("cylinder", (0.04, 0.26), (0.0, 0.0, -0.13), SKIN),
        ("sphere", (0.05,), (0.0, 0.0, -0.28), SKIN),
    ),
}


def person(name: str, motion: ActorMotion) -> ModelDescription:
    """A person that stands on the origin and looks along x; its limbs turn about y."""
    root = f"{name}_pose"
    model = ModelDescription(name, root=root, auto_disable=False)
    model.motion = motion
    model.links[root] = _link(root, "", motion.scale)
    for limb, (above, place) in LIMBS.items():
        part = limb.replace("Left", "").replace("Right", "")
        model.links[limb] = _link(limb, part, motion.scale)
        x, y, z = (motion.scale * value for value in place)
        model.joints[limb] = Joint(
            f"{limb}_joint", "revolute", above or root, limb, Pose((x, y, z)), (0.0, 1.0, 0.0)
        )
    model.joints = {joint.name: joint for joint in model.joints.values()}
    return model


def _link(name: str, part: str, scale: float) -> Link:
    link = Link(name, 1.0, np.zeros(3), np.diag([1e-3] * 3))
    link.gravity = False
    for number, (kind, size, (x, y, z), color) in enumerate(_PARTS[part]):
        geometry = Geometry(kind, tuple(scale * value for value in size))
        place = Pose((scale * x, scale * y, scale * z))
        shape = Shape(geometry, place, color, name=f"{name}_{number}", link=name, painted=True)
        link.visuals.append(shape)
    return link
