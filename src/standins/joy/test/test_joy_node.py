"""The joystick driver on a fake pad and a fake clock: what is sent, and when."""

import pytest
from joy_node.driver import RETRY_PERIOD, Driver
from joy_node.pad_state import PadState
from joy_node.publish_timer import PublishTimer

REST = ([0.0, 0.0, -1.0], [0, 0], [(0, 0)])  # stick x, stick y, trigger; one hat


class FakePad:
    """A pad whose numbers the test sets."""

    name = "fake pad"

    def __init__(self):
        self.reading, self.there, self.closed = REST, True, 0

    def attached(self):
        """Whether it is still there."""
        return self.there

    def read(self):
        """Numbers."""
        return self.reading

    def close(self):
        """Count it."""
        self.closed += 1


class Bench:
    """A driver with a fake pad and clock."""

    def __init__(self, pad, state=None, **sending):
        self.pad, self.time, self.sent, self.logged, self.opened = pad, 100.0, [], [], 0
        self.driver = Driver(
            self._open,
            state or PadState(),
            PublishTimer(**sending),
            lambda axes, buttons: self.sent.append((list(axes), list(buttons))),
            self.logged.append,
            lambda: self.time,
        )

    def _open(self):
        self.opened += 1
        return self.pad

    def run(self, seconds, period=0.01):
        """Run for some wall time; returns the number of messages."""
        before = len(self.sent)
        for _ in range(round(seconds / period)):
            self.driver.spin_once()
            self.time += period
        return len(self.sent) - before


@pytest.mark.parametrize(
    "raw, deadzone, expected",
    [
        (0.0, 0.05, 0.0),
        (0.04, 0.05, 0.0),
        (-0.05, 0.05, 0.0),
        (1.0, 0.05, -1.0),
        (-1.0, 0.05, 1.0),  # right and down are negative
        (0.525, 0.05, -0.5),
        (-0.525, 0.05, 0.5),
        (0.3, 0.0, -0.3),
        (-1.0001, 0.1, 1.0),
    ],
)
def test_axis(raw, deadzone, expected):
    state = PadState(deadzone, default_trigger=True)
    state.update([raw], [])
    assert state.axes == pytest.approx([expected])
    assert str(state.axes[0]) != "-0.0"


def test_a_trigger_is_0_until_it_is_moved():
    state = PadState()
    state.update(*REST)
    assert state.axes == [0.0, 0.0, 0.0, 0.0, 0.0]
    state.update([0.0, 0.0, -0.5], [0, 0], [(0, 0)])
    assert state.axes[2] == pytest.approx(0.45 / 0.95)
    state.update(*REST)
    assert state.axes[2] == 1.0
    state.clear()
    state.update(*REST)
    assert state.axes[2] == 0.0


def test_default_trig_val_reports_the_rest():
    state = PadState(default_trigger=True)
    state.update(*REST)
    assert state.axes == [0.0, 0.0, 1.0, 0.0, 0.0]


@pytest.mark.parametrize(
    "hat, axes", [((-1, 0), [1, 0]), ((1, 0), [-1, 0]), ((0, 1), [0, 1]), ((0, -1), [0, -1])]
)
def test_hat_is_two_axes_left_and_up_positive(hat, axes):
    state = PadState()
    state.update(*REST)
    state.update(REST[0], REST[1], [hat])
    assert state.axes[3:] == axes


def test_sticky_buttons_toggle_with_each_press():
    state, seen = PadState(sticky_buttons=True), []
    for pressed in (0, 1, 1, 0, 0, 1, 0):
        state.update([], [pressed])
        seen.append(state.buttons[0])
    assert seen == [0, 1, 1, 1, 1, 0, 0]


