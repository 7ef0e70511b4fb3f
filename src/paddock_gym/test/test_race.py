"""DeepRacers that race each other: the environment, its rewards and ends, drivers that pass."""

import numpy as np
import pytest
from paddock_gym.course import LAP
from paddock_gym.envs.race import LOST, RaceEnv
from paddock_gym.errors import GymError
from paddock_gym.evaluation.races import Avoiding, race, wins
from pettingzoo.test import parallel_api_test

STILL, AHEAD = np.array((0.0, -1.0), np.float32), np.array((0.0, 0.0), np.float32)


@pytest.fixture(name="env", scope="module")
def _env():
    """A race of two."""
    env = RaceEnv()
    yield env
    env.close()


def test_three_cars_pass_pettingzoos_test():
    env = RaceEnv(cars=3)
    parallel_api_test(env, num_cycles=40)
    places = [task.car.motion()[:2] for task in env.tasks.values()]
    assert len({tuple(np.round(place, 1)) for place in places}) == 3
    env.close()


def test_the_grid_is_drawn_by_the_seed_and_each_car_sees_the_other(env):
    seen, _ = env.reset(seed=5)
    ahead = {name: row[-3] for name, row in seen.items()}
    assert sorted(ahead.values()) == pytest.approx((-0.2, 0.2), abs=0.02)  # 0.8 m over 4 m
    again, _ = env.reset(seed=5)
    assert all(np.array_equal(seen[name], again[name]) for name in seen)
    first = {tuple(env.reset(seed=seed)[0]["car1"][-3:] > 0.0)[0] for seed in range(8)}
    assert first == {True, False}  # the order varies


def test_what_is_gained_on_the_other_car_counts(env):
    for seed in range(3):
        env.reset(seed=seed)
        total, driven = dict.fromkeys(env.agents, 0.0), 0.0
        before = env.tasks["car1"].rival()[0]
        for _ in range(10):
            _, rewards, *_ = env.step({"car1": AHEAD, "car2": STILL})
            total = {name: total[name] + rewards[name] for name in total}
        gained = before - env.tasks["car1"].rival()[0]
        driven = {name: task.state.distance for name, task in env.tasks.items()}
        assert total["car1"] == pytest.approx(driven["car1"] + 0.5 * gained, abs=1e-6)
        assert total["car1"] + total["car2"] == pytest.approx(sum(driven.values()), abs=0.05)


def test_a_faster_car_passes_and_wins(env):
    drivers = {
        "car1": Avoiding(env.tasks["car1"], max_speed=1.0).act,
        "car2": Avoiding(env.tasks["car2"], max_speed=1.8).act,
    }
    ends = race(env, drivers, 4, seed=10_000)
    assert ends == {"car1": [LOST] * 4, "car2": [LAP] * 4}
    assert wins(ends) == {"car1": 0, "car2": 4}


def test_a_car_that_is_off_the_track_stands_and_the_other_goes_on(env):
    env.reset(seed=3)
    pursuit, ended = Avoiding(env.tasks["car1"]), False
    for _ in range(120):
        actions = {"car1": pursuit.act(), "car2": np.array((1.0, 0.5), np.float32)}
        _, _, terminated, truncated, infos = env.step({name: actions[name] for name in env.agents})
        ended |= terminated.get("car2", False)
    assert ended and env.agents == ["car1"]
    assert abs(env.tasks["car2"].car.motion().forward) < 0.05
    assert env.tasks["car1"].state.distance > 5.0


@pytest.mark.parametrize(
    "options, text",
    [({"cars": 1}, "cars is 1, must be from 2 to 16"), ({"track": "line.yaml"}, "open")],
)
def test_wrong_options_are_named(options, text, tmp_path):
    if "track" in options:
        path = tmp_path / options["track"]
        path.write_text("points: [[0, 0], [3, 0], [6, 0]]\nwidth: 1.0\nclosed: false\n")
        options = {"track": str(path)}
    with pytest.raises(GymError, match=text):
        RaceEnv(**options)
