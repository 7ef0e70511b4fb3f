"""Keyboard teleop: keys from the terminal and from X, the node."""

import curses
import os
import queue
import sys

import rospy
from paddock_common.settings import Choice, Number, parameter

from cybertruck.teleop.limits import Speeds
from cybertruck.teleop.session import TeleopExit, run

DRIVE = {"up": 1, "down": -1}
STEER = {"left": 1, "right": -1}
SPEED_KEYS = {"q": "faster", "z": "slower", "w": "turn_faster", "x": "turn_slower", "r": "reset"}
STOP_KEY, MODE_KEY = "s", "mode"
KEYS = (*DRIVE, *STEER, *SPEED_KEYS, STOP_KEY, MODE_KEY)


class KeyTeleop:
    """Commands from the keys.

    Held mode: the truck moves while keys are down, and keys add up. Continuous mode: the motion
    stays when its keys are released. A drive arrow starts a new motion (with the steering arrows
    that are down at that moment), a steering arrow changes the wheels of the current one, S stops
    it.

    Args:
        speeds: Speeds; None: the defaults.
    """

    def __init__(self, speeds=None):
        self.speeds = speeds or Speeds()
        self.continuous = False
        self._down = set()  # keys that are down
        self._spent = set()  # keys that are down but were stopped by S: they need a new press
        self._latched = (0, 0)  # drive and steering of continuous mode

    def press(self, key):
        """Processes a key press; a key that is down already (auto-repeat) changes nothing.

        Args:
            key: One of KEYS; anything else is ignored.
        """
        if key not in KEYS or key in self._down:
            return
        self._down.add(key)
        if key in SPEED_KEYS:
            self.speeds.apply(SPEED_KEYS[key])
        elif key == STOP_KEY:
            self.stop()
        elif key == MODE_KEY:
            self.continuous = not self.continuous
            self._latched = self._held()
        elif key in DRIVE:
            self._latched = self._held()
        else:
            self._latched = (self._latched[0], self._held()[1])

    def release(self, key):
        """Processes a key release."""
        self._down.discard(key)
        self._spent.discard(key)

    def release_all(self):
        """Releases all keys after their source has disconnected."""
        self._down.clear()
        self._spent.clear()

    def stop(self):
        """Stops all motion; keys that are down must be pressed again."""
        self._spent = set(self._down)
        self._latched = (0, 0)

    @property
    def motion(self):
        """Drive (1 forward, -1 backward, 0) and steering (1 left, -1 right, 0)."""
        drive, steer = self._latched if self.continuous else self._held()
        return (drive, steer) if drive else (0, 0)

    @property
    def target(self):
        """The requested command: (linear.x [m/s], angular.z [rad/s]).

        Steering alone is no command: the truck cannot turn at rest. Backwards, wheels that point
        to the left turn the truck to the right.
        """
        drive, steer = self.motion
        return drive * self.speeds.linear, drive * steer * self.speeds.angular + 0.0

    def _held(self):
        """Returns the sum of the arrows that are down: (drive, steering)."""
        active = self._down - self._spent
        return (
            sum(value for key, value in DRIVE.items() if key in active),
            sum(value for key, value in STEER.items() if key in active),
        )


HOLD_TIME = 0.6  # a key counts as held this long after its last repeat [s]
ARROWS = {
    curses.KEY_UP: "up",
    curses.KEY_DOWN: "down",
    curses.KEY_LEFT: "left",
    curses.KEY_RIGHT: "right",
}
LETTERS = {**{letter: letter for letter in "qzwxrs"}, "c": "mode"}


def name_of(code):
    """Returns the name of a key code of curses, or None for a key without a function."""
    if code in ARROWS:
        return ARROWS[code]
    if 0 <= code < 256:
        return LETTERS.get(chr(code).lower())
    return None


class TerminalKeys:
    """Turns repeated characters into presses and releases.

    A terminal reports characters, not keys: a key counts as held until its repeat stops, and only
    one key at a time, since the keyboard repeats only the last one.

    Args:
        hold_time: How long a key counts as held after its last character [s].
    """

    def __init__(self, teleop: KeyTeleop, hold_time=HOLD_TIME):
        self._teleop = teleop
        self._hold_time = hold_time
        self._key, self._until = None, 0.0

    def feed(self, code, now):
        """Processes one key code.

        Args:
            now: Time [s].
        """
        key = name_of(code)
        if key is None:
            return
        self.expire(now)
        if key != self._key or key not in ARROWS.values():
            self._drop()
            self._teleop.press(key)
            self._key = key
        self._until = now + self._hold_time

    def expire(self, now):
        """Releases the key whose repeat has stopped."""
        if self._key is not None and now >= self._until:
            self._drop()

    def _drop(self):
        if self._key is not None:
            self._teleop.release(self._key)
            self._key = None


