"""The terminal's screen: car, keys, speeds."""

import curses
import os
import textwrap
from dataclasses import dataclass
from itertools import zip_longest

WIDTH, HEIGHT = 25, 15  # of the image, in characters
FRONT = {1: "\\ \\", 0: "| |", -1: "/ /"}  # steering -> a wheel from above
TREAD = "-=~"  # characters of a rolling wheel, one after the other
BODY = (
    "   ,-------.   ",
    "  /_________\\  ",
    "  |  ,---.  |  ",
    "  | /_____\\ |  ",
    "  | |     | |  ",
    "  | |_____| |  ",
    "  | |:::::| |  ",
    "  | |:::::| |  ",
    "  |_________|  ",
)


def truck(drive, turn, phase):
    """Draws the truck in characters.

    Args:
        drive: 1 forward, -1 backward, 0 at rest.
        turn: Where the front wheels point: 1 left, -1 right, 0 straight ahead.
        phase: Number that grows while the truck moves.

    Returns:
        HEIGHT lines of at most WIDTH characters.
    """
    arrow_head = {1: "^", -1: "v"}.get(drive, "")
    lean = {1: "<", -1: ">"}.get(turn, "")
    trail = ["", "", ""]
    if arrow_head:
        count = 1 + phase % 3
        for row in range(3):
            distance = 2 - row if drive > 0 else row
            trail[row] = f"{arrow_head} {arrow_head} {arrow_head}" if distance < count else ""
    arrow = (lean + " ") * 3 if turn else ""
    above = trail if drive > 0 else ["", "", ""]
    below = trail if drive < 0 else ["", "", ""]
    tread = TREAD[-drive * phase % 3]
    front, rear = FRONT[turn], f"|{tread}|"
    lines = [line.center(WIDTH) for line in above]
    for row, text in enumerate(BODY):
        if row in (1, 2):
            lines.append(f" {front} {text[1:-1]} {front} ".center(WIDTH))
        elif row in (6, 7):
            lines.append(f" {rear} {text[1:-1]} {rear} ".center(WIDTH))
        else:
            lines.append(text.center(WIDTH))
    lines += [line.center(WIDTH) for line in below]
    side = 1 if drive >= 0 else len(lines) - 2
    if arrow and drive:
        line = arrow.strip()
        lines[side] = (
            (line + lines[side][len(line) :])
            if turn > 0
            else (lines[side][: WIDTH - len(line)] + line)
        )
    return [line.rstrip() for line in lines]


MIN_WIDTH, MIN_HEIGHT = 60, 20  # smaller terminals get a short text
BAR = 12  # characters of a velocity's bar, to either side


@dataclass(frozen=True)
class View:
    """Contents of the screen.

    Attributes:
        title: First line.
        command: The last one, linear.x [m/s] and angular.z [rad/s].
        teleop: KeyTeleop or PadTeleop: its speeds, motion and mode.
        limits: Limits, for the bars.
        notes: Lines about the source of the events, warnings first.
        help: Lines of key help.
        phase: Grows by one a frame while the truck moves.
    """

    title: str
    command: tuple
    teleop: object
    limits: object
    notes: tuple = ()
    help: tuple = ()
    phase: int = 0


def bar(value, maximum):
    """Draws a number as a bar that grows to the right or to the left of the center."""
    length = min(BAR, round(abs(value) / maximum * BAR)) if maximum > 0.0 else 0
    if value and not length:
        length = 1
    if value < 0.0:
        return "[" + ("#" * length).rjust(BAR) + "|" + " " * BAR + "]"
    return "[" + " " * BAR + "|" + ("#" * length).ljust(BAR) + "]"


def motion_text(drive, turn):
    """Returns the text of a motion."""
    if not drive:
        return "at rest"
    direction = "forward" if drive > 0 else "backward"
    return direction + {1: ", wheels left", -1: ", wheels right"}.get(turn, "")


def render(view: View, width, height):
    """Lays out a view.

    Args:
        width, height: Columns and rows of the terminal.

    Returns:
        At most `height` strings of at most `width - 1` characters: the last column stays free,
        since a character in the last cell makes some terminals scroll.
    """
    width = max(width - 1, 0)
    linear, angular = view.command
    speeds, motion = view.teleop.speeds, motion_text(*view.teleop.motion)
    mode = "continuous" if view.teleop.continuous else "held"
    if width + 1 < MIN_WIDTH or height < MIN_HEIGHT:
        short = [
            f"{linear:+.2f} m/s {angular:+.2f} rad/s",
            f"{mode}, {motion}",
            f"set {speeds.linear:.2f} {speeds.angular:.2f}",
            *view.notes,
            f"(the image needs {MIN_WIDTH}x{MIN_HEIGHT})",
        ]
        return [line[:width] for line in short][:height]
    left = [
        f"linear.x  {linear:+7.3f} m/s   angular.z {angular:+7.3f} rad/s",
        f"linear    {bar(linear, view.limits.max_speed)}",
        f"angular   {bar(angular, view.limits.max_angular)}",
        f"speeds    {speeds.linear:7.3f} m/s             {speeds.angular:7.3f} rad/s",
        f"mode      {mode}",
        f"motion    {motion}",
        "",
        *view.help,
    ]
    image = truck(*view.teleop.motion, view.phase)
    column = max(width - WIDTH - 1, 0)
    if width > 100:
        column = 70 + (width - 70 - WIDTH) // 2
    rows = [view.title, "-" * width]
    for text, image_row in zip_longest(left, image, fillvalue=""):
        rows.append(text[: column - 1].ljust(column) + image_row)
    rows.append("-" * width)
    for note in view.notes:
        rows += textwrap.wrap(note, width)
    return [row[:width] for row in rows][:height]


class Screen:
    """A curses screen for a terminal that may change its size."""

    def __init__(self):
        """Opens the terminal; close() restores it.

        Raises:
            curses.error: The terminal's type is unknown.
        """
        os.environ["ESCDELAY"] = "25"  # [ms] in which the rest of a key's sequence comes
        self._window = curses.initscr()
        curses.noecho()
        curses.cbreak()
        try:
            curses.curs_set(0)
        except curses.error:  # a terminal without a cursor to hide
            pass
        self._window.keypad(True)
        self._window.nodelay(True)
        self._window.refresh()  # the terminal sends arrow keys as curses expects them from here on
        self._displayed = None

    def keys(self):
        """Returns the received key codes, oldest first."""
        codes = []
        while len(codes) < 1000:
            code = self._window.getch()
            if code == -1:
                break
            if code == curses.KEY_RESIZE:
                curses.update_lines_cols()
                self._displayed = None
                continue
            codes.append(code)
        return codes

    def show(self, view):
        """Shows a view; writes only changes."""
        height, width = self._window.getmaxyx()
        rows = render(view, width, height)
        if rows == self._displayed:
            return
        self._window.erase()
        for row, text in enumerate(rows):
            try:
                self._window.addstr(row, 0, text)
            except curses.error:  # the terminal shrank meanwhile; the next frame fits
                break
        self._window.refresh()
        self._displayed = rows

    def close(self):
        """Restores the terminal."""
        self._window.keypad(False)
        curses.endwin()
