"""./run check: what is said of what came up, and of what roslaunch wrote."""

import copy
import math

import pytest

from commands.checking import verdict

STATE = {"position": (1.0, 2.0, 0.05), "orientation": (0.0, 0.0, 0.0, 1.0), "speed": 0.0}
GOOD = {
    "simulator": True,
    "world": "default",
    "real_time_factor": 1.0,
    "simulated": 8.0,
    "refused": None,
    "cannot": [],
    "died": [],
    "models": [
        {"name": "ground_plane", "static": True, "sensors": [], "warnings": [],
         "control_namespace": None},
        {
            "name": "car",
            "static": False,
            "control_namespace": "/car",
            "controllers": [["wheels", "velocity_controllers/JointVelocityController", "running"]],
            "sensors": [{"topic": "/scan", "type": "sensor_msgs/LaserScan", "rate": 10.0,
                         "count": 80, "measured": 9.9, "link": "laser"}],
            "warnings": ["a", "a", "b"],
            "before": STATE,
            "after": STATE,
        },
    ],
}  # fmt: skip


def changed(**values):
    """GOOD with other values; those of the car are named car_NAME."""
    found = copy.deepcopy(GOOD)
    for name, value in values.items():
        if name.startswith("car_"):
            found["models"][1][name[4:]] = value
        else:
            found[name] = value
    return found


def state(**values):
    return {**STATE, **values}


def test_nothing_is_wrong():
    assert verdict.problems(GOOD) == []
    page = "\n".join(verdict.page(GOOD, 8.0))
    assert "no problems" in page and "2 x a" in page and "real-time factor 1.00" in page
    for word in ("robot car", "/scan", "9.9 Hz", "wheels", "running"):
        assert word in page


@pytest.mark.parametrize(
    "found, words",
    [
        (changed(refused="no such file"), ["roslaunch refuses", "no such file"]),
        (changed(cannot=[["laser_tools", "merge"]]), ["laser_tools/merge", "cannot start"]),
        (changed(died=[["mux", 1]]), ["node mux died", "1"]),
        (changed(models=[GOOD["models"][0]]), ["no robot"]),
        (changed(car_after=None), ["car", "where it is"]),
        (changed(car_after=state(position=(1.0, 2.4, 0.05))), ["moves by itself", "0.40 m"]),
        (changed(car_after=state(position=(1.0, math.nan, 0.0))), ["car", "not finite"]),
        (
            changed(car_before=state(position=(1, 2, -5.0)), car_after=state(position=(1, 2, -5))),
            ["fallen", "-5.0 m"],
        ),
        (
            changed(car_after=state(orientation=(math.sin(0.5), 0.0, 0.0, math.cos(0.5)))),
            ["tilted", "57 degrees"],
        ),
        (changed(car_controllers=None), ["controller_manager", "/car", "does not answer"]),
        (changed(car_controllers=[]), ["no controller", "spawner"]),
        (changed(car_controllers=[["arm", "x", "stopped"]]), ["arm", "stopped"]),
        (
            changed(car_sensors=[{"topic": "/t", "rate": 30.0, "count": 0, "measured": None}]),
            ["/t", "sends nothing"],
        ),
        (
            changed(car_sensors=[{"topic": "/t", "rate": 30.0, "count": 9, "measured": 12.0}]),
            ["/t", "12.0 of 30 Hz"],
        ),
    ],
)
def test_one_problem_each(found, words):
    (sentence,) = verdict.problems(found)
    assert all(word in sentence for word in words), sentence


def test_without_a_simulator():
    found = {"simulator": False, "refused": None, "cannot": [], "died": []}
    (sentence,) = verdict.problems(found)
    assert "no simulator" in sentence
    assert verdict.page(found, 8.0)[-1].endswith(sentence)


@pytest.mark.parametrize(
    "orientation, degrees",
    [((0, 0, 0, 1), 0.0), ((1, 0, 0, 0), 180.0), ((0, 0, math.sin(0.4), math.cos(0.4)), 0.0)],
)
def test_tilt(orientation, degrees):
    assert verdict.tilt(orientation) == pytest.approx(degrees, abs=1e-6)
