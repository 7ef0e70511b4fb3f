"""Numbers, flags and poses of elements; a bad value is a warning, and a default takes its place.

What is used is what Gazebo's reader makes of a text: of a single number the beginning ('1.5m' is
1.5, '1,5' is 1), of a vector all its numbers or none.
"""

import math
import re

import numpy as np

from bullet_sim.errors import ModelError
from bullet_sim.pose import Pose

NO_LIMIT = 1e16  # of joints: so much or more means none
_NUMBER = re.compile(
    r"\s*([-+]?(?:inf(?:inity)?|nan|(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?))", re.IGNORECASE
)
_XACRO = "; it looks like xacro: process the file with xacro first"


def floats(text, count, what):
    """`count` finite numbers from a text such as '0 0 1.5' (count None: any number).

    Raises:
        ModelError: names `what` and the text.
    """
    values, rest = leading_numbers(text)
    if rest or not _is_usable(values, count):
        raise ModelError(_sentence(text, what, count))
    return values


def number(text, what):
    """One finite number; raises as `floats` does."""
    return floats(text, 1, what)[0]


def leading_numbers(text, most=None):
    """(the numbers that a text begins with, at most so many; what follows them)."""
    values, place = [], 0
    text = text or ""
    while most is None or len(values) < most:
        found = _NUMBER.match(text, place)
        if found is None:
            break
        values.append(float(found.group(1)))
        place = found.end()
    return tuple(values), text[place:].strip()


def _is_usable(values, count):
    return (count is None or len(values) == count) and all(map(math.isfinite, values))


def _sentence(text, what, count):
    text = (text or "").strip()
    wanted = "finite numbers" if count is None else f"{count} finite number(s)"
    return f"{what} is '{text}', must be {wanted}{_XACRO if '$' in text else ''}"


def mended_floats(node, text, count, what, default):
    """`count` finite numbers, or with a warning the first of more, or the default.

    Args:
        node: the Node that takes the warning.
        text: as in the file.
        count: how many.
        what: for the message.
        default: what is used where there are too few; any value.
    """
    values, rest = leading_numbers(text, count)
    if not _is_usable(values, count):
        replace(node, what, text, _sentence(text, what, count), default)
        return default
    if rest:
        replace(node, what, text, _sentence(text, what, count), values)
    return values


def replace(node, what, text, sentence, used):
    """Say that a value is not usable and what is used instead.

    Args:
        node: the Node that takes the warning.
        what: the value's name.
        text: the value as it is written.
        sentence: what is wrong and what would be valid.
        used: number, tuple, text or None for nothing (and a tuple of it).

    Raises:
        ModelError: the element belongs to no document that could note it.
    """
    if getattr(node, "document", None) is None:
        raise ModelError(sentence)
    used = None if used == (None,) else used
    if isinstance(used, (tuple, float, int)) and not isinstance(used, bool):
        used = " ".join(f"{value:g}" for value in np.atleast_1d(used))
    node.warn(
        f"{sentence}; {'nothing' if used is None else used} is used",
        "values are not usable as they are written and are replaced",
        f"{what} '{(text or '').strip()}'",
    )


def child_text(element, path, default=None):
    """Stripped text of a sub-element, or the default where it is missing or empty."""
    found = element.find(path)
    text = found.text.strip() if found is not None and found.text else ""
    return text or default


def child_number(element, path, what, default):
    """Number in a sub-element, or the default where it is missing or, with a warning, none."""
    text = child_text(element, path)
    if text is None:
        return default
    values = mended_floats(element.find(path), text, 1, f"{what} <{path}>", default)
    return values[0] if isinstance(values, tuple) else values


def child_floats(element, path, count, what, default):
    """As child_number: a tuple of `count` numbers."""
    text = child_text(element, path)
    if text is None:
        return default
    return mended_floats(element.find(path), text, count, f"{what} <{path}>", default)


def child_whole(element, path, what, default, least=1):
    """As child_number: an int of at least `least`; a fraction is cut off."""
    value = child_number(element, path, what, default)
    if value >= least:
        return int(value)
    sentence = f"{what} <{path}> is {value:g}, must be at least {least}"
    replace(element.find(path), f"{what} <{path}>", f"{value:g}", sentence, default)
    return default


def child_bound(element, path, what):
    """Limit in a sub-element: a number, or None for one that is missing or infinite."""
    return _bound(element.find(path), child_text(element, path), f"{what} <{path}>")


def child_flag(element, path, what, default):
    """Truth in a sub-element, or the default where it is missing or, with a warning, no word."""
    text = child_text(element, path)
    if text is None:
        return default
    if is_true(text) or text.lower() in ("false", "0", "no", "off"):
        return is_true(text)
    sentence = f"{what} <{path}> is '{text}', must be true or false"
    replace(element.find(path), f"{what} <{path}>", text, sentence, str(default).lower())
    return default


def number_of(element, name, what, default):
    """Number in an attribute, or the default where it is missing or, with a warning, none."""
    text = element.get(name)
    if text is None:
        return default
    values = mended_floats(element, text, 1, f"{what} {name}", default)
    return values[0] if isinstance(values, tuple) else values


def floats_of(element, name, count, what, default):
    """As number_of: a tuple of `count` numbers."""
    text = element.get(name)
    if text is None:
        return default
    return mended_floats(element, text, count, f"{what} {name}", default)


def bound_of(element, name, what, default=None):
    """Limit in an attribute: a number, the default where it is missing, None if infinite."""
    text = element.get(name)
    return default if text is None else _bound(element, text, f"{what} {name}")


def _bound(node, text, what):
    values, rest = leading_numbers(text, 1)
    if text is None or (values and not rest and abs(values[0]) >= NO_LIMIT):
        return None
    values = mended_floats(node, text, 1, what, None)
    return None if values is None or abs(values[0]) >= NO_LIMIT else values[0]


def is_true(text):
    """Whether a text means true (true, 1, yes)."""
    return str(text).strip().lower() in ("true", "1", "yes", "on")


def urdf_origin(element, what):
    """Pose of an <origin xyz rpy> child; identity where there is none."""
    origin = element.find("origin")
    if origin is None:
        return Pose()
    zero = (0.0, 0.0, 0.0)
    return Pose.from_xyz_rpy(
        floats_of(origin, "xyz", 3, f"{what} origin", zero),
        floats_of(origin, "rpy", 3, f"{what} origin", zero),
    )


def sdf_pose(element, what):
    """Pose of a <pose> child (x y z roll pitch yaw); identity where there is none.

    As Gazebo does, of fewer than six numbers only the first three count, as a position.
    """
    text = child_text(element, "pose")
    if text is None:
        return Pose()
    values, rest = leading_numbers(text, 6)
    what = f"{what} <pose>"
    if not _is_usable(values, 6) or rest:
        if not _is_usable(values, 6):
            values = (values[:3] if _is_usable(values[:3], 3) else (0.0,) * 3) + (0.0,) * 3
        replace(element.find("pose"), what, text, _sentence(text, what, 6), values)
    return Pose.from_xyz_rpy(values[:3], values[3:])
