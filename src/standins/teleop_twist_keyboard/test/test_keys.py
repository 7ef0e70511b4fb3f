"""What keys do; and a real pseudo-terminal."""

import os
import pty
import termios

import pytest
from twist_keyboard.node import MOVES, SCALES, Keys, Terminal


@pytest.mark.parametrize(
    "keys, velocity",
    [
        ("i", (0.5, 0.0, 0.0, 0.0)),
        (",", (-0.5, 0.0, 0.0, 0.0)),
        ("j", (0.0, 0.0, 0.0, 1.0)),
        ("l", (0.0, 0.0, 0.0, -1.0)),
        ("u", (0.5, 0.0, 0.0, 1.0)),
        ("o", (0.5, 0.0, 0.0, -1.0)),
        ("m", (-0.5, 0.0, 0.0, -1.0)),
        (".", (-0.5, 0.0, 0.0, 1.0)),
        ("J", (0.0, 0.5, 0.0, 0.0)),
        ("L", (0.0, -0.5, 0.0, 0.0)),
        ("U", (0.5, 0.5, 0.0, 0.0)),
        ("O", (0.5, -0.5, 0.0, 0.0)),
        ("M", (-0.5, 0.5, 0.0, 0.0)),
        (">", (-0.5, -0.5, 0.0, 0.0)),
        ("I", (0.5, 0.0, 0.0, 0.0)),
        ("<", (-0.5, 0.0, 0.0, 0.0)),
        ("t", (0.0, 0.0, 0.5, 0.0)),
        ("b", (0.0, 0.0, -0.5, 0.0)),
        ("ik", (0.0, 0.0, 0.0, 0.0)),
        ("qu", (0.55, 0.0, 0.0, 1.1)),
        ("zu", (0.45, 0.0, 0.0, 0.9)),
        ("wu", (0.55, 0.0, 0.0, 1.0)),
        ("xu", (0.45, 0.0, 0.0, 1.0)),
        ("eu", (0.5, 0.0, 0.0, 1.1)),
        ("cu", (0.5, 0.0, 0.0, 0.9)),
        ("iw", (0.55, 0.0, 0.0, 0.0)),  # going on, faster
    ],
)
def test_keys(keys, velocity):
    state = Keys()
    for key in keys:
        assert state.press(key)
    assert state.velocity == pytest.approx(velocity)


def test_the_limits_hold():
    state = Keys(speed=0.5, yaw_rate=1.0, speed_limit=0.52, yaw_rate_limit=3.0)
    state.press("q")
    assert (state.speed, state.yaw_rate) == pytest.approx((0.52, 1.1))
    assert "speed is at its limit" in state.status() and "turn is" not in state.status()


def test_no_key_in_time_stops_once():
    state = Keys()
    assert not state.press("")
    assert state.press("i") and state.press("")
    assert state.velocity == (0.0, 0.0, 0.0, 0.0)
    assert not state.press("")


def test_an_unknown_key_is_sent_even_at_rest():
    assert Keys().press("k")


def test_no_key_means_two_things():
    assert not set(MOVES) & set(SCALES)


def test_a_terminal_gives_keys_at_once_and_is_left_as_it_was():
    outside, inside = pty.openpty()
    try:
        before = termios.tcgetattr(inside)
        with Terminal(inside) as terminal:
            assert terminal.key(0.01) == ""
            os.write(outside, b"i\x03")
            assert terminal.key(5.0) == "i"
            assert terminal.key(5.0) == "\x03"  # a key, not a signal
            assert termios.tcgetattr(inside)[1] == before[1]
        assert termios.tcgetattr(inside) == before
    finally:
        os.close(outside)
        os.close(inside)


def test_what_is_no_terminal_is_named():
    reading, writing = os.pipe()
    try:
        with pytest.raises(ValueError, match="standard input is not a terminal"):
            Terminal(reading)
    finally:
        os.close(reading)
        os.close(writing)