def test_a_button_is_sent_at_once_an_axis_after_the_interval():
    bench = Bench(FakePad(), coalesce_interval=0.05)
    bench.run(0.1)
    bench.sent.clear()
    bench.pad.reading = ([0.0, 0.0, -1.0], [1, 0], [(0, 0)])
    assert bench.run(0.01) == 1 and bench.sent[-1][1] == [1, 0]
    for way in (0.2, 0.5, 1.0):
        bench.pad.reading = ([way, 0.0, -1.0], [1, 0], [(0, 0)])
        assert bench.run(0.01) == 0
    assert bench.run(0.1) == 1 and bench.sent[-1][0][0] == -1.0


def test_a_button_takes_a_waiting_axis_along():
    bench = Bench(FakePad(), coalesce_interval=0.05)
    bench.run(0.1)
    bench.sent.clear()
    bench.pad.reading = ([-1.0, 0.0, -1.0], [0, 0], [(0, 0)])
    bench.run(0.01)
    bench.pad.reading = ([-1.0, 0.0, -1.0], [0, 1], [(0, 0)])
    assert bench.run(0.2) == 1 and bench.sent[-1] == ([1.0, 0, 0, 0, 0], [0, 1])


def test_autorepeat_is_off_by_default():
    bench = Bench(FakePad())
    bench.run(0.1)
    assert bench.run(2.0) == 0
    bench = Bench(FakePad(), autorepeat_rate=20.0)
    bench.run(0.1)
    assert bench.run(2.0) == pytest.approx(40, abs=2)


def test_unplugging_sends_zeros_once_and_retries():
    bench = Bench(FakePad(), autorepeat_rate=50.0)
    bench.pad.reading = ([0.5, -1.0, 1.0], [1, 1], [(1, 1)])
    bench.run(0.2)
    assert bench.sent[-1][1] == [1, 1]
    bench.sent.clear()
    gone, bench.pad = bench.pad, None
    gone.there = False
    looks = bench.opened
    assert bench.run(4.5 * RETRY_PERIOD) == 1
    assert bench.sent == [([0.0] * 5, [0, 0])] and gone.closed == 1
    assert bench.opened - looks == 4
    bench.pad = FakePad()
    assert bench.run(2.0) > 10 and bench.sent[-1] == ([0.0] * 5, [0, 0])
    assert bench.logged == [
        "joystick 'fake pad'",
        "joystick 'fake pad' is gone; sent zeros",
        "joystick 'fake pad'",
    ]


def test_a_missing_pad_is_logged_once():
    bench = Bench(None)
    assert bench.run(5.0) == 0
    assert len(bench.logged) == 1 and bench.opened == 5


@pytest.mark.parametrize(
    "make, reason",
    [
        (lambda: PadState(1.0), "deadzone is 1.0"),
        (lambda: PadState(-0.1), "deadzone is -0.1"),
        (lambda: PublishTimer(-1.0), "autorepeat_rate is -1.0"),
        (lambda: PublishTimer(0.0, float("nan")), "coalesce_interval is nan"),
        (lambda: PublishTimer(100.0, 0.1), "coalesce_interval is 0.1 s, must be at most 0.01 s"),
    ],
)
def test_bad_parameters_are_named(make, reason):
    with pytest.raises(ValueError, match=reason):
        make()


@pytest.mark.parametrize("device, number", [("/dev/input/js0", 0), ("js3", 3), (1, 1), ("2", 2)])
def test_device_names(device, number):
    from joy_node import sdl_pads

    assert sdl_pads.number_of(device) == number


def test_device_without_a_number_is_refused_and_a_pad_out_of_reach_is_none():
    from joy_node import sdl_pads

    with pytest.raises(ValueError, match="dev is '/dev/input/event'"):
        sdl_pads.number_of("/dev/input/event")
    pads = sdl_pads.SdlPads("/dev/input/js99")
    assert pads.open() is None
    pads.close()


def test_a_link_to_a_device_counts_as_the_device(tmp_path):
    from joy_node import sdl_pads

    link = tmp_path / "usb-pad-joystick"
    link.symlink_to("/dev/input/js4")
    assert sdl_pads.number_of(str(link)) == 4
