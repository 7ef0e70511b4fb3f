"""Environments side by side: each as alone, to the bit; seeds, new starts, errors, memory."""

import subprocess
import sys
import threading

import gymnasium
import numpy as np
import psutil
import pytest
from paddock_gym.envs.worlds import Worlds
from paddock_gym.errors import GymError

import paddock_gym

ID = paddock_gym.IDS[0]
MAX_MEMORY = 10e6  # [bytes] of one more car


def vector(count, **options):
    return gymnasium.make_vec(
        ID, num_envs=count, vectorization_mode="vector_entry_point", **options
    )


def drive(env, actions, **seed):
    """All that an environment returns."""
    results = [env.reset(**seed)]
    for row in actions:
        results.append(env.step(row))
    return results


def same(one, other):
    """Whether results are equal to the bit, whatever is in them."""
    if isinstance(one, (tuple, list)):
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(same(one[key], other[key]) for key in one)
    return type(one) is type(other) and bool(np.all(np.asarray(one) == np.asarray(other)))


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"observation": "lidar", "walls": True, "randomize": True},
        {"observation": ("state", "camera"), "race": "object_avoidance"},
    ],
)
def test_each_drives_as_alone(options):
    """From start to start: as SyncVectorEnv, which has environments alone, one after the other."""
    count = 3
    rng = np.random.default_rng(1)
    actions = rng.uniform((-1.0, -1.0), (1.0, 1.0), (45, count, 2)).astype(np.float32)
    together, alone = (
        vector(count, **options),
        gymnasium.make_vec(ID, num_envs=count, vectorization_mode="sync", **options),
    )
    assert together.single_observation_space == alone.single_observation_space
    results, expected = drive(together, actions, seed=7), drive(alone, actions, seed=7)
    for number, (one, other) in enumerate(zip(results, expected)):
        assert same(one, other), f"result {number}"
    assert sum(np.count_nonzero(result[2] | result[3]) for result in results[1:]) >= 2  # new starts
    together.close(), alone.close()


def test_a_run_that_has_ended_starts_anew():
    env = vector(2)
    env.reset(seed=3)
    over, ends = np.zeros(2, bool), 0
    for _ in range(120):
        before = over
        observation, rewards, terminated, truncated, infos = env.step(
            np.array([[1, 0], [0, -1]], "f")
        )
        over = terminated | truncated
        for number in np.flatnonzero(before):
            assert rewards[number] == 0.0 and not over[number]
            assert infos["progress"][number] == 0.0 and infos["end"][number] == ""
            assert abs(observation[number][3]) < 1e-6  # at rest
        ends += np.count_nonzero(over)
    assert ends >= 3
    env.close()


def test_a_run_is_truncated_after_as_many_actions_as_asked_for():
    env = vector(2, max_episode_steps=3)
    env.reset(seed=3)
    truncated = [env.step(np.full((2, 2), (0.0, -0.8), "f"))[3].tolist() for _ in range(5)]
    assert truncated == [[False, False]] * 2 + [[True, True]] + [[False, False]] * 2
    env.close()


def test_seeds_and_starts():
    env = vector(3, randomize=())
    first, _ = env.reset(seed=[5, None, 5])
    assert (first[0] == first[2]).all()
    again, _ = env.reset(options={"start": 0.5})
    assert (again[0] == again[1]).all() and not (again[0] == first[0]).all()
    with pytest.raises(GymError, match="seed has 2 numbers; it must be one, or 3"):
        env.reset(seed=[1, 2])
    with pytest.raises(GymError, match="reset has 'place'"):
        env.reset(options={"place": 1})
    env.reset(seed=1)  # an error leaves it usable
    env.close()


@pytest.mark.parametrize(
    "options, words",
    [({"render_mode": "human"}, "several cars have rgb_array"), ({"race": "drag"}, "race is")],
)
def test_wrong_options(options, words):
    before = threading.active_count()
    with pytest.raises(GymError, match=words):
        vector(2, **options)
    assert threading.active_count() == before


def test_images_of_each():
    env = vector(2, render_mode="rgb_array")
    env.reset(seed=1)
    assert [image.shape for image in env.render()] == [(360, 480, 3)] * 2
    env.close()


def test_each_thread_has_its_own_environments():
    made = {}

    class Env(gymnasium.Env):
        def __init__(self, index):
            self.index = made[index] = threading.get_ident()

        def reset(self, **_):
            return threading.get_ident(), {}

        def close(self):
            assert threading.get_ident() == self.index

    worlds = Worlds([lambda index=index: Env(index) for index in range(5)], threads=2)
    assert len(set(made.values())) == 2 and threading.get_ident() not in made.values()
    observations = worlds.map(lambda index: worlds.envs[index].reset()[0])
    assert observations == [made[index] for index in range(5)]
    with pytest.raises(ZeroDivisionError):
        worlds.map(lambda index: 1 // (index - 3))
    assert worlds.map(lambda index: 2 * index) == [0, 2, 4, 6, 8]
    worlds.close()


@pytest.mark.parametrize("end", ["", "import atexit; atexit.register(env.close)", "env.close()"])
def test_what_is_not_closed_ends_with_python_without_a_word(end):
    text = "import gymnasium, paddock_gym\n"
    text += "env = gymnasium.make_vec(paddock_gym.IDS[0], num_envs=2)\n"
    text += f"env.reset(seed=1)\n{end}\nprint('done')"
    process = subprocess.run(
        [sys.executable, "-c", text], capture_output=True, text=True, timeout=100, check=False
    )
    assert (process.returncode, process.stdout, process.stderr) == (0, "done\n", "")


def test_memory_of_one_more_car():
    first, more = vector(2), 4
    drive(first, np.zeros((3, 2, 2), np.float32), seed=1)
    before = psutil.Process().memory_info().rss
    second = vector(more)
    drive(second, np.zeros((3, more, 2), np.float32), seed=1)
    grown = (psutil.Process().memory_info().rss - before) / more
    first.close(), second.close()
    assert grown < MAX_MEMORY, f"{grown / 1e6:.1f} MB"


def test_images_are_rendered_in_the_thread_that_asks_for_them():
    text = "import pathlib, gymnasium, paddock_gym\n"
    text += "env = gymnasium.make(paddock_gym.IDS[0], observation='camera')\n"
    text += "env.reset(seed=1)\n"
    text += "print(*(f.read_text() for f in pathlib.Path('/proc/self/task').glob('*/comm')))"
    process = subprocess.run(
        [sys.executable, "-c", text], capture_output=True, text=True, timeout=100, check=True
    )
    assert "llvmpipe" not in process.stdout, process.stdout
