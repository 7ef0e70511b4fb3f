"""Paddock/DeepRacer-v1: Gymnasium's own checks, seeds, starts, ends, options."""

import math
import warnings

import gymnasium
import numpy as np
import pytest
from bullet_sim.pose import Pose
from gymnasium.utils.env_checker import check_env
from paddock_gym.errors import GymError

import paddock_gym

ID = paddock_gym.IDS[0]
STRAIGHT_ON = np.array((0.0, -0.4), np.float32)


def drive(env, seed, count=40, **reset):
    """Observations, rewards of some random actions after a reset."""
    rng = np.random.default_rng(seed)
    observation, _ = env.reset(seed=seed, **reset)
    rows = [observation]
    for _ in range(count):
        action = rng.uniform((-0.6, -1.0), (0.6, 0.0)).astype(np.float32)
        observation, reward, *_ = env.step(action)
        rows.append(np.append(observation, reward))
    return np.concatenate(rows)


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"observation": "lidar", "walls": True, "action": {"action_space": [
            {"steering_angle": -20, "speed": 1.0}, {"steering_angle": 20, "speed": 1.0}]}},
        {"observation": ("state", "camera"), "colour": True, "randomize": True},
        {"race": "object_avoidance"},
    ],
)  # fmt: skip
def test_gymnasiums_check_has_no_complaint(options):
    env = gymnasium.make(ID, render_mode="rgb_array", **options)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        # Debian 13's pygame
        warnings.filterwarnings("ignore", "Your system is avx2 capable")
        warnings.filterwarnings("ignore", ".*pkg_resources")
        check_env(env.unwrapped, skip_render_check=bool(options))
    env.close()


def test_the_same_seed_and_actions_give_the_same_bits(env):
    first = drive(env, 3)
    for seed in (11, 12, 13):
        drive(env, seed, count=17)
    assert (drive(env, 3) == first).all()
    other = gymnasium.make(ID).unwrapped
    assert (drive(other, 3) == first).all()
    assert not (drive(other, 4) == first).all()
    other.close()


def test_noise_and_randomization_follow_the_seed():
    options = {"observation": "lidar", "walls": True, "randomize": True}
    one, two = (gymnasium.make(ID, **options).unwrapped for _ in range(2))
    drive(two, 8)
    first = drive(one, 3)
    assert (drive(two, 3) == first).all()
    assert not (drive(two, 4)[:64] == first[:64]).all()
    one.close(), two.close()


def test_reset_takes_a_start(env):
    env.reset(seed=1, options={"start": 0.25, "lateral": 0.1, "turn": math.radians(5.0)})
    state, length = env.task.state, env.task.course.length
    assert state.s == pytest.approx(0.25 * length, abs=0.02)
    assert state.lateral == pytest.approx(0.1, abs=0.005)
    assert math.degrees(state.heading_error) == pytest.approx(5.0, abs=0.5)
    assert abs(env.task.motion.forward) < 1e-6
    with pytest.raises(GymError, match="reset has 'place'; there are start, lateral and turn"):
        env.reset(options={"place": 1})


def test_a_step_is_a_control_period(env):
    env.reset(seed=1, options={"start": 0.0})
    assert round(env.period / env.world.world.time_step) == 67
    for _ in range(15):
        _, _, terminated, truncated, info = env.step(STRAIGHT_ON)
    assert not (terminated or truncated)
    assert info["time"] == pytest.approx(1.0)
    assert env.world.world.time == pytest.approx(1.0)
    # 1.55 m/s is commanded: the tyres' mu of 0.5 bears 4.9 m/s^2, so 0.32 s and 0.25 m to get there
    assert env.task.motion.forward == pytest.approx(1.55, abs=0.02)
    assert env.task.state.distance == pytest.approx(1.55 - 0.25, abs=0.15)


def test_leaving_the_lane_terminates_with_a_penalty(env):
    env.reset(seed=1, options={"start": 0.0})
    distance = 0.0
    for _ in range(200):
        _, reward, terminated, truncated, info = env.step((1.0, 0.0))
        if terminated:
            break
        assert reward == pytest.approx(env.task.state.gain)
        distance += reward
    assert terminated and not truncated
    assert info["end"] == "off_track"
    assert reward == pytest.approx(env.task.state.gain - 3.0)
    assert distance + reward + 3.0 == pytest.approx(env.task.state.distance)


