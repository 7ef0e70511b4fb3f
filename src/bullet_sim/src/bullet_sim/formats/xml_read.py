"""Reading numbers and poses from XML with errors that name the element."""

import math
import xml.etree.ElementTree as ET

from bullet_sim.errors import ModelError
from bullet_sim.pose import Pose


def parse(text, what):
    """Root element of an XML text (str or bytes, with or without an encoding declaration).

    Raises:
        ModelError: not well-formed; names `what`, line and column.
    """
    data = text.encode("utf-8") if isinstance(text, str) else bytes(text)
    stripped = data.lstrip()
    if stripped.startswith(b"<?xml") and isinstance(text, str):
        stripped = stripped[stripped.index(b"?>") + 2 :] if b"?>" in stripped else stripped
    try:
        return ET.fromstring(stripped)
    except ET.ParseError as error:
        raise ModelError(f"{what} is not well-formed XML: {error}") from error


def floats(text, count, what):
    """`count` finite numbers from a text such as '0 0 1.5' (count None: any number).

    Raises:
        ModelError: names `what` and the text.
    """
    try:
        values = tuple(float(word) for word in (text or "").split())
    except ValueError:
        values = None
    if (
        values is None
        or (count is not None and len(values) != count)
        or not all(math.isfinite(v) for v in values)
    ):
        wanted = "finite numbers" if count is None else f"{count} finite number(s)"
        if "$" in (text or ""):
            wanted += "; it looks like xacro: process the file with xacro first"
        raise ModelError(f"{what} is '{(text or '').strip()}', must be {wanted}")
    return values


def number(text, what):
    """One finite number."""
    return floats(text, 1, what)[0]


def bound(text, what):
    """A limit: a finite number, or None for one that is missing or infinite (1e16 or more)."""
    try:
        value = float(text or "inf")
    except ValueError:
        value = math.nan
    if math.isinf(value) or abs(value) >= 1e16:
        return None
    return number(text, what)


def child_text(element, path, default=None):
    """Stripped text of a sub-element, or the default where it is missing or empty."""
    found = element.find(path)
    text = found.text.strip() if found is not None and found.text else ""
    return text or default


def child_number(element, path, what, default):
    """Number in a sub-element, or the default where it is missing."""
    text = child_text(element, path)
    return default if text is None else number(text, f"{what} <{path}>")


def is_true(text):
    """Whether a text means true (true, 1, yes)."""
    return str(text).strip().lower() in ("true", "1", "yes", "on")


def urdf_origin(element, what):
    """Pose of an <origin xyz rpy> child; identity where there is none."""
    origin = element.find("origin")
    if origin is None:
        return Pose()
    return Pose.from_xyz_rpy(
        floats(origin.get("xyz", "0 0 0"), 3, f"{what} origin xyz"),
        floats(origin.get("rpy", "0 0 0"), 3, f"{what} origin rpy"),
    )


def sdf_pose(element, what):
    """Pose of a <pose> child (x y z roll pitch yaw); identity where there is none."""
    text = child_text(element, "pose")
    if text is None:
        return Pose()
    values = floats(text, 6, f"{what} <pose>")
    return Pose.from_xyz_rpy(values[:3], values[3:])


def whole(value, what):
    """A number as int.

    Raises:
        ModelError: it has a fraction.
    """
    if value != int(value):
        raise ModelError(f"{what} is {value}, must be a whole number")
    return int(value)
