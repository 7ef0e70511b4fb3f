"""Parameters of the bridge are checked one by one."""

import math
import os
import subprocess
import sys

import pytest
from bullet_bridge.node import Config, parse_config

from bullet_bridge import node
from bullet_sim import files


def parse(**values):
    return parse_config(values.get)


def test_defaults(monkeypatch):
    for name in list(os.environ):
        if name.startswith("PADDOCK_"):
            monkeypatch.delenv(name)
    assert parse() == Config(world_pace=True)


@pytest.mark.parametrize("pace", ["0.5", "0"])  # 0: as fast as possible
def test_the_pace_of_a_launch_file_that_does_not_pass_it_on(monkeypatch, pace):
    monkeypatch.setenv("PADDOCK_REAL_TIME_FACTOR", pace)
    config = parse()
    assert (config.real_time_factor, config.world_pace) == (float(pace), False)
    assert parse(real_time_factor=2.0).real_time_factor == 2.0
    monkeypatch.setenv("PADDOCK_REAL_TIME_FACTOR", "fast")
    with pytest.raises(ValueError, match="real_time_factor is 'fast'"):
        parse()


WITHOUT_NUMBA = """
import pathlib, sys
sys.modules["numba"] = sys.modules["llvmlite"] = None
from bullet_sim.engine.quickstep import sources
sources.library_path = lambda: pathlib.Path("/nowhere/quickstep.so")
from bullet_sim.errors import SimError
from bullet_bridge.node import make_world, parse_config
try:
    make_world(parse_config(lambda name, default: default))
except SimError as error:
    print(error)
config = parse_config(lambda name, default: {"solver": "bullet"}.get(name, default))
print(type(make_world(config).engine).__name__)
"""


def test_without_numba_nothing_starts_but_what_is_asked_for_by_name():
    environ = {name: value for name, value in os.environ.items() if name != "PADDOCK_SOLVER"}
    told, engine = subprocess.check_output(
        [sys.executable, "-c", WITHOUT_NUMBA], text=True, env=environ
    ).splitlines()
    for words in ("solver 'ode'", "numba", "./run setup", "solver:=bullet"):
        assert words in told
    assert engine == "BulletEngine"


@pytest.mark.parametrize(
    "name, value, field, expected",
    [
        ("world_file", "worlds/empty.world", "world_file", "worlds/empty.world"),
        ("paused", True, "paused", True),
        ("real_time_factor", 0, "real_time_factor", 0.0),
        ("paused", False, "world_pace", True),
        ("real_time_factor", 1.0, "world_pace", False),
        ("real_time_factor", 2.5, "real_time_factor", 2.5),
        ("lockstep", True, "lockstep", True),
        ("every_picture", True, "every_picture", True),
        ("renderer", "tiny", "renderer", "tiny"),
        ("renderer", "gl", "renderer", "gl"),
        ("shadows", "true", "shadows", "true"),
        ("antialias", "false", "antialias", "false"),
        ("pub_clock_frequency", 100, "clock_rate", 100.0),
        ("pub_clock_frequency", 0, "clock_rate", 0.0),
        ("pub_clock_frequency", -1, "clock_rate", 0.0),
        ("pub_states_frequency", 0, "states_rate", 0.0),
        ("pub_states_frequency", 50, "states_rate", 50.0),
        ("seed", 7, "seed", 7),
        ("monotonic_clock", True, "monotonic_clock", True),
        ("missing_packages", "warn", "missing_packages", "warn"),
        ("massless_links", "keep", "massless_links", "keep"),
        ("step_timeout", 2, "step_timeout", 2.0),
        ("niceness", -5, "niceness", -5),
        ("niceness", 0, "niceness", 0),
        ("enable_ros_network", False, "enable_ros_network", False),
    ],
)
def test_good_values(name, value, field, expected):
    assert getattr(parse(**{name: value}), field) == expected


@pytest.mark.parametrize(
    "name, value",
    [
        ("real_time_factor", -1),
        ("real_time_factor", math.nan),
        ("real_time_factor", math.inf),
        ("real_time_factor", "fast"),
        ("real_time_factor", True),
        ("pub_states_frequency", -1),
        ("pub_clock_frequency", None),
        ("pub_clock_frequency", math.nan),
        ("renderer", "ogre"),
        ("renderer", 3),
        ("fixed_joints", "rigid"),
        ("paused", "yes"),
        ("paused", 1),
        ("lockstep", "no"),
        ("monotonic_clock", 0),
        ("step_timeout", -1),
        ("niceness", 1),
        ("niceness", -21),
        ("niceness", "high"),
        ("step_timeout", math.inf),
        ("seed", "x"),
        ("seed", math.nan),
    ],
)
def test_bad_values_are_named(name, value):
    with pytest.raises(ValueError) as error:
        parse(**{name: value})
    assert f"parameter {name} is" in str(error.value) and str(value) in str(error.value)
    assert "must be" in str(error.value)


def test_niceness_of_the_environment_counts_where_no_parameter_is_given(monkeypatch):
    monkeypatch.setenv("PADDOCK_NICENESS", "-3")
    assert parse().niceness == -3 and parse(niceness=-4).niceness == -4
    monkeypatch.setenv("PADDOCK_NICENESS", "often")
    with pytest.raises(ValueError, match="parameter niceness is 'often'; it must be"):
        parse()


def test_limits_of_files_are_parameters_that_other_processes_have_too(monkeypatch):
    monkeypatch.setenv("PADDOCK_MAX_TEXT_BYTES", "4")
    assert parse().max_text_bytes == 4 and parse().max_mesh_bytes == 400_000_000
    assert parse(max_text_bytes=7).max_text_bytes == 7
    monkeypatch.setattr(node, "make_world", lambda config: 1 / 0)
    monkeypatch.setattr(
        node.rospy, "get_param", lambda name, d: {"~max_text_bytes": 5}.get(name, d)
    )
    for name in files.LIMITS:  # which are restored then
        monkeypatch.setenv(files.variable_of(name), "")
    with pytest.raises(ZeroDivisionError):
        node.make_server(None)
    assert os.environ["PADDOCK_MAX_TEXT_BYTES"] == "5"
    monkeypatch.setenv("PADDOCK_MAX_TEXT_BYTES", "many")
    with pytest.raises(ValueError, match="parameter max_text_bytes is 'many'; it must be"):
        parse()


@pytest.mark.parametrize(
    "name, default, other",
    [
        ("missing_packages", "refuse", "warn"),
        ("massless_links", "leave_out", "keep"),
        ("fixed_joints", "keep", "merge"),
    ],
)
def test_choices_of_the_environment_count_where_no_parameter_is_given(
    monkeypatch, name, default, other
):
    assert getattr(parse(), name) == default
    monkeypatch.setenv(f"PADDOCK_{name.upper()}", other)
    assert getattr(parse(), name) == other
    assert getattr(parse(**{name: default}), name) == default


def test_lockstep_starts_paused():
    assert parse(lockstep=True).paused and not parse(lockstep=False).paused


@pytest.mark.parametrize(
    "given, expected", [(None, True), (True, True), (False, False), (0, False), ("true", True)]
)
def test_use_sim_time_is_set_where_nobody_has(monkeypatch, given, expected):
    parameters = {} if given is None else {"/use_sim_time": given}
    for name, function in (
        ("has_param", parameters.__contains__),
        ("set_param", parameters.__setitem__),
        ("get_param", parameters.__getitem__),
    ):
        monkeypatch.setattr(node.rospy, name, function)
    assert node.uses_sim_time() is expected
    assert parameters["/use_sim_time"] == (True if given is None else given)
