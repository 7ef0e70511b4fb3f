"""Joystick teleop: pads, schemes, the node."""

import math
import queue
import time
from dataclasses import dataclass

import rospy
from paddock_common.settings import Choice, Number, check, from_table, number, parameter
from sensor_msgs.msg import Joy

from cybertruck.teleop.limits import Speeds
from cybertruck.teleop.session import run

STICKS = ("left_x", "left_y")
TRIGGERS = ("l2", "r2")
BUTTONS = ("cross", "circle", "square", "triangle", "l1", "r1", "r3")
LABEL = "pad map: "  # before names in messages
PRESSED, RELEASED = 0.6, 0.4  # fractions of a trigger's range at which it is a button


@dataclass(frozen=True)
class PadMap:
    """Indices of a pad's axes and buttons.

    Attributes:
        axes: Name -> index in Joy.axes, for sticks and triggers.
        buttons: Name -> index in Joy.buttons.
        trigger_released: Value of a trigger at rest.
        trigger_pressed: Value of a trigger that is pulled fully.
        inverted: Names of sticks whose sign is inverted; left and up are positive afterwards.

    Raises:
        ValueError: Something is missing, unknown or not an index; the message names it.
    """

    axes: dict = None
    buttons: dict = None
    trigger_released: float = number(1.0)
    trigger_pressed: float = number(-1.0)
    inverted: list = ()

    def __post_init__(self):
        check_indices("axes", self.axes, STICKS + TRIGGERS)
        check_indices("buttons", self.buttons, BUTTONS)
        check(self, prefix=LABEL)
        if self.trigger_released == self.trigger_pressed:
            raise ValueError(f"{LABEL}trigger_released and trigger_pressed are the same")
        if not isinstance(self.inverted, (list, tuple)) or not set(self.inverted) <= set(STICKS):
            raise ValueError(
                f"{LABEL}inverted is {self.inverted!r}; it must be a list of {', '.join(STICKS)}"
            )


def check_indices(group, indices, names):
    """Checks name -> index of one group.

    Raises:
        ValueError: A name is missing or unknown, or an index is not a whole number from 0 on.
    """
    if not isinstance(indices, dict):
        raise ValueError(f"{LABEL}{group} is {indices!r}; it must name {', '.join(names)}")
    for name in indices:
        Choice(names).check(f"{LABEL}name in {group}", name)
    for name in names:
        Number(min=0, integer=True).check(f"{LABEL}{group}/{name}", indices.get(name))


@dataclass(frozen=True)
class PadState:
    """State of a pad.

    Attributes:
        sticks: Name -> -1..1, left and up positive.
        triggers: Name -> 0 (at rest) .. 1 (pulled).
        pressed: Names of the buttons that went down with this message; l2 and r2 among them.
        idle: Whether there is no input.
        unplugged: Whether this is the all-zero message of a driver whose pad has disconnected.
    """

    sticks: dict
    triggers: dict
    pressed: frozenset
    idle: bool
    unplugged: bool = False


