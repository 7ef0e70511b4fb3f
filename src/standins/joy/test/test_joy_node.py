"""The joystick driver on a fake pad and a fake clock: what is sent, and when."""

import types

import pytest
from joy_node import node
from joy_node.node import RETRY_PERIOD, Driver, PadState, PublishTimer

REST = ([0.0, 0.0, -1.0], [0, 0], [(0, 0)])  # stick x, stick y, trigger; one hat


class FakePad:
    """A pad whose numbers the test sets."""

    name = "fake pad"

    def __init__(self):
        self.reading, self.there, self.closed = REST, True, 0

    def attached(self):
        return self.there

    def read(self):
        return self.reading

    def close(self):
        self.closed += 1


class Bench:
    def __init__(self, pad, state=None, **sending):
        self.pad, self.time, self.sent, self.logged, self.attempts = pad, 100.0, [], [], 0
        self.driver = Driver(
            self._open,
            state or PadState(),
            PublishTimer(**sending),
            lambda axes, buttons: self.sent.append((list(axes), list(buttons))),
            self.logged.append,
            lambda text: self.logged.append(f"WARN {text}"),
            lambda: self.time,
            "the joystick js0",
        )

    def _open(self):
        self.attempts += 1
        return self.pad

    def run(self, seconds, period=0.01):
        """Turns for some wall time; how many messages came."""
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


def test_nothing_new_is_not_repeated_unless_wished():
    bench = Bench(FakePad())
    bench.run(0.1)
    assert bench.run(2.0) == 0
    bench = Bench(FakePad(), autorepeat_rate=20.0)
    bench.run(0.1)
    assert bench.run(2.0) == pytest.approx(40, abs=2)


def test_unplugged_sends_zeros_once_and_looks_again():
    bench = Bench(FakePad(), autorepeat_rate=50.0)
    bench.pad.reading = ([0.5, -1.0, 1.0], [1, 1], [(1, 1)])
    bench.run(0.2)
    assert bench.sent[-1][1] == [1, 1]
    bench.sent.clear()
    removed, bench.pad = bench.pad, None
    removed.there = False
    attempts = bench.attempts
    assert bench.run(4.5 * RETRY_PERIOD) == 1
    assert bench.sent == [([0.0] * 5, [0, 0])] and removed.closed == 1
    assert bench.attempts - attempts == 4
    bench.pad = FakePad()
    assert bench.run(2.0) > 10 and bench.sent[-1] == ([0.0] * 5, [0, 0])
    assert bench.logged == [
        "joystick 'fake pad'",
        "WARN joystick 'fake pad' is disconnected; sent zeros; waiting for the joystick js0, "
        "checking every 1 s",
        "joystick 'fake pad'",
    ]


def test_a_missing_pad_is_logged_once_and_checked_for_each_second():
    bench = Bench(None)
    assert bench.run(5.0) == 0
    assert bench.logged == ["WARN waiting for the joystick js0, checking every 1 s"]
    assert bench.attempts == 5
    bench.pad = FakePad()
    assert bench.run(1.5) == 1
    assert bench.logged[1:] == ["joystick 'fake pad'"]


def test_the_node_reads_a_pad_often_and_looks_for_one_rarely(monkeypatch):
    found, slept = [False, True, False], []
    driver = types.SimpleNamespace(spin_once=lambda: found[len(slept)], close=lambda: None)
    monkeypatch.setattr(node.nodes, "start", lambda *_: (driver, driver))
    monkeypatch.setattr(node.rospy, "is_shutdown", lambda: len(slept) == len(found))
    monkeypatch.setattr(node.time, "sleep", slept.append)
    node.main()
    assert slept == [node.IDLE_PERIOD, node.POLL_PERIOD, node.IDLE_PERIOD]
    assert node.POLL_PERIOD < node.IDLE_PERIOD


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

    assert sdl_pads.index_of(device) == number


@pytest.mark.parametrize("device", ["/dev/input/js99", "/dev/input/my_pad", "pad"])
def test_a_device_that_is_not_there_is_waited_for(device):
    from joy_node import sdl_pads

    pads = sdl_pads.SdlPads(device)
    assert pads.open() is None
    assert pads.label == f"the joystick {device}"
    pads.close()
    assert sdl_pads.SdlPads(device, "Wireless").label == "a joystick named 'Wireless'"


def test_a_link_to_a_device_counts_as_the_device(tmp_path):
    from joy_node import sdl_pads

    link = tmp_path / "usb-pad-joystick"
    assert sdl_pads.index_of(str(link)) is None  # its pad is not there yet
    link.symlink_to("/dev/input/js4")
    assert sdl_pads.index_of(str(link)) == 4
