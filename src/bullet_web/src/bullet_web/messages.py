"""What browsers may send, checked field by field. No ROS.

A message is a JSON object of at most MAX_BYTES with a "type" and the fields of its row in FIELDS;
anything else is refused with a reason that names the field and its value.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any, Callable

MAX_BYTES = 4096
MAX_PLACE = 1e4  # [m]
MAX_STEPS = 100000
MAX_PACE = 100.0
KINDS = ("box", "cone", "car")
Check = Callable[[Any], bool]


class BadMessage(ValueError):
    """A message of a browser that is refused."""


def _number(low: float, high: float) -> tuple[Check, str]:
    def check(value: Any) -> bool:
        valid = isinstance(value, (int, float)) and not isinstance(value, bool)
        return valid and low <= value <= high  # not of NaN

    return check, f"a number from {low:g} to {high:g}"


def _whole(low: int, high: int) -> tuple[Check, str]:
    def check(value: Any) -> bool:
        return isinstance(value, int) and not isinstance(value, bool) and low <= value <= high

    return check, f"a whole number from {low} to {high}"


def _text(limit: int) -> tuple[Check, str]:
    return lambda value: isinstance(value, str) and len(value) <= limit, f"a text of up to {limit}"


def _flag() -> tuple[Check, str]:
    return lambda value: isinstance(value, bool), "true or false"


def _one_of(*values: str) -> tuple[Check, str]:
    return lambda value: value in values, "one of " + ", ".join(values)


PLACE = {name: _number(-MAX_PLACE, MAX_PLACE) for name in ("x", "y", "z")}
NAME = _text(200)
ACTIONS: dict[str, dict[str, tuple[Check, str]]] = {
    "pause": {},
    "resume": {},
    "reset": {},
    "cancel": {},
    "step": {"count": _whole(1, MAX_STEPS)},
    "pace": {"factor": _number(0.0, MAX_PACE)},
    "place": {"model": NAME, **PLACE},
    "spawn": {"kind": _one_of(*KINDS), **PLACE},
    "goal": PLACE,
    "remove": {"model": NAME},
}
FIELDS: dict[str, dict[str, tuple[Check, str]]] = {
    "ack": {},
    "take": {},
    "release": {},
    "drive": {"speed": _number(-1.0, 1.0), "steering": _number(-1.0, 1.0)},
    "topic": {"topic": NAME},
    "want": {"camera": NAME, "lidar": NAME, "data": _flag(), "contacts": _flag()},
    "do": {"action": _one_of(*ACTIONS)},
}
# Fields that may be there: [rad] of place, spawn and goal; the model that gets the goal.
OPTIONAL = {"yaw": _number(-10.0, 10.0), "model": NAME}
LAYERS = {"layers": _text(2000)}  # of want: topics of navigation, with blanks between them


def parse(text: str | bytes) -> dict[str, Any]:
    """The message of a text.

    Returns:
        Its fields that are known.

    Raises:
        BadMessage: it is none that a page sends.
    """
    if not isinstance(text, str):
        raise BadMessage("the message is binary, must be JSON text")
    try:
        message = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise BadMessage(f"the message is no JSON: {error}") from error
    if not isinstance(message, dict):
        raise BadMessage(f"the message is {_shown(message)}, must be an object")
    kind = message.get("type")
    if not isinstance(kind, str) or kind not in FIELDS:
        raise BadMessage(f"type is {_shown(kind)}, must be one of {', '.join(FIELDS)}")
    fields = dict(FIELDS[kind])
    checked = {"type": kind, **_checked(message, fields)}
    if kind == "want" and "layers" in message:
        checked.update(_checked(message, LAYERS))
    if kind == "do":
        fields = ACTIONS[checked["action"]]
        checked.update(_checked(message, fields))
        if "x" in fields:
            more = {name: row for name, row in OPTIONAL.items() if name in message}
            checked.update(_checked(message, more))
    return checked


def _checked(message: Mapping[str, Any], fields: Mapping[str, tuple[Check, str]]) -> dict[str, Any]:
    for name, (check, valid) in fields.items():
        value = message.get(name)
        if not isinstance(value, (str, int, float)) or not check(value):
            raise BadMessage(f"{name} is {_shown(value)}, must be {valid}")
    return {name: message[name] for name in fields}


def _shown(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
