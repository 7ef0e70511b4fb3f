"""paddock_navigation's parameters: what DWA and teb may command to what steers like a car.

The rules are those of dwa_local_planner: a command's speed is one that acc_lim_x reaches within a
period of the controller; a command below both min_vel_trans and min_vel_theta is none. teb keeps
min_turning_radius by a penalty only, and the footprint min_obstacle_dist from a line.
"""

import math
import os
import subprocess

import pytest
import yaml

from commands.paths import SOURCES

CIRCLES = {"car": 0.28, "truck": 0.51}  # [m] of the sharpest turn that it drives
STANDING = 0.0


def read(vehicle, name):
    """Reads a file of a vehicle's parameters."""
    path = os.path.join(SOURCES, "paddock_navigation", "config", vehicle, f"{name}.yaml")
    with open(path, encoding="utf-8") as stream:
        return yaml.safe_load(stream)


def planner(vehicle):
    """Reads the parameters of DWA and the period of the controller [s]."""
    period = 1.0 / read(vehicle, "move_base")["controller_frequency"]
    return read(vehicle, "dwa")["DWAPlannerROS"], period


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


@pytest.mark.parametrize("vehicle", sorted(CIRCLES))
@pytest.mark.parametrize("name", ["dwa", "teb"])
def test_a_planner_has_the_parameters_of_its_name(vehicle, name):
    given = read(vehicle, name)
    package, _, kind = given.pop("base_local_planner").partition("/")
    assert package == f"{name}_local_planner"
    assert list(given) == [kind]
    assert not {"base_local_planner", kind} & set(read(vehicle, "move_base"))


@pytest.mark.parametrize("vehicle", sorted(CIRCLES))
def test_teb_commands_turns_that_the_vehicle_drives_both_ways(vehicle):
    teb = read(vehicle, "teb")["TebLocalPlannerROS"]
    assert teb["min_turning_radius"] >= 1.2 * CIRCLES[vehicle]
    assert teb["cmd_angle_instead_rotvel"] is False  # their /cmd_vel has a yaw rate
    assert teb["allow_init_with_backwards_motion"] is True
    assert teb["max_vel_x_backwards"] > 0.0


@pytest.mark.parametrize("vehicle", sorted(CIRCLES))
def test_what_teb_keeps_free_is_the_footprint_of_the_costmaps(vehicle):
    teb, given = read(vehicle, "teb")["TebLocalPlannerROS"], read(vehicle, "costmap")
    (begin, _), (end, _) = (teb["footprint_model"][name] for name in ("line_start", "line_end"))
    for x, y in given["footprint"]:
        beside = max(begin - x, 0.0, x - end)
        assert math.hypot(beside, y) <= teb["min_obstacle_dist"]


@pytest.mark.parametrize(
    "built, said, planner", [(False, None, ""), (True, None, "teb"), (True, "dwa", "dwa")]
)
def test_teb_is_taken_where_it_is_built(tmp_path, built, said, planner):
    library = tmp_path / "devel" / "lib" / "libteb_local_planner.so"
    library.parent.mkdir(parents=True)
    if built:
        library.touch()
    hook = os.path.join(SOURCES, "paddock_navigation", "env-hooks", "10.planner.sh")
    environ = {"PATH": os.environ["PATH"], "CMAKE_PREFIX_PATH": f"/nowhere:{tmp_path}/devel"}
    if said:
        environ["PADDOCK_PLANNER"] = said
    words = ["sh", "-euc", f'. "{hook}"; printf %s "${{PADDOCK_PLANNER:-}}"']
    assert subprocess.run(words, env=environ, capture_output=True, text=True).stdout == planner
