"""Paddock/CyberTruckBacking-v1: checks, seeds, ends, and the tracker as its baseline."""

import math
import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from networks import describe, write
from paddock_gym.contract.actions import Continuous
from paddock_gym.errors import GymError
from paddock_gym.evaluation import backing
from paddock_gym.evaluation.backing import TrackerDriver
from paddock_gym.evaluation.cli import evaluate

import paddock_gym

ID = paddock_gym.IDS[1]


@pytest.fixture(scope="module")
def env():
    made = gymnasium.make(ID).unwrapped
    yield made
    made.close()


def drive(env, driver=None, **reset):
    """All lateral errors [m] and the last info of a run."""
    observation, _ = env.reset(**reset)
    lateral, done, driver = [], False, driver or TrackerDriver()
    while not done:
        observation, _, terminated, truncated, info = env.step(driver.act(observation, env))
        done = terminated or truncated
        lateral.append(info["lateral"])
    return np.array(lateral), info


def test_gymnasiums_check_has_no_complaint(env):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env, skip_render_check=True)


def test_the_same_seed_gives_the_same_bits(env):
    def run():
        observation, _ = env.reset(seed=5)
        rows = [observation]
        for number in range(15):
            rows.append(env.step((0.3 * math.sin(number), -1.0))[0])
        return np.array(rows)

    first = run()
    env.reset(seed=9)
    env.step((1.0, 1.0))
    assert (run() == first).all()


def test_the_tracker_arrives(env):
    lateral, info = drive(env, seed=0)
    assert info["end"] == "arrived" and info["progress"] == pytest.approx(100.0, abs=1.0)
    assert abs(info["lateral"]) < 0.03 and abs(info["heading"]) < math.radians(3.0)
    assert np.abs(lateral).max() < 0.3


def test_named_paths():
    env = gymnasium.make(ID, path="park").unwrapped
    env.reset(seed=1, options={"lateral": 0.1, "turn": 0.0, "hitch": 0.1})
    assert env.task.lateral == pytest.approx(0.1, abs=0.01)
    assert env.task.hitch == pytest.approx(0.1, abs=0.01)
    ends = env.task.path.sample(env.task.path.length)
    assert float(ends[0]) < -4.0 and float(ends[1]) == pytest.approx(1.2, abs=0.01)
    env.close()


def test_an_angle_too_far_ends_a_run(env):
    env.reset(seed=1, options={"lateral": 0.0, "turn": 0.0, "hitch": 0.3})
    for _ in range(100):
        _, reward, terminated, truncated, info = env.step((1.0, -1.0))
        if terminated:
            break
    assert info["end"] in ("jackknifed", "lost") and not truncated
    assert reward < -0.9


def test_wrong_options():
    with pytest.raises(GymError, match="path is 'loop'; there are line, arc"):
        gymnasium.make(ID, path="loop")


def test_a_policy_and_the_tracker_from_the_same_unseen_starts(tmp_path):
    about = describe(chosen=Continuous((-35.0, 35.0), (-0.4, 0.4)), env="backing")
    policy = write(tmp_path / "policy.onnx", np.zeros((2, 11)), (2.0, -2.0), about, (11,))
    rows = evaluate(policy, [], 2, None, str(tmp_path / "out"))
    assert [row["driver"] for row in rows] == ["policy", "tracker"]
    turning, tracker = rows
    assert turning["arrived"] == 0 and set(turning["other_ends"]) <= {"jackknifed", "lost"}
    assert tracker["arrived"] == tracker["starts"] == 2 and not tracker["other_ends"]
    assert max(tracker["end_lateral"]) < 0.03 and min(tracker["times"]) > 5.0  # [m], [s]
    cells = backing.lines(rows)
    assert cells[1][:3] == ("policy", "0 of 2", "-") and cells[2][1] == "2 of 2"
    with pytest.raises(GymError, match="track is 'easy'; a policy for backing has no track"):
        evaluate(policy, ["easy"], 2, None, str(tmp_path / "out"))
