"""SDF of former versions as that of 1.7; names that a version no longer has have no effect in it.

Source: sdf/1.*/1_*.convert of sdformat 9. What joints and axes had is read by their version.
"""

from __future__ import annotations

from typing import Tuple

from bullet_sim.formats.sdf.physics import convert_physics
from bullet_sim.xml_reader import Node, add_child, copied

Version = Tuple[int, int]  # (major, minor) of an SDF document
_NOISES = {"rate": "angular_velocity", "accel": "linear_acceleration"}


def upgrade(sdf: Node, version: Version) -> None:
    """Rewrite a document as SDF 1.7, in place."""
    world = sdf.find("world")
    if world is not None and version < (1, 4):
        convert_physics(world)
    if version < (1, 6):
        if world is not None:
            _lift_gravity(world)
        for imu in list(sdf.iter("imu")):
            _spread_noise(imu)
    if version < (1, 7):
        for pose in sdf.iter("pose"):
            frame = pose.attrib.pop("frame", "")
            if frame:
                pose.attrib.setdefault("relative_to", frame)


def _lift_gravity(world: Node) -> None:
    """Move the <gravity> of <physics> into the <world>."""
    gravity = world.find("physics/gravity")
    if gravity is not None and world.find("gravity") is None:
        world.append(copied(gravity))


def _spread_noise(imu: Node) -> None:
    """Give each axis the <noise> that was that of all."""
    noise = imu.find("noise")
    if noise is None:
        return
    imu.remove(noise)
    for old, new in _NOISES.items():
        of_all = noise.find(old)
        if of_all is None or imu.find(new) is not None:
            continue
        vector = add_child(imu, new, "")
        for axis in "xyz":
            own = add_child(add_child(vector, axis, ""), "noise", "")
            own.set("type", (noise.findtext("type") or "gaussian").strip())
            own.extend(copied(child) for child in of_all)
