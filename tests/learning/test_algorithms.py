"""PPO, SAC and TD3 of stable-baselines3 learn on the environments, both unmodified."""

from pathlib import Path

import gymnasium
import numpy as np
import pytest
import torch
from stable_baselines3 import PPO, SAC, TD3
from stable_baselines3.common.noise import NormalActionNoise

import paddock_gym

CART = Path(__file__).resolve().parents[2] / "src" / "paddock_gym" / "examples" / "cart.urdf"
STARTS, UNSEEN = 10, 1000  # of the evaluation; seed of its first
GOOD = 8  # of them
ROUND, MOST = 2048, 20_000  # actions between evaluations, in all
# TD3 explores by nothing but noise, so it begins with actions by chance. SAC's coefficient of
# entropy starts at 1, which 2,300 actions halve: beside rewards of at most 0.15 an action it would
# learn nothing for the first 10,000.
NEEDED = {
    PPO: {},
    SAC: {"ent_coef": "auto_0.1"},
    TD3: {"action_noise": NormalActionNoise(np.zeros(2), np.full(2, 0.5)), "learning_starts": 1000},
}
pytestmark = pytest.mark.timeout(1800)


def car():
    return gymnasium.make(paddock_gym.IDS[0])


def cart():
    """The cart that is to reach a goal on an empty plane."""
    return gymnasium.make(
        paddock_gym.ROBOT,
        urdf=str(CART),
        pose=(0.0, 0.0, 0.1, 0.0, 0.0, 0.0),
        observation=("scan",),
        action="cmd_vel",
        limits={"cmd_vel": ((0.0, -1.5), (0.8, 1.5))},
        scaled=True,
        task="goal",
        task_options={"obstacles": 0},
        control_rate=5,
        max_episode_steps=150,
    )


def ends(env, act):
    """How runs from starts that no training knows end."""
    found = []
    for number in range(STARTS):
        (seen, _), over = env.reset(seed=UNSEEN + number), False
        while not over:
            seen, _, terminated, truncated, info = env.step(act(seen))
            over = terminated or truncated
        found.append(info["end"])
    return found


@pytest.mark.parametrize("algorithm", NEEDED)
@pytest.mark.parametrize("make, good", [(car, "lap"), (cart, "reached")])
def test_an_algorithm_learns(algorithm, make, good):
    torch.set_num_threads(1)  # small networks are fastest so
    env = make()
    env.action_space.seed(0)
    by_chance = ends(env, lambda _: env.action_space.sample())
    assert by_chance.count(good) <= 2
    kind = "MlpPolicy" if make is car else "MultiInputPolicy"
    model, learned = algorithm(kind, env, seed=0, device="cpu", **NEEDED[algorithm]), []
    while learned.count(good) < GOOD and model.num_timesteps < MOST:
        model.learn(ROUND, reset_num_timesteps=False)
        learned = ends(env, lambda seen: model.predict(seen, deterministic=True)[0])
    env.close()
    assert learned.count(good) >= GOOD, learned
