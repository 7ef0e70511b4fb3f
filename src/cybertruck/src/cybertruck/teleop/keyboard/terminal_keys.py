"""Keys read from the terminal, which does not report releases."""

import curses

HOLD = 0.6  # a key counts as held this long after its last repeat [s]
ARROWS = {
    curses.KEY_UP: "up",
    curses.KEY_DOWN: "down",
    curses.KEY_LEFT: "left",
    curses.KEY_RIGHT: "right",
}
LETTERS = {letter: letter for letter in "qzwxrs"} | {"c": "mode"}


def name_of(code):
    """Returns the name of a curses key code, or None for a key without a meaning.

    Args:
        code: What curses' getch() returned.
    """
    if code in ARROWS:
        return ARROWS[code]
    if 0 <= code < 256:
        return LETTERS.get(chr(code).lower())
    return None


class TerminalKeys:
    """Turns repeated characters into presses and releases.

    A terminal reports characters, not keys: a key counts as held until its repeat stops, and only
    one key at a time, since the keyboard repeats only the last one.
    """

    def __init__(self, teleop, hold=HOLD):
        """Starts with no key down.

        Args:
            teleop: KeyTeleop.
            hold: How long a key counts as held after its last character [s].
        """
        self._teleop = teleop
        self._hold = hold
        self._key, self._until = None, 0.0

    def feed(self, code, now):
        """Processes one key code.

        Args:
            code: What curses' getch() returned.
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
        self._until = now + self._hold

    def expire(self, now):
        """Releases the key whose repeat has stopped."""
        if self._key is not None and now >= self._until:
            self._drop()

    def _drop(self):
        if self._key is not None:
            self._teleop.release(self._key)
            self._key = None
