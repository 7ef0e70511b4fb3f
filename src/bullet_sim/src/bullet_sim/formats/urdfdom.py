"""What urdfdom 1.0 cannot read of a link; it gives up what of the link comes after it.

Sources: parseLink and what it calls in link.cpp, Vector3::init, strToDouble.
"""

from __future__ import annotations

import math
import re

from bullet_sim.description.model import INERTIA
from bullet_sim.xml_reader import Node

SIZES = {  # shape: the attributes that it must have, and how many numbers are in each
    "box": (("size", 3),),
    "cylinder": (("radius", 1), ("length", 1)),
    "sphere": (("radius", 1),),
}
_NUMBER = re.compile(r"\s*[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?", re.IGNORECASE)


def mass_fault(inertial: Node) -> str:
    """What is wrong with the origin and the mass of an <inertial>, or ""."""
    return _origin_fault(inertial) or _numbers_fault(inertial.find("mass"), "mass", "value")


def inertia_fault(inertial: Node) -> str:
    """What is wrong with the inertia of an <inertial>, or ""."""
    inertia = inertial.find("inertia")
    faults = (_numbers_fault(inertia, "inertia", key) for key in INERTIA)
    return next(filter(None, faults), "")


def shape_fault(part: Node) -> str:
    """What is wrong with a <visual> or <collision>, or ""."""
    fault = _origin_fault(part)
    if fault:
        return fault
    geometry, material = part.find("geometry"), part.find("material")
    if geometry is None or not len(geometry):
        return "has no geometry"
    shape = geometry[0]
    if shape.tag == "mesh":
        if shape.get("filename") is None:
            return "has a <mesh> without filename"
        fault = "" if shape.get("scale") is None else _numbers_fault(shape, "mesh", "scale", 3)
    elif shape.tag in SIZES:
        faults = (_numbers_fault(shape, shape.tag, *needed) for needed in SIZES[shape.tag])
        fault = next(filter(None, faults), "")
    else:
        fault = f"has geometry <{shape.tag}>, which is not one of box, cylinder, sphere, mesh"
    if not fault and part.tag == "visual" and material is not None and material.get("name") is None:
        return "has a <material> without a name"
    return fault


def _origin_fault(element: Node) -> str:
    """What is wrong with the <origin> of an element, or ""."""
    origin = element.find("origin")
    given = [] if origin is None else [key for key in ("xyz", "rpy") if origin.get(key) is not None]
    return next(filter(None, (_numbers_fault(origin, "origin", key, 3) for key in given)), "")


def _numbers_fault(element: Node | None, tag: str, key: str, count: int = 1) -> str:
    """What is wrong with an attribute of an element that needs numbers, or ""."""
    if element is None:
        return f"has no <{tag}>"
    text = element.get(key)
    if text is None:
        return f"has {tag} without {key}"
    parts = [part for part in text.split(" ") if part] if count > 1 else [text]
    if len(parts) == count and all(map(_is_number, parts)):
        return ""
    hint = "; it looks like xacro: process the file with xacro first" if "$" in text else ""
    return f"{tag} {key} is '{text}', must be {count} finite number(s){hint}"


def _is_number(text: str) -> bool:
    return bool(_NUMBER.fullmatch(text)) and math.isfinite(float(text))
