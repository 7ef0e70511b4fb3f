"""The truck from above in characters, with turning and rolling wheels and arrows."""

WIDTH, HEIGHT = 25, 15  # of the picture, in characters
FRONT = {1: "\\ \\", 0: "| |", -1: "/ /"}  # turn of the wheels -> a wheel from above
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
    """Draws the truck.

    Args:
        drive: 1 forward, -1 backward, 0 at rest.
        turn: Where the front wheels point: 1 left, -1 right, 0 straight ahead.
        phase: Whole number that grows while the truck moves.

    Returns:
        HEIGHT lines of at most WIDTH characters.
    """
    mark = {1: "^", -1: "v"}.get(drive, "")
    lean = {1: "<", -1: ">"}.get(turn, "")
    trail = ["", "", ""]
    if mark:
        count = 1 + phase % 3
        for row in range(3):
            near = 2 - row if drive > 0 else row
            trail[row] = f"{mark} {mark} {mark}" if near < count else ""
    arrow = (lean + " ") * 3 if turn else ""
    ahead = trail if drive > 0 else ["", "", ""]
    behind = trail if drive < 0 else ["", "", ""]
    tread = TREAD[-drive * phase % 3]
    front, rear = FRONT[turn], f"|{tread}|"
    lines = [line.center(WIDTH) for line in ahead]
    for row, text in enumerate(BODY):
        if row in (1, 2):
            lines.append(f" {front} {text[1:-1]} {front} ".center(WIDTH))
        elif row in (6, 7):
            lines.append(f" {rear} {text[1:-1]} {rear} ".center(WIDTH))
        else:
            lines.append(text.center(WIDTH))
    lines += [line.center(WIDTH) for line in behind]
    side = 1 if drive >= 0 else len(lines) - 2
    if arrow and drive:
        line = arrow.strip()
        lines[side] = (
            (line + lines[side][len(line) :])
            if turn > 0
            else (lines[side][: WIDTH - len(line)] + line)
        )
    return [line.rstrip() for line in lines]