class NoServer(RuntimeError):
    """No X server can be used; the text is the reason."""


class XKeys:
    """Collects key events in pynput's thread and processes them in the caller's."""

    def __init__(self, teleop: KeyTeleop):
        """Connects to the X server of DISPLAY.

        Raises:
            NoServer: There is none, or pynput cannot use it.
        """
        display = os.environ.get("DISPLAY", "")
        if not display:
            raise NoServer("DISPLAY is not set")
        try:
            from Xlib.display import Display

            Display(display).close()  # for its clear error; pynput connects when it is imported
            from pynput import keyboard

            self._names = {
                getattr(keyboard.Key, name): name for name in ("up", "down", "left", "right")
            }
            self._names[keyboard.Key.caps_lock] = "mode"
            self._listener = keyboard.Listener(
                on_press=lambda key: self._events.put((True, key)),
                on_release=lambda key: self._events.put((False, key)),
            )
        except Exception as error:  # pynput and Xlib raise many types, ImportError among them
            reason = str(error).strip().splitlines()[0] if str(error).strip() else repr(error)
            raise NoServer(f"no X server at DISPLAY={display}: {reason}") from error
        self._events = queue.SimpleQueue()
        self._teleop = teleop
        self._listener.daemon = True
        self._listener.start()
        self._listener.wait()

    @property
    def alive(self):
        """Whether the X server still responds."""
        return self._listener.is_alive()

    def poll(self):
        """Processes the collected events. The server's auto-repeat is presses without releases."""
        while True:
            try:
                down, key = self._events.get_nowait()
            except queue.Empty:
                return
            name = self.name_of(key)
            if name is not None:
                (self._teleop.press if down else self._teleop.release)(name)

    def name_of(self, key):
        """Returns the name in KEYS of a pynput key, or None."""
        if key in self._names:
            return self._names[key]
        character = getattr(key, "char", None)
        return character.lower() if character else None


SOURCES = ("auto", "x", "terminal")
HELP = (
    "Up, Down      forward, backward",
    "Left, Right   wheels left, right",
    "Q / Z         speed +10 % / -10 %",
    "W / X         turning +10 % / -10 %",
    "R   speeds back to the defaults",
    "S   stop",
    "{mode}  held or continuous mode",
    "Ctrl-C   end",
)


class KeyboardNode:
    """The keyboard node.

    Raises:
        TeleopExit: There is no source of keys.
        ValueError: A parameter is wrong; the message names it.
    """

    def __init__(self, session):
        self._session = session
        self.teleop = KeyTeleop(session.speeds())
        source = parameter(rospy.get_param, "keys", "auto", Choice(SOURCES))
        hold_time = parameter(rospy.get_param, "hold_time", HOLD_TIME, Number(above=0.0, unit="s"))
        self._x, self._terminal = None, None
        reason = "keys:=terminal was requested"
        if source != "terminal":
            try:
                self._x = XKeys(self.teleop)
                self._notes = ("Keys come from the X server, wherever the focus is.",)
                if os.environ.get("WAYLAND_DISPLAY"):
                    self._notes += ("Wayland: only X windows' keys arrive; else keys:=terminal.",)
            except NoServer as error:
                if source == "x":
                    raise TeleopExit(f"keys:=x: {error}") from None
                reason = str(error)
        if self._x is None:
            if not (sys.stdin.isatty() and sys.stdout.isatty()):
                raise TeleopExit(
                    f"no keys: {reason}, and this is not a terminal (start the teleop in a "
                    "terminal, or set DISPLAY)"
                )
            self._terminal = TerminalKeys(self.teleop, hold_time)
            self._notes = (
                f"Keys come from this terminal ({reason}).",
                f"C is Caps Lock; held means a repeat within {hold_time:g} s; no chords: to "
                "turn, use continuous mode (C), then Up, then Left or Right.",
            )
        self._help = tuple(
            line.replace("{mode}", "Caps Lock" if self._x else "C        ") for line in HELP
        )

    def tick(self, now, period):
        """Processes the keys, publishes the command, updates the screen.

        Raises:
            TeleopExit: The X server has exited.
        """
        screen = self._session.screen
        codes = screen.keys() if screen else ()
        if self._x:  # the same keys from the terminal are dropped
            self._x.poll()
            if not self._x.alive:
                self.teleop.release_all()
                self.teleop.stop()
                raise TeleopExit("the X server has exited; the truck was stopped")
        else:
            for code in codes:
                self._terminal.feed(code, now)
            self._terminal.expire(now)
        self._session.send(*self.teleop.target, period)
        self._session.show("Cyber Truck: keyboard teleop", self.teleop, self._notes, self._help)


def main():
    """Runs the node; returns its exit status."""
    return run("keyboard", KeyboardNode)