class PadReader:
    """Converts a sequence of Joy messages to pad states.

    Drivers report a trigger as 0 until it is first moved, although it rests at trigger_released;
    0 would mean half pulled. So a trigger counts as at rest until it has left 0. A driver whose pad
    was unplugged sends zeros for all axes, again half pulled. That message is recognised if both
    triggers had been moved, or if a trigger jumps to 0 from one of its limits.

    Args:
        deadzone: Fraction of a stick's or trigger's range that counts as rest.
    """

    def __init__(self, pad: PadMap, deadzone=0.05):
        self._pad = pad
        self._deadzone = deadzone
        self.reset()

    def reset(self):
        """Resets for a new or disconnected pad."""
        self._moved = set()
        self._last = dict.fromkeys(TRIGGERS, 0.0)
        self._down = frozenset()

    def read(self, axes, buttons) -> PadState:
        """Processes one message.

        Raises:
            ValueError: The message has too few axes or buttons or has a value that is not finite.
        """
        pad = self._pad
        for group, table, values in (("axes", pad.axes, axes), ("buttons", pad.buttons, buttons)):
            name = max(table, key=table.get)
            if table[name] >= len(values):
                raise ValueError(
                    f"the pad has {len(values)} {group}, {name} should be number "
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
        """Returns whether the triggers could not have moved to 0."""
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
        pull = (value - pad.trigger_released) / (pad.trigger_pressed - pad.trigger_released)
        return min(pull, 1.0) if pull > self._deadzone else 0.0


@dataclass(frozen=True)
class Scheme:
    """Functions of a pad's sticks, triggers and buttons.

    Attributes:
        drive: Function (PadState) -> -1..1, forward positive.
        buttons: Name of a button -> action: a step of Speeds.apply, "stop" or "continuous".
        help: Lines of key help.
    """

    drive: object
    buttons: dict
    help: tuple


SCHEMES = {
    "traditional": Scheme(
        lambda pad: pad.triggers["r2"] - pad.triggers["l2"],
        {
            "triangle": "turn_faster",
            "cross": "turn_slower",
            "square": "faster",
            "circle": "slower",
            "l1": "stop",
            "r1": "reset",
            "r3": "continuous",
        },
        (
            "R2, L2             forward, backward",
            "left stick         wheels left, right",
            "Triangle / Cross   turning +10 % / -10 %",
            "Square / Circle    speed +10 % / -10 %",
            "R1   speeds back to the defaults",
            "L1   stop",
            "R3   held or continuous mode",
            "Ctrl-C   end",
        ),
    ),
    "alternate": Scheme(
        lambda pad: -pad.sticks["left_y"],  # up drives backward
        {
            "circle": "reset",
            "cross": "stop",
            "square": "continuous",
            "l1": "turn_slower",
            "r1": "turn_faster",
            "l2": "slower",
            "r2": "faster",
        },
        (
            "left stick down, up       forward, backward",
            "left stick sideways       wheels left, right",
            "R1 / L1   turning +10 % / -10 %",
            "R2 / L2   speed +10 % / -10 %",
            "Circle    speeds back to the defaults",
            "Cross     stop",
            "Square    held or continuous mode",
            "Ctrl-C    end",
        ),
    ),
}


class PadTeleop:
    """Commands from a pad.

    In continuous mode the drive stays at the maximum pull since trigger or stick left its rest,
    until a stop or the next pull. The wheels follow the stick in both modes.

    Args:
        scheme: Key of SCHEMES.
        speeds: Speeds; None: the defaults.

    Raises:
        ValueError: There is no such scheme.
    """

    def __init__(self, scheme, speeds=None):
        if scheme not in SCHEMES:
            raise ValueError(f"scheme is {scheme!r}; it must be one of {', '.join(SCHEMES)}")
        self.scheme = SCHEMES[scheme]
        self.speeds = speeds or Speeds()
        self.continuous = False
        self.halt()

    def halt(self):
        """Stops all motion: the pad has disconnected or its message is invalid."""
        self._drive, self._steer = 0.0, 0.0
        self._live, self._stopped = 0.0, False

    def update(self, pad: PadState):
        """Updates with a pad state."""
        live = self.scheme.drive(pad)
        self._steer = pad.sticks["left_x"]
        if live == 0.0:
            self._stopped = False  # after a stop the drive must go through rest
        for name in sorted(pad.pressed & self.scheme.buttons.keys()):
            action = self.scheme.buttons[name]
            if action == "stop":
                self._drive, self._stopped = 0.0, live != 0.0
            elif action == "continuous":
                self.continuous = not self.continuous
            else:
                self.speeds.apply(action)
        if self._stopped:
            self._drive = 0.0
        elif not self.continuous:
            self._drive = live
        elif live != 0.0:
            new_pull = self._live == 0.0 or live * self._drive <= 0.0
            self._drive = live if new_pull or abs(live) > abs(self._drive) else self._drive
        self._live = live

    @property
    def motion(self):
        """Drive and steering as signs, for the screen."""
        drive = (self._drive > 0.0) - (self._drive < 0.0)
        steer = (self._steer > 0.0) - (self._steer < 0.0)
        return (drive, steer) if drive else (0, 0)

    @property
    def target(self):
        """The requested command: (linear.x [m/s], angular.z [rad/s])."""
        if self._drive == 0.0:
            return 0.0, 0.0
        sign = 1.0 if self._drive > 0.0 else -1.0
        return (self._drive * self.speeds.linear, sign * self._steer * self.speeds.angular + 0.0)


WAITING, DRIVING, DISCONNECTED = "waiting", "driving", "disconnected"


class JoystickNode:
    """The joystick node.

    It publishes periodically from the first input of the pad on. When the pad disconnects it
    publishes one zero and nothing more until the next input.

    Raises:
        ValueError: A parameter is wrong; the message names it.
    """

    def __init__(self, session):
        self._session = session
        self._name = rospy.get_param("~scheme", "traditional")
        self.teleop = PadTeleop(self._name, session.speeds())
        deadzone = parameter(rospy.get_param, "deadzone", 0.05, Number(above=0.0, below=1.0))
        pad = from_table(PadMap, rospy.get_param("~pad", None), "pad map")
        self._reader = PadReader(pad, deadzone)
        self._timeout = parameter(rospy.get_param, "joy_timeout", 0.5, Number(above=0.0, unit="s"))
        self._messages = queue.SimpleQueue()
        self._state, self._received = WAITING, None
        self._complaint = None
        rospy.Subscriber(
            "joy",
            Joy,
            lambda message: self._messages.put((time.monotonic(), message)),
            queue_size=None,
        )

    def tick(self, now, period):
        """Processes the pad's messages, publishes the command, updates the screen."""
        while True:
            try:
                when, message = self._messages.get_nowait()
            except queue.Empty:
                break
            self._received = when
            self._process(message)
        if self._state == DRIVING and now - self._received > self._timeout:
            self._on_disconnected(
                f"no /joy for {self._timeout:g} s: the pad is disconnected, the truck was stopped"
            )
        if self._state == DRIVING:
            self._session.send(*self.teleop.target, period)
        if self._session.screen:
            self._session.screen.keys()  # typed keys are ignored
        title = f"Cyber Truck: joystick teleop, {self._name}"
        self._session.show(title, self.teleop, self._notes(), self.teleop.scheme.help)

    def _notes(self):
        """Lines about the pad and its errors."""
        state_note = {
            WAITING: "Waiting for /joy: move a stick or press a button.",
            DRIVING: "The pad drives.",
            DISCONNECTED: "The pad is disconnected; nothing is sent.",
        }[self._state]
        return (state_note,) if self._complaint is None else (state_note, self._complaint)

    def _process(self, message):
        """Processes one Joy message."""
        try:
            pad = self._reader.read(message.axes, message.buttons)
        except ValueError as error:
            self._on_disconnected(f"/joy: {error}; the truck was stopped")
            return
        if pad.unplugged and self._state == DRIVING:
            self._on_disconnected("the pad was unplugged; the truck was stopped")
            return
        if self._state != DRIVING:
            if pad.idle:
                return
            self._state, self._complaint = DRIVING, None
        self.teleop.update(pad)

    def _on_disconnected(self, text):
        """Publishes one zero, stops publishing and logs the reason once."""
        if self._complaint != text:
            rospy.logwarn("joystick: %s", text)
        self._complaint = text
        self.teleop.halt()
        self._reader.reset()
        if self._state == DRIVING:
            self._session.send_zero()
        self._state = DISCONNECTED


def main():
    """Runs the node; returns its exit status."""
    return run("joystick", JoystickNode)