@pytest.mark.parametrize(
    "time_step, rate, counts",
    [
        (0.001, 20.0, [50, 50, 50]),
        (0.001, 15.0, [67, 66, 67]),
        (0.002, 15.0, [33, 34, 33]),
        (0.005, 100.0, [2, 2, 2]),
    ],
)
def test_actions_take_the_steps_between_multiples_of_the_control_period(time_step, rate, counts):
    env = gymnasium.make(ID, time_step=time_step, control_rate=rate).unwrapped
    assert env.world.world.time_step == time_step
    for seed in (1, 2):  # each run begins alike
        env.reset(seed=seed)
        steps = [0]
        for _ in range(6):
            env.step(STRAIGHT_ON)
            steps.append(env.world.world.step_count)
        assert np.diff(steps).tolist() == 2 * counts
    env.close()


def test_the_step_is_that_of_the_worlds_and_the_circle_that_of_coarser_ones(env):
    """As long as the tires hold; where they slide, it changes by a tenth (docs/learning.md)."""
    assert env.world.world.time_step == 0.001
    assert env.world.world.engine.settings.iterations == 100  # of track.world
    radii = []
    for time_step in (0.001, 0.003):
        env = gymnasium.make(ID, time_step=time_step).unwrapped
        car, world = env.task.car, env.world
        env.reset(seed=1)
        car.drive(1.0, 0.13)
        world.advance(round(2.0 / world.world.time_step))
        motion = car.motion()
        radii.append(math.hypot(motion.forward, motion.leftward) / motion.yaw_rate)
        env.close()
    assert radii[1] == pytest.approx(radii[0], rel=0.005)
    assert radii[0] == pytest.approx(0.164 / math.tan(0.13), rel=0.03)


def test_friction_bounds_how_the_car_pulls_away(env):
    """All four wheels are driven: mu g, until the commanded speed is reached."""
    car = env.task.car
    wheels = [name for name in car.model.rigid_parts if "wheel" in name]
    for mu in (0.35, 0.65, 0.5):  # at last what the URDF has
        for wheel in wheels:
            car.model.body.set_friction(wheel, mu)
        env.reset(seed=1, options={"start": 0.0})
        car.drive(4.0, 0.0)
        env.world.advance(round(0.2 / env.world.world.time_step))
        reached = mu * 9.81 * env.world.world.time
        assert car.motion().forward == pytest.approx(reached, rel=0.03)


def test_boxes_crash():
    env = gymnasium.make(ID, race="object_avoidance").unwrapped
    env.reset(seed=1, options={"start": 0.0})
    assert len(env.task.objects) == 3
    env.world.world.model("boxes0").set_state(Pose((0.8, 0.0, 0.1)))
    ends = []
    while not ends or not ends[-1]:
        _, reward, *_, info = env.step((0.0, -0.8))
        ends.append(info["end"])
    assert ends[-1] == "crashed" and len(ends) > 5
    assert env.task.motion.x == pytest.approx(0.8 - 0.1 - 0.155, abs=0.06)  # box and nose
    assert reward < -2.5
    env.close()


def test_a_users_reward_function_decides(tmp_path):
    path = tmp_path / "reward_function.py"
    path.write_text("def reward_function(params):\n    return params['steps'] * 10.0\n")
    env = gymnasium.make(ID, reward=str(path)).unwrapped
    env.reset(seed=1)
    assert [env.step(STRAIGHT_ON)[1] for _ in range(3)] == [10.0, 20.0, 30.0]
    assert env.task.params()["steps"] == 3
    env.close()


def test_starts_go_round_where_they_are_not_random():
    env = gymnasium.make(ID, randomize=()).unwrapped
    starts = []
    for _ in range(3):
        env.reset(seed=5)
        starts.append(env.task.state.s / env.task.course.length)
    starts[0] -= round(starts[0])  # a lap's end is its start
    assert starts == pytest.approx([0.0, 0.05, 0.10], abs=1e-3)
    env.close()


@pytest.mark.parametrize(
    "options, words",
    [
        ({"observation": "radar"}, "observation is 'radar'; there are state, lidar, camera"),
        ({"observation": ()}, "at least one"),
        ({"race": "drag"}, "race is 'drag'; there are time_trial"),
        ({"randomize": ("weather",)}, "randomize has 'weather'; there are start"),
        ({"time_step": 0.1}, "time_step is 0.1; it must be from 0.0001 to 0.005 [s]"),
        ({"control_rate": 0}, "control_rate is 0; it must be from 1 to 100 [Hz]"),
        ({"reward": "speed"}, "reward is 'speed'; it must be progress, or a Python file"),
        ({"action": "buttons"}, "action is 'buttons'; it must be continuous, or"),
        ({"track": "monza"}, "monza: track is not found"),
        ({"render_mode": "ansi"}, "render_mode is 'ansi'"),
    ],
)
def test_wrong_options_are_named(options, words):
    with pytest.raises(ValueError) as error:
        gymnasium.make(ID, **options)
    assert words in str(error.value)
