"""Parameters and the monitor of the ROS master."""

import math

import pytest
from deepracer_teleop.window.settings import Settings
from deepracer_teleop.window.status import master_problem, run_id
from paddock_common.master import ERRORS, MasterMonitor
from paddock_common.settings import read


def test_defaults_are_the_originals():
    settings = read(Settings, lambda _name, default: default)
    assert settings == Settings()
    assert (settings.default_speed, settings.default_angular_speed) == (10, 5)
    assert (settings.linear_wait, settings.turn_wait) == (1.0, 0.8)


def test_parameters_are_private():
    values = {"~default_speed": 0.3, "~angular_sign": -1}
    settings = read(Settings, lambda name, default: values.get(name, default))
    assert (settings.default_speed, settings.angular_sign) == (0.3, -1)
    assert settings.slider_to_angular(20) == -2.0


@pytest.mark.parametrize(
    "key, value",
    [
        ("default_speed", "fast"),
        ("default_speed", math.nan),
        ("slider_scale", 0),
        ("turn_wait", -1),
        ("angular_sign", 2),
        ("slider_limit", 10.5),
        ("repeat_rate", True),
    ],
)
def test_invalid_values_are_named(key, value):
    with pytest.raises(ValueError, match=f"{key} is {value!r}"):
        Settings(**{key: value})


@pytest.mark.parametrize("uri", ["http://127.0.0.1:9", "http://no-such-host.invalid:11311"])
def test_no_master_is_no_id(uri):
    with pytest.raises(ERRORS):
        run_id(uri, timeout=0.5)


def test_a_master_that_is_unavailable_and_returns():
    now, responses = [0.0], ["a"]

    def identity(_uri):
        if responses[0] is None:
            raise TimeoutError
        return responses[0]

    monitor = MasterMonitor("http://x:1", identity, now=lambda: now[0])
    monitor.check()
    assert master_problem(monitor, 3.0) == ""
    now[0], responses[0] = 4.0, None
    monitor.check()
    assert "http://x:1 has not responded for 4 s" in master_problem(monitor, 3.0)
    responses[0] = "a"
    monitor.check()
    assert master_problem(monitor, 3.0) == ""
    responses[0] = "b"
    monitor.check()
    assert "Another ROS master" in master_problem(monitor, 3.0)
