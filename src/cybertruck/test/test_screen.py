"""The teleops' screen at every size: fits, shows its content, moves."""

import pytest
from cybertruck.teleop import screen
from cybertruck.teleop.joystick import SCHEMES
from cybertruck.teleop.keyboard import HELP, KeyTeleop
from cybertruck.teleop.limits import Limits, Speeds
from cybertruck.teleop.screen import View, bar, render


def view_with(lines):
    """A View of a truck that backs to the right in continuous mode."""
    teleop = KeyTeleop(Speeds(0.605, 0.495))
    for key in ("mode", "right", "down"):
        teleop.press(key)
    notes = ("one", "two", "three")
    return View("Cyber Truck", (-0.5, 0.25), teleop, Limits(), notes, lines)


@pytest.mark.parametrize("width", [1, 2, 10, 39, 59, 60, 79, 80, 81, 100, 120, 200])
@pytest.mark.parametrize("height", [1, 2, 10, 19, 20, 24, 40, 60])
def test_every_size_fits(width, height):
    rows = render(view_with(HELP), width, height)
    assert len(rows) <= height
    assert all(len(row) <= width - 1 for row in rows)


@pytest.mark.parametrize("width, height", [(80, 24), (120, 40)])
@pytest.mark.parametrize("lines", [HELP, *(scheme.help for scheme in SCHEMES.values())])
def test_all_is_shown(width, height, lines):
    text = "\n".join(render(view_with(lines), width, height))
    for words in (
        "-0.500 m/s",
        "+0.250 rad/s",
        "0.605",
        "0.495",
        "continuous",
        "backward, wheels right",
        "one",
        "two",
        "three",
        "> > >",
        "v v v",
        *lines,
    ):
        assert words in text


@pytest.mark.parametrize("width, height", [(30, 5), (59, 24), (80, 19)])
def test_small_terminals_get_a_short_text(width, height):
    text = "\n".join(render(view_with(HELP), width, height))
    assert "-0.50 m/s +0.25 rad/s" in text and "continuous" in text and "|" not in text


@pytest.mark.parametrize("drive", [-1, 0, 1])
@pytest.mark.parametrize("turn", [-1, 0, 1])
def test_truck_fits_and_shows_its_wheels(drive, turn):
    for phase in range(7):
        lines = screen.truck(drive, turn, phase)
        assert len(lines) == screen.HEIGHT and max(map(len, lines)) <= screen.WIDTH
        assert "\n".join(lines).count(screen.FRONT[turn]) >= 4


def test_the_truck_moves_only_when_it_drives():
    assert len({tuple(screen.truck(1, 0, phase)) for phase in range(3)}) == 3
    assert len({tuple(screen.truck(-1, 0, phase)) for phase in range(3)}) == 3
    assert len({tuple(screen.truck(0, 0, phase)) for phase in range(3)}) == 1
    assert screen.truck(1, 0, 1) != screen.truck(-1, 0, 1)


@pytest.mark.parametrize(
    "value, expected",
    [
        (0.0, "[            |            ]"),
        (3.0, "[            |############]"),
        (-3.0, "[############|            ]"),
        (-1.5, "[      ######|            ]"),
        (0.01, "[            |#           ]"),
        (99.0, "[            |############]"),
    ],
)
def test_bar(value, expected):
    assert bar(value, 3.0) == expected
