"""What actors collect, without Ray: the same as stable-baselines3 does step by step."""

import numpy as np
import pytest
import torch
from gymnasium.wrappers import TimeLimit
from paddock_gym.training import ray_actors
from paddock_gym.training.ray_actors import Actor, Collector, RayPPO
from paddock_gym.training.worker import LOST, Parcel, environment
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import DummyVecEnv

STEPS, LONGEST = 192, 40
NETWORK = {"n_steps": STEPS, "batch_size": 64, "seed": 7, "device": "cpu"}
PARTS = ("observations", "actions", "rewards", "episode_starts", "values", "log_probs", "returns")


def made():
    """An environment whose runs are cut off after a while."""
    return TimeLimit(environment({}), LONGEST)


class Direct(DummyVecEnv):
    """One environment with the methods of RayWorkers, in this process.

    Args:
        dies_after: segments after which the actor dies once, within a run; None: never.

    Attributes:
        died_at: actions before its death.
    """

    def __init__(self, dies_after=None):
        super().__init__([made])
        self.collector, self.lost, self._dies_after = Collector(self.envs[0], 0.99), 0, dies_after

    def reset(self):
        (seed,) = self._seeds
        self._reset_seeds()
        return self.collector.reset(seed)[None]

    def collect(self, policy, count):
        self.collector.learn(
            1, type(policy), policy._get_constructor_parameters(), policy.state_dict()
        )
        segments, most, done = 0, count, True
        while count:
            if not (self._dies_after is None or segments < self._dies_after or done or self.lost):
                self.lost, self.died_at = 1, most - count
                self.collector.reset(5)
                yield 0, None
            segment = self.collector.collect(1, count)
            for array in (segment.rewards, segment.values):
                array.flags.writeable = False  # as Ray's arrays are
            segments += 1
            count, done = count - len(segment), segment.done
            yield 0, segment


class Infos(BaseCallback):
    """Notes the ends of runs."""

    def __init__(self):
        super().__init__()
        self.ends = []

    def _on_step(self):
        self.ends += [info["end"] for info in self.locals["infos"] if "end" in info]
        return True


@pytest.fixture
def interrupts():
    """Ctrl-C ends the tests again, although an environment's process leaves it to its parent."""
    import signal

    before = signal.getsignal(signal.SIGINT)
    yield
    signal.signal(signal.SIGINT, before)


def test_one_actor_collects_what_one_environment_does(interrupts):
    torch.set_num_threads(1)
    stepped = PPO("MlpPolicy", DummyVecEnv([made]), **NETWORK)
    torch.manual_seed(NETWORK["seed"])  # as an actor does when its environment is seeded
    stepped.learn(STEPS)
    collected = RayPPO("MlpPolicy", Direct(), **NETWORK).learn(STEPS)
    for name in PARTS:
        ours, theirs = (getattr(m.rollout_buffer, name) for m in (collected, stepped))
        assert ours == pytest.approx(theirs, rel=1e-4, abs=1e-5), name
    assert collected.rollout_buffer.episode_starts.sum() > 3
    assert collected.num_timesteps == stepped.num_timesteps == STEPS


def test_a_dead_actor_leaves_what_it_had_sent(interrupts, monkeypatch):
    monkeypatch.setattr(ray_actors, "LONGEST", 16)  # it dies within a run
    actors, infos = Direct(dies_after=2), Infos()
    model = RayPPO("MlpPolicy", actors, **NETWORK)
    model.learn(STEPS, callback=infos)
    assert model.num_timesteps == STEPS
    assert infos.ends.count(LOST) == 1
    buffer = model.rollout_buffer
    assert np.isfinite(buffer.returns).all() and buffer.full
    assert actors.died_at and buffer.episode_starts[actors.died_at]


def test_actors_draw_different_actions(interrupts):
    seeds = set()
    for _ in range(2):
        actor = Actor(Parcel.packed({}), 0.99)
        seeds.add(torch.initial_seed())
        actor.env.close()
    assert len(seeds) == 2
