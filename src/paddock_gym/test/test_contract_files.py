"""Users' files: what they say, and the sentences about what is wrong in them."""

import json
import math

import pytest
from paddock_gym.contract import actions, hyperparameters
from paddock_gym.contract.params import NO_OBJECTS
from paddock_gym.contract.reward_file import CRASH_REWARD, RewardFile
from paddock_gym.errors import GymError, RewardError

PARAMS = {"is_crashed": False, "speed": 2.0, "waypoints": [(0, 0)] * 3, **NO_OBJECTS}
DISCRETE = {
    "action_space": [
        {"steering_angle": -30, "speed": 0.6, "index": 0},
        {"steering_angle": 0, "speed": 1.2, "index": 1},
        {"steering_angle": 30.0, "speed": 0.6, "index": 2},
    ],
    "sensor": ["FRONT_FACING_CAMERA"],
    "neural_network": "DEEP_CONVOLUTIONAL_NETWORK_SHALLOW",
    "training_algorithm": "clipped_ppo",
    "action_space_type": "discrete",
    "version": "5",
}
CONTINUOUS = {
    "action_space": {
        "steering_angle": {"high": 30, "low": -30},
        "speed": {"high": 4, "low": 1},
    },
    "action_space_type": "continuous",
    "sensor": ["FRONT_FACING_CAMERA"],
}


def written(tmp_path, content, name="file.json"):
    path = tmp_path / name
    path.write_text(content if isinstance(content, str) else json.dumps(content))
    return str(path)


def test_discrete_actions(tmp_path):
    space = actions.parse(written(tmp_path, DISCRETE))
    assert space.command(0) == pytest.approx((0.6, math.radians(-30.0)))
    assert space.command(1) == (1.2, 0.0)
    assert space.action(1.0, 0.01) == 1
    assert actions.parse(actions.table(space)) == space


def test_continuous_actions(tmp_path):
    space = actions.parse(written(tmp_path, CONTINUOUS))
    assert space.command((-1.0, -1.0)) == pytest.approx((1.0, math.radians(-30.0)))
    assert space.command((0.0, 0.0)) == pytest.approx((2.5, 0.0))
    assert space.command((5.0, 1.0)) == pytest.approx((4.0, math.radians(30.0)))
    assert space.command(space.action(1.75, 0.2)) == pytest.approx((1.75, 0.2), abs=1e-6)
    assert actions.parse(actions.table(space)) == space


def changed(table, **items):
    return dict(table, **items)


@pytest.mark.parametrize(
    "content, words",
    [
        ("[1", "is not JSON"),
        ([1], "must be a table"),
        ({}, "action_space is missing"),
        (changed(DISCRETE, action_space=[]), "action_space is []"),
        (changed(DISCRETE, action_space=[{"speed": 1}]), "action_space[0] is {'speed': 1}"),
        (
            changed(DISCRETE, action_space=[{"steering_angle": 31, "speed": 1}]),
            "action_space[0].steering_angle is 31; it must be from -30 to 30 [degrees]",
        ),
        (
            changed(DISCRETE, action_space=[{"steering_angle": 0, "speed": 5}]),
            "action_space[0].speed is 5; it must be from 0.1 to 4 [m/s]",
        ),
        (changed(DISCRETE, sensor=["SONAR"]), "sensor is 'SONAR'"),
        (changed(CONTINUOUS, action_space={"speed": {}}), "action_space.steering_angle is None"),
        (
            changed(
                CONTINUOUS,
                action_space={
                    "steering_angle": {"low": 10, "high": -10},
                    "speed": {"low": 1, "high": 2},
                },
            ),
            "action_space.steering_angle.low is above high",
        ),
        (changed(CONTINUOUS, action_space_type="both"), "action_space_type is 'both'"),
    ],
)
def test_wrong_metadata(tmp_path, content, words):
    path = written(tmp_path, content)
    with pytest.raises(GymError) as error:
        actions.parse(path)
    assert words in str(error.value) and path in str(error.value)


def test_hyperparameters(tmp_path):
    hyper = hyperparameters.load(
        written(
            tmp_path,
            {
                "batch_size": 64,
                "num_epochs": 10,
                "lr": 0.0003,
                "beta_entropy": 0.01,
                "discount_factor": 0.99,
                "loss_type": "mean squared error",
                "num_episodes_between_training": 20,
                "e_greedy_value": 0.05,
                "exploration_type": "categorical",
            },
        )
    )
    assert (hyper.batch_size, hyper.num_epochs, hyper.lr) == (64, 10, 0.0003)
    assert (hyper.beta_entropy, hyper.discount_factor) == (0.01, 0.99)
    assert (hyper.loss_type, hyper.num_episodes_between_training) == ("mse", 20)
    assert hyper.ignored == ("e_greedy_value", "exploration_type")


@pytest.mark.parametrize(
    "content, words",
    [
        ({"batch_size": 4}, "batch_size is 4; it must be from 8 to 4096"),
        ({"batch_size": 64.5}, "batch_size is 64.5; it must be a whole number"),
        ({"lr": "fast"}, "lr is 'fast'"),
        ({"beta_entropy": 1.5}, "beta_entropy is 1.5; it must be from 0 to 1"),
        ({"loss_type": "l1"}, "loss_type is 'l1'; it must be one of huber"),
        ({"learning_rate": 0.1}, "unknown key 'learning_rate'; there are batch_size"),
    ],
)
def test_wrong_hyperparameters(tmp_path, content, words):
    with pytest.raises(GymError) as error:
        hyperparameters.load(written(tmp_path, content))
    assert words in str(error.value)


def reward_of(tmp_path, text):
    return RewardFile(written(tmp_path, text, "reward_function.py"))


def test_a_reward_function_runs(tmp_path):
    file = reward_of(tmp_path, "def reward_function(params):\n    return params['speed'] * 2\n")
    assert file.reward(PARAMS) == 4.0


def test_a_crash_has_a_reward_of_its_own(tmp_path):
    file = reward_of(tmp_path, "def reward_function(params):\n    return 1.0\n")
    assert file.reward(dict(PARAMS, is_crashed=True)) == CRASH_REWARD


def test_an_error_has_its_own_traceback_and_the_params(tmp_path):
    file = reward_of(tmp_path, "def reward_function(params):\n    return 1 / params['nothing']\n")
    with pytest.raises(RewardError) as error:
        file.reward(PARAMS)
    text = str(error.value)
    assert 'reward_function.py", line 2, in reward_function' in text
    assert "KeyError: 'nothing'" in text
    assert "'speed': 2.0" in text and "<3 points>" in text
    assert "reward_file.py" not in text


@pytest.mark.parametrize("value", ["float('nan')", "float('inf')", "None", "'1'"])
def test_a_reward_must_be_a_finite_number(tmp_path, value):
    file = reward_of(tmp_path, f"def reward_function(params):\n    return {value}\n")
    with pytest.raises(RewardError, match="must be a finite number") as error:
        file.reward(PARAMS)
    assert "'speed': 2.0" in str(error.value)


@pytest.mark.parametrize(
    "text, words",
    [
        ("def reward(params):\n    return 1\n", "has no function reward_function"),
        ("import nothing_at_all\n", "No module named 'nothing_at_all'"),
        ("def reward_function(params)\n", "SyntaxError"),
    ],
)
def test_files_that_cannot_be_used(tmp_path, text, words):
    with pytest.raises(GymError, match=words):
        reward_of(tmp_path, text)
