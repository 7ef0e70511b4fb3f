"""What browsers may send, checked field by field. No ROS.

A message is a JSON object of at most MAX_BYTES with a "type" and the fields of its row in FIELDS;
anything else is refused with a reason that names the field and its value.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from paddock_common.settings import Choice, Flag, Number, Rule

MAX_BYTES = 4096
MAX_PLACE = 1e4  # [m]
MAX_STEPS = 100000
MAX_PACE = 100.0
KINDS = ("box", "cone", "car")


def json_of(data: Any) -> str:
    """JSON that browsers can parse: null for numbers that are NaN or infinite."""
    try:
        return json.dumps(data, allow_nan=False)
    except ValueError:
        return json.dumps(_finite(data))


def _finite(data: Any) -> Any:
    if isinstance(data, float):
        return data if math.isfinite(data) else None
    if isinstance(data, Mapping):
        return {name: _finite(value) for name, value in data.items()}
    return [_finite(value) for value in data] if isinstance(data, (list, tuple)) else data


class BadMessage(ValueError):
    """A message of a browser that is refused."""


@dataclass(frozen=True)
class Word(Rule):
    """A text of at most `limit` characters."""

    limit: int

    def complaint(self, value: Any) -> str:
        is_word = isinstance(value, str) and len(value) <= self.limit
        return "" if is_word else f"a text of up to {self.limit}"


PLACE: dict[str, Rule] = {name: Number(min=-MAX_PLACE, max=MAX_PLACE) for name in ("x", "y", "z")}
NAME = Word(200)
ACTIONS: dict[str, dict[str, Rule]] = {
    "pause": {},
    "resume": {},
    "reset": {},
    "cancel": {},
    "step": {"count": Number(min=1, max=MAX_STEPS, integer=True)},
    "pace": {"factor": Number(min=0.0, max=MAX_PACE)},
    "place": {"model": NAME, **PLACE},
    "spawn": {"kind": Choice(KINDS), **PLACE},
    "goal": PLACE,
    "remove": {"model": NAME},
}
FIELDS: dict[str, dict[str, Rule]] = {
    "ack": {},
    "take": {},
    "release": {},
    "drive": {"speed": Number(min=-1.0, max=1.0), "steering": Number(min=-1.0, max=1.0)},
    "topic": {"topic": NAME},
    "want": {"camera": NAME, "lidar": NAME, "data": Flag(), "contacts": Flag()},
    "do": {"action": Choice(tuple(ACTIONS))},
}
# Fields that may be there: [rad] of place, spawn and goal; the model that gets the goal.
OPTIONAL = {"yaw": Number(min=-10.0, max=10.0), "model": NAME}
LAYERS = {"layers": Word(2000)}  # of want: topics of navigation, with blanks between them


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


def _checked(message: Mapping[str, Any], fields: Mapping[str, Rule]) -> dict[str, Any]:
    for name, rule in fields.items():
        valid = rule.complaint(message.get(name))
        if valid:
            raise BadMessage(f"{name} is {_shown(message.get(name))}, must be {valid}")
    return {name: message[name] for name in fields}


def _shown(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
