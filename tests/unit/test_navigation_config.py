"""paddock_navigation's parameters: what DWA may command to a vehicle that steers like a car.

The rules are those of dwa_local_planner: a command's speed is one that acc_lim_x reaches within a
period of the controller; a command below both min_vel_trans and min_vel_theta is none.
"""

import os

import pytest
import yaml

from commands.paths import SOURCES

CIRCLES = {"car": 0.28, "truck": 0.51}  # [m] of the sharpest turn that it drives
STANDING = 0.0


def planner(vehicle):
    """Reads the parameters of DWA and the period of the controller [s]."""
    path = os.path.join(SOURCES, "paddock_navigation", "config", vehicle, "move_base.yaml")
    with open(path, encoding="utf-8") as stream:
        given = yaml.safe_load(stream)
    return given["DWAPlannerROS"], 1.0 / given["controller_frequency"]


def speeds(vehicle, now):
    """Lists speeds [m/s] that DWA may command along at the sharpest turn, in steps of 0.01 m/s.

    Args:
        now: What the vehicle drives [m/s].
    """
    dwa, period = planner(vehicle)
    reach = dwa["acc_lim_x"] * period
    low, high = max(dwa["min_vel_x"], now - reach), min(dwa["max_vel_x"], now + reach)
    slow_is_none = dwa["min_vel_theta"] > dwa["max_vel_theta"]
    steps = [round(0.01 * step, 2) for step in range(-100, 101)]
    return [
        speed
        for speed in steps
        if low - 1e-9 <= speed <= high + 1e-9
        and not (slow_is_none and abs(speed) < dwa["min_vel_trans"])
    ]


@pytest.mark.parametrize("vehicle", sorted(CIRCLES))
def test_no_command_is_sharper_than_the_vehicle_turns(vehicle):
    dwa, _ = planner(vehicle)
    for now in (STANDING, 0.2, dwa["max_vel_x"]):
        offered = speeds(vehicle, now)
        assert offered
        assert min(map(abs, offered)) / dwa["max_vel_theta"] > CIRCLES[vehicle]


@pytest.mark.parametrize("vehicle", sorted(CIRCLES))
def test_it_backs_up_from_rest_and_never_changes_direction_while_it_drives(vehicle):
    """Forward alone the truck drove straight away from a goal behind it; free to change, it did so
    without end beside a goal."""
    dwa, _ = planner(vehicle)
    assert min(speeds(vehicle, STANDING)) < 0.0 < max(speeds(vehicle, STANDING))
    for now in (dwa["min_vel_trans"], dwa["max_vel_x"]):
        assert min(speeds(vehicle, now)) > 0.0
    assert max(speeds(vehicle, dwa["min_vel_x"])) < 0.0
