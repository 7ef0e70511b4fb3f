"""Policies from ONNX files, and drivers in the environment."""

import math
import sys

import gymnasium
import numpy as np
import pytest
from networks import describe, lane_keeper, write
from paddock_gym.contract.actions import Continuous, Discrete
from paddock_gym.envs.deepracer import DeepRacerEnv
from paddock_gym.errors import GymError
from paddock_gym.evaluation import laps
from paddock_gym.evaluation.laps import PolicyDriver, PursuitDriver
from paddock_gym.observations import Assembler
from paddock_gym.policy.description import PolicyDescription
from paddock_gym.policy.onnx_policy import OnnxPolicy
from track_model.referee.course import standing_start

import paddock_gym
from paddock_gym import observations


def test_a_network_of_known_numbers(tmp_path):
    rng = np.random.default_rng(1)
    weights, bias = rng.normal(size=(2, 14)), rng.normal(size=2)
    policy = OnnxPolicy(write(tmp_path / "policy.onnx", weights, bias, describe()))
    observation = rng.normal(size=14).astype(np.float32)
    expected = np.tanh(weights @ observation + bias)
    assert policy.act(observation) == pytest.approx(expected, abs=1e-5)
    assert policy.act({"state": observation}) == pytest.approx(expected, abs=1e-5)
    speed = 0.5 + 3.5 * (expected[1] + 1.0) / 2.0
    assert policy.command(observation) == pytest.approx(
        (speed, math.radians(30.0) * expected[0]), abs=1e-4
    )


def test_discrete_actions(tmp_path):
    chosen = Discrete(((-30.0, 1.0), (0.0, 2.0), (30.0, 1.0)))
    weights = np.zeros((3, 14))
    weights[1, 0], weights[2, 1] = 1.0, 2.0
    path = write(tmp_path / "policy.onnx", weights, (0.0, 0.0, 0.0), describe(chosen=chosen))
    policy = OnnxPolicy(path)
    observation = np.zeros(14, np.float32)
    assert policy.act(observation) == 0
    observation[0] = 1.0
    assert policy.act(observation) == 1 and policy.command(observation) == (2.0, 0.0)
    observation[1] = 1.0
    assert policy.act(observation) == 2


def test_a_description_survives_its_file():
    about = describe(observation="lidar", race="head_to_bot", track="hard")
    assert PolicyDescription.of_text(about.text()) == about


def test_files_that_are_no_policies(tmp_path):
    with pytest.raises(GymError, match="there is no such file"):
        OnnxPolicy(str(tmp_path / "nothing.onnx"))
    (tmp_path / "text.onnx").write_text("hello")
    with pytest.raises(GymError, match="is not an ONNX file that can be run"):
        OnnxPolicy(str(tmp_path / "text.onnx"))
    with pytest.raises(GymError, match="is not one of Paddock's"):
        PolicyDescription.of_text('{"observations": ["state"]}')


def test_without_onnxruntime_a_policy_says_how_to_install_it(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "onnxruntime", None)
    (tmp_path / "policy.onnx").write_bytes(b"")
    with pytest.raises(GymError, match="onnxruntime.* is not installed: ./run setup --with gym"):
        OnnxPolicy(str(tmp_path / "policy.onnx"))


def test_the_gym_and_a_robot_get_the_same_action(tmp_path, env):
    driver = PolicyDriver(lane_keeper(tmp_path / "policy.onnx"))
    assembler = Assembler(("state",), course=env.task.course)
    observation, _ = env.reset(seed=4)
    last = (0.0, 0.0)
    for _ in range(30):
        assembler.set_motion(env.task.motion)
        commands = [driver.policy.command(seen) for seen in (observation, assembler.observe(last))]
        assert commands[0] == commands[1]
        last = commands[0]
        observation, *_ = env.step(driver.act(observation, env))


@pytest.mark.parametrize("kind", ["policy", "pursuit"])
def test_a_driver_makes_its_lap(tmp_path, env, kind):
    driver = (
        PursuitDriver(1.5) if kind == "pursuit" else PolicyDriver(lane_keeper(tmp_path / "p.onnx"))
    )
    lap = laps.drive(env, driver, laps.starts(2)[1])
    assert lap.end == "lap" and lap.is_lap and lap.progress == 100.0
    length = env.task.course.length
    assert lap.time == pytest.approx(length / np.mean(lap.trajectory[:, 2]), rel=0.05)
    assert lap.rms_lateral < 0.2 and lap.max_lateral < 0.38
    assert len(lap.trajectory) == round(15 * lap.time)


def test_starts_are_the_same_for_every_driver():
    assert laps.starts(5) == laps.starts(5) != laps.starts(5, seed=1)
    assert len({start["start"] for start in laps.starts(10)}) == 10


def test_the_registered_limit_of_steps():
    assert gymnasium.spec(paddock_gym.IDS[0]).max_episode_steps == paddock_gym.MAX_STEPS


def test_a_policy_of_another_environment_is_refused(tmp_path):
    about = describe(chosen=Continuous((-35.0, 35.0), (-0.4, 0.4)), env="backing")
    assert PolicyDescription.of_text(about.text()) == about
    path = write(tmp_path / "policy.onnx", np.zeros((2, 11)), (0.0, -1.0), about, (11,))
    with pytest.raises(GymError, match="was trained on backing; it must be of deepracer"):
        OnnxPolicy(path)
    assert OnnxPolicy(path, "backing").command(np.zeros(11, np.float32))[0] < -0.3  # [m/s]


@pytest.mark.parametrize("track", ["default", "straight"])
def test_a_lap_from_line_to_line_is_timed_by_the_referee(tmp_path, track, straight):
    env = DeepRacerEnv(straight if track == "straight" else track, randomize=())
    driver = PolicyDriver(lane_keeper(tmp_path / "policy.onnx"))
    lap_time = laps.line_to_line(env, driver)
    course, period = env.task.course, env.period
    s = [standing_start(course)]
    observation, _ = env.reset(options={"start": s[0] / course.length})
    while s[-1] < course.length:  # also on after the run's end, which is before the line
        observation, *_ = env.step(driver.act(observation, env))
        s.append(s[-1] + env.task.state.gain)
    times = period * np.arange(len(s))
    begin = np.interp(0.0, s, times) if course.closed else 0.0
    assert lap_time == pytest.approx(np.interp(course.length, s, times) - begin, abs=0.1 * period)
    env.close()


def test_no_lap_has_no_time(tmp_path):
    env = DeepRacerEnv(randomize=())
    weights = np.zeros((2, observations.STATE_SHAPE[0]))
    path = write(tmp_path / "policy.onnx", weights, (0.0, 1.0), describe())
    assert laps.line_to_line(env, PolicyDriver(path)) is None  # it goes straight on
    env.close()
