"""The node `keyboard`: arrow keys to /cmd_vel, with the truck drawn in the terminal."""

import os
import sys

import rospy
from paddock_common.rules import Choice, Number
from paddock_common.settings import parameter

from cybertruck.teleop.keyboard.keys import KeyTeleop
from cybertruck.teleop.keyboard.terminal_keys import HOLD, TerminalKeys
from cybertruck.teleop.keyboard.x_keys import NoServer, XKeys
from cybertruck.teleop.session import Ended, run

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
    """The keyboard node."""

    def __init__(self, session):
        """Reads the parameters and finds a source of keys.

        Args:
            session: Session.

        Raises:
            Ended: There is no source of keys.
            ValueError: A parameter is wrong; the message names it.
        """
        self._session = session
        self.teleop = KeyTeleop(session.speeds())
        wanted = parameter(rospy.get_param, "keys", "auto", Choice(SOURCES))
        hold = parameter(rospy.get_param, "hold_time", HOLD, Number(above=0.0, unit="s"))
        self._x, self._terminal = None, None
        reason = "keys:=terminal was asked for"
        if wanted != "terminal":
            try:
                self._x = XKeys(self.teleop)
                self._notes = ("Keys come from the X server, wherever the focus is.",)
                if os.environ.get("WAYLAND_DISPLAY"):
                    self._notes += ("Wayland: only X windows' keys arrive; else keys:=terminal.",)
            except NoServer as error:
                if wanted == "x":
                    raise Ended(f"keys:=x: {error}") from None
                reason = str(error)
        if self._x is None:
            if not (sys.stdin.isatty() and sys.stdout.isatty()):
                raise Ended(
                    f"no keys: {reason}, and this is no terminal (start the teleop in a "
                    "terminal, or set DISPLAY)"
                )
            self._terminal = TerminalKeys(self.teleop, hold)
            self._notes = (
                f"Keys come from this terminal ({reason}).",
                f"C is Caps Lock; held means a repeat within {hold:g} s; no chords: to "
                "turn, use continuous mode (C), then Up, then Left or Right.",
            )
        self._help = tuple(
            line.replace("{mode}", "Caps Lock" if self._x else "C        ") for line in HELP
        )

    def tick(self, now, period):
        """Processes the keys, publishes the command, draws.

        Args:
            now: Time [s].
            period: Time since the last call [s].

        Raises:
            Ended: The X server is gone.
        """
        screen = self._session.screen
        codes = screen.keys() if screen else ()
        if self._x:  # the same keys from the terminal are dropped
            self._x.poll()
            if not self._x.alive:
                self.teleop.release_all()
                self.teleop.stop()
                raise Ended("the X server is gone; the truck was stopped")
        else:
            for code in codes:
                self._terminal.feed(code, now)
            self._terminal.expire(now)
        self._session.send(*self.teleop.wanted, period)
        self._session.show("Cyber Truck: keyboard teleop", self.teleop, self._notes, self._help)


def main():
    """Runs the node.

    Returns:
        Exit status.
    """
    return run("keyboard", KeyboardNode)
