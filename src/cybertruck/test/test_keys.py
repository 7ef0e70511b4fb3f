"""The keyboard teleop's logic: every binding, held and continuous mode, terminal keys."""

import curses

import pytest
from cybertruck.teleop.keyboard import KeyTeleop, TerminalKeys
from cybertruck.teleop.limits import MIN_SPEED, Speeds

STOP = (0.0, 0.0)
FORWARD, BACK = (0.5, 0.0), (-0.5, 0.0)


def play(script, teleop=None):
    """Plays "+key" (press) and "-key" (release); returns the requested command."""
    teleop = teleop or KeyTeleop()
    for word in script.split():
        (teleop.press if word[0] == "+" else teleop.release)(word[1:])
    return teleop.target


@pytest.mark.parametrize(
    "script, expected",
    [
        ("", STOP),
        ("+up", FORWARD),
        ("+down", BACK),
        ("+left", STOP),
        ("+right", STOP),
        ("+up +left", (0.5, 0.5)),
        ("+up +right", (0.5, -0.5)),
        ("+left +up", (0.5, 0.5)),
        ("+down +left", (-0.5, -0.5)),  # the wheels point to the left, the truck turns right
        ("+down +right", (-0.5, 0.5)),
        ("+up +down", STOP),
        ("+up +left +right", FORWARD),
        ("+up -up", STOP),
        ("+up +left -left", FORWARD),
        ("+up +left -up", STOP),
        ("+up +down -up", BACK),
        ("+up +up -up", STOP),  # auto-repeat
        ("+up +s", STOP),
        ("+up +s -s", STOP),
        ("+up +s +up", STOP),  # auto-repeat of a key that S ended
        ("+up +s -up +up", FORWARD),
        ("+up +s +left", STOP),
        ("+n +up -n", FORWARD),
        ("-up", STOP),
    ],
)
def test_held_mode(script, expected):
    assert play(script) == pytest.approx(expected)


@pytest.mark.parametrize(
    "script, expected",
    [
        ("+up -up", FORWARD),
        ("+down -down", BACK),
        ("+left -left", STOP),
        ("+left -left +up -up", FORWARD),
        ("+up -up +left -left", (0.5, 0.5)),
        ("+up -up +left -left +right -right", (0.5, -0.5)),
        ("+up -up +left -left +up -up", FORWARD),  # a drive arrow starts a new motion
        ("+up +left -left -up", (0.5, 0.5)),
        ("+left +up -up -left", (0.5, 0.5)),
        ("+up -up +down -down", BACK),
        ("+up -up +left -left +down -down", BACK),
        ("+down -down +left -left", (-0.5, -0.5)),
        ("+up -up +s -s", STOP),
        ("+up -up +s -s +left -left", STOP),
        ("+up -up +q -q", (0.55, 0.0)),
        ("+up -up +mode -mode", STOP),
    ],
)
def test_continuous_mode(script, expected):
    assert play("+mode -mode " + script) == pytest.approx(expected)


def test_switching_to_continuous_keeps_what_is_held():
    assert play("+up +left +mode -mode -left -up") == pytest.approx((0.5, 0.5))


def test_mode_key_does_not_repeat():
    teleop = KeyTeleop()
    play("+mode +mode", teleop)
    assert teleop.continuous
    play("-mode +mode", teleop)
    assert not teleop.continuous


@pytest.mark.parametrize(
    "keys, expected",
    [
        ("q", (0.55, 0.5)),
        ("z", (0.45, 0.5)),
        ("w", (0.5, 0.55)),
        ("x", (0.5, 0.45)),
        ("qq", (0.605, 0.5)),
        ("qz", (0.495, 0.5)),
        ("wwx", (0.5, 0.5445)),
        ("qwr", (0.5, 0.5)),
        ("zzxxr", (0.5, 0.5)),
        ("q" * 100, (3.0, 0.5)),
        ("w" * 100, (0.5, 3.0)),
        ("z" * 100, (MIN_SPEED, 0.5)),
        ("x" * 100, (0.5, MIN_SPEED)),
    ],
)
def test_speed_keys(keys, expected):
    teleop = KeyTeleop()
    for key in keys:
        play(f"+{key} -{key}", teleop)
    assert (teleop.speeds.linear, teleop.speeds.angular) == pytest.approx(expected)
    assert teleop.target == STOP
    assert play("+up +left", teleop) == pytest.approx(expected)


def test_lost_source_releases_all():
    teleop = KeyTeleop()
    play("+up +left", teleop)
    teleop.release_all()
    assert teleop.target == STOP


@pytest.mark.parametrize(
    "linear, angular, words",
    [
        (0.0, 0.5, "linear_speed is 0.0"),
        (9.0, 0.5, "from 0.01 to 3"),
        (0.5, -1.0, "angular_speed is -1.0"),
        (float("nan"), 0.5, "linear_speed is nan"),
        ("fast", 0.5, "'fast'"),
        (True, 0.5, "True"),
    ],
)
def test_bad_speeds(linear, angular, words):
    with pytest.raises(ValueError, match=words):
        Speeds(linear, angular)


def typed(events, until):
    """Types (time, key) into a terminal and returns the teleop at a time."""
    teleop = KeyTeleop()
    keys = TerminalKeys(teleop)
    codes = {
        "up": curses.KEY_UP,
        "down": curses.KEY_DOWN,
        "left": curses.KEY_LEFT,
        "right": curses.KEY_RIGHT,
    }
    for time, key in events:
        keys.feed(codes.get(key, ord(key[0])), time)
    keys.expire(until)
    return teleop


@pytest.mark.parametrize(
    "events, until, expected",
    [
        ([(0.0, "up")], 0.59, FORWARD),
        ([(0.0, "up")], 0.61, STOP),
        ([(0.0, "up"), (0.5, "up"), (1.0, "up")], 1.59, FORWARD),
        ([(0.0, "up"), (0.5, "up"), (1.0, "up")], 1.61, STOP),
        ([(0.0, "up"), (0.7, "up")], 0.8, FORWARD),
        ([(0.0, "up"), (0.1, "left")], 0.2, STOP),  # no chords
        ([(0.0, "up"), (0.1, "down")], 0.2, BACK),
        ([(0.0, "up"), (0.1, "s")], 0.2, STOP),
        ([(0.0, "up"), (0.1, "q")], 0.2, STOP),
        ([(0.0, "c"), (0.1, "up")], 9.0, FORWARD),
        ([(0.0, "C"), (0.1, "up"), (0.2, "left")], 9.0, (0.5, 0.5)),
        ([(0.0, "c"), (0.1, "up"), (0.2, "left"), (0.3, "up")], 9.0, FORWARD),
        ([(0.0, "c"), (0.1, "up"), (0.2, "s")], 9.0, STOP),
        ([(0.0, "c"), (0.1, "up"), (0.2, "c")], 9.0, STOP),
        ([(0.0, "c"), (0.1, "down"), (0.2, "Q"), (0.3, "Q")], 9.0, (-0.605, 0.0)),
        ([(0.0, "é"), (0.0, "1"), (0.0, "up")], 0.1, FORWARD),
    ],
)
def test_terminal_keys(events, until, expected):
    assert typed(events, until).target == pytest.approx(expected)
