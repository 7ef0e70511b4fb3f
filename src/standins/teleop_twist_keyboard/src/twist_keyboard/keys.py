"""What each key does: where to go, how fast."""

# (forward, left, up, turn to the left), each -1, 0 or 1
MOVES = {
    "u": (1, 0, 0, 1),
    "i": (1, 0, 0, 0),
    "o": (1, 0, 0, -1),
    "j": (0, 0, 0, 1),
    "l": (0, 0, 0, -1),
    "m": (-1, 0, 0, -1),
    ",": (-1, 0, 0, 0),
    ".": (-1, 0, 0, 1),
    "U": (1, 1, 0, 0),
    "I": (1, 0, 0, 0),
    "O": (1, -1, 0, 0),
    "J": (0, 1, 0, 0),
    "L": (0, -1, 0, 0),
    "M": (-1, 1, 0, 0),
    "<": (-1, 0, 0, 0),
    ">": (-1, -1, 0, 0),
    "t": (0, 0, 1, 0),
    "b": (0, 0, -1, 0),
}
# factors of (speed, turn rate)
SCALES = {
    "q": (1.1, 1.1),
    "z": (0.9, 0.9),
    "w": (1.1, 1.0),
    "x": (0.9, 1.0),
    "e": (1.0, 1.1),
    "c": (1.0, 0.9),
}
QUIT = "\x03"  # Ctrl-C
STILL = (0, 0, 0, 0)

HELP = """
Keys become velocity commands.

  drive and turn      with Shift: sideways
    u   i   o            U   I   O
    j   k   l            J   K   L
    m   ,   .            M   <   >

  t, b     up, down
  q, z     10 % faster, slower
  w, x     10 % faster, slower, driving alone
  e, c     10 % faster, slower, turning alone
  any other key stops, Ctrl-C ends
"""


class Keys:
    """Where to go and how fast, changed by keys.

    Args:
        speed: First speed [m/s].
        turn: First turn rate [rad/s].
        speed_limit: Highest speed [m/s].
        turn_limit: Highest turn rate [rad/s].

    Attributes:
        move: (forward, left, up, turn), each -1, 0 or 1.
    """

    def __init__(self, speed=0.5, turn=1.0, speed_limit=1000.0, turn_limit=1000.0):
        self.speed, self.turn = speed, turn
        self._limits = speed_limit, turn_limit
        self.move = STILL

    def press(self, key):
        """Takes a key, or "" when none came in time.

        Returns:
            Whether there is something to send.
        """
        if key in MOVES:
            self.move = MOVES[key]
        elif key in SCALES:
            self.speed = min(self._limits[0], self.speed * SCALES[key][0])
            self.turn = min(self._limits[1], self.turn * SCALES[key][1])
        else:
            if key == "" and self.move == STILL:
                return False
            self.move = STILL
        return True

    @property
    def velocity(self):
        """(forward, left, up [m/s], turn [rad/s])."""
        forward, left, up, turn = self.move
        return forward * self.speed, left * self.speed, up * self.speed, turn * self.turn

    def status(self):
        """One line: speed and turn rate, and whether they are at their limits."""
        line = f"currently:\tspeed {self.speed:.4g} m/s\tturn {self.turn:.4g} rad/s"
        for name, value, limit in zip(("speed", "turn"), (self.speed, self.turn), self._limits):
            if value >= limit:
                line += f"\t{name} is at its limit"
        return line
