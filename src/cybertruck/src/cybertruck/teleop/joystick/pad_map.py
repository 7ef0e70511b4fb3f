"""Map of a pad's axes and buttons: read from YAML, applied to sensor_msgs/Joy."""

import math
from dataclasses import dataclass

from paddock_common.rules import Number

STICKS = ("left_x", "left_y")
TRIGGERS = ("l2", "r2")
BUTTONS = ("cross", "circle", "square", "triangle", "l1", "r1", "r3")
PRESSED, RELEASED = 0.6, 0.4  # part of a trigger's range where it counts as a button


@dataclass(frozen=True)
class PadMap:
    """Numbers of a pad's axes and buttons.

    Attributes:
        axes: Name -> index in Joy.axes, for sticks and triggers.
        buttons: Name -> index in Joy.buttons.
        released: Value of a trigger at rest.
        pressed: Value of a trigger that is pulled fully.
        inverted: Names of sticks whose sign is turned; left and up are positive afterwards.
    """

    axes: dict
    buttons: dict
    released: float = 1.0
    pressed: float = -1.0
    inverted: tuple = ()


def parse(table):
    """Reads a pad map.

    Args:
        table: Dict with axes and buttons (name -> index), and optionally trigger_released,
            trigger_pressed and inverted.

    Returns:
        PadMap.

    Raises:
        ValueError: Something is missing, unknown or no index; the message names it.
    """
    if not isinstance(table, dict):
        raise ValueError(f"the pad map is {table!r}; it must be a dictionary")
    known = ("axes", "buttons", "trigger_released", "trigger_pressed", "inverted")
    for key in table:
        if key not in known:
            raise ValueError(f"pad map: unknown key {key!r}; there are {', '.join(known)}")
    axes = indices(table, "axes", STICKS + TRIGGERS)
    buttons = indices(table, "buttons", BUTTONS)
    ends = {}
    for key, default in (("trigger_released", 1.0), ("trigger_pressed", -1.0)):
        ends[key] = float(Number().check(f"pad map: {key}", table.get(key, default)))
    if ends["trigger_released"] == ends["trigger_pressed"]:
        raise ValueError("pad map: trigger_released and trigger_pressed are the same")
    inverted = table.get("inverted", [])
    if not isinstance(inverted, list) or not set(inverted) <= set(STICKS):
        raise ValueError(
            f"pad map: inverted is {inverted!r}; it must be a list of {', '.join(STICKS)}"
        )
    return PadMap(axes, buttons, ends["trigger_released"], ends["trigger_pressed"], tuple(inverted))


def indices(table, kind, names):
    """Reads name -> index of one kind.

    Raises:
        ValueError: A name is missing or unknown, or an index is no whole number from 0 on.
    """
    given = table.get(kind)
    if not isinstance(given, dict):
        raise ValueError(f"pad map: {kind} is {given!r}; it must name {', '.join(names)}")
    for name in given:
        if name not in names:
            raise ValueError(
                f"pad map: unknown name {name!r} in {kind}; there are {', '.join(names)}"
            )
    for name in names:
        Number(least=0, whole=True).check(f"pad map: {kind}/{name}", given.get(name))
    return dict(given)


@dataclass(frozen=True)
class PadState:
    """State of a pad.

    Attributes:
        sticks: Name -> -1..1, left and up positive.
        triggers: Name -> 0 (at rest) .. 1 (pulled).
        pressed: Names of the buttons that went down with this message; l2 and r2 among them.
        idle: Whether there is no input.
        unplugged: Whether this is the all-zero message of a driver that lost its pad.
    """

    sticks: dict
    triggers: dict
    pressed: frozenset
    idle: bool
    unplugged: bool = False


class PadReader:
    """Turns a sequence of Joy messages into pad states.

    Drivers report a trigger as 0 until it is first moved, although it rests at trigger_released;
    0 would be half pulled. So a trigger counts as at rest until it has left 0. A driver whose pad
    was unplugged sends zeros for all axes, again half pulled. That message is recognised if both
    triggers had been moved, or if a trigger jumps to 0 from one of its ends.
    """

    def __init__(self, pad, deadzone=0.05):
        """Starts with nothing pressed.

        Args:
            pad: PadMap.
            deadzone: Part of a stick's or trigger's range that counts as rest.
        """
        self._pad = pad
        self._deadzone = deadzone
        self.reset()

    def reset(self):
        """Resets for a new or lost pad."""
        self._moved = set()
        self._last = dict.fromkeys(TRIGGERS, 0.0)
        self._down = frozenset()

    def read(self, axes, buttons):
        """Processes one message.

        Args:
            axes: Values of all axes.
            buttons: Values of all buttons.

        Returns:
            PadState.

        Raises:
            ValueError: The message has too few axes or buttons or has a value that is not finite.
        """
        pad = self._pad
        for kind, table, values in (("axes", pad.axes, axes), ("buttons", pad.buttons, buttons)):
            name = max(table, key=table.get)
            if table[name] >= len(values):
                raise ValueError(
                    f"the pad has {len(values)} {kind}, {name} should be number "
                    f"{table[name]} (counted from 0); is this the right pad map?"
                )
        for name, index in pad.axes.items():
            if not math.isfinite(axes[index]):
                raise ValueError(f"axis {index} ({name}) is {axes[index]}; it must be a number")
        unplugged = not any(axes) and not any(buttons) and self._cannot_be_zero()
        if unplugged:
            self._moved.clear()
        sticks = {name: self._stick(name, axes[pad.axes[name]]) for name in STICKS}
        triggers = {name: self._trigger(name, axes[pad.axes[name]]) for name in TRIGGERS}
        self._last = {name: axes[pad.axes[name]] for name in TRIGGERS}
        before = self._down
        down = {name for name, index in pad.buttons.items() if buttons[index]}
        for name, value in triggers.items():
            if value >= PRESSED or (value > RELEASED and name in before):
                down.add(name)
        self._down = frozenset(down)
        idle = not down and not any(sticks.values()) and not any(triggers.values())
        return PadState(sticks, triggers, frozenset(down - before), idle, unplugged)

    def _cannot_be_zero(self):
        """Returns whether the triggers could not have come to 0 by themselves."""
        return len(self._moved) == len(TRIGGERS) or any(
            abs(self._last[name]) > 0.5 for name in self._moved
        )

    def _stick(self, name, value):
        if name in self._pad.inverted:
            value = -value
        value = min(max(value, -1.0), 1.0)
        return value if abs(value) > self._deadzone else 0.0

    def _trigger(self, name, value):
        if value != 0.0:
            self._moved.add(name)
        elif name not in self._moved:
            return 0.0
        pad = self._pad
        pull = (value - pad.released) / (pad.pressed - pad.released)
        return min(pull, 1.0) if pull > self._deadzone else 0.0
