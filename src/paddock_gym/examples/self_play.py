"""Two DeepRacers learn to race by self-play: PPO of stable-baselines3 on RaceEnv.

    ./run setup --with learning
    ./run exec python src/paddock_gym/examples/self_play.py race.zip

The opponent of each race is pure pursuit that passes, or one of the last versions of what learns.
"""

import argparse
import copy
import time
import warnings

import gymnasium
import torch
from paddock_gym.envs.race import RaceEnv
from paddock_gym.evaluation.races import Avoiding, race, wins
from paddock_gym.training.workers import Threads
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback

LEARNER, OPPONENT = "car1", "car2"
EVERY, KEPT = 8192, 6  # actions between versions that are kept, how many
PURSUIT = 0.3  # fraction of races against pure pursuit
SPEEDS = (0.8, 1.8)  # of pure pursuit [m/s]
PAST = []  # versions of the policy


class Duel(gymnasium.Env):
    """The race of one car against a drawn opponent."""

    def __init__(self):
        self._env = RaceEnv()
        self.action_space = self._env.action_space(LEARNER)
        self.observation_space = self._env.observation_space(LEARNER)

    def reset(self, *, seed=None, options=None):
        """Start a race."""
        super().reset(seed=seed)
        rng, task = self.np_random, self._env.tasks[OPPONENT]
        if not PAST or rng.random() < PURSUIT:
            self._act = Avoiding(task, rng.uniform(*SPEEDS)).act
        else:
            policy = PAST[rng.integers(len(PAST))]
            self._act = lambda seen: policy.predict(seen, deterministic=True)[0]
        self._seen, infos = self._env.reset(seed=int(rng.integers(2**31)))
        return self._seen[LEARNER], infos[LEARNER]

    def step(self, action):
        """Drive both cars."""
        actions = {LEARNER: action}
        if OPPONENT in self._env.agents:
            actions[OPPONENT] = self._act(self._seen[OPPONENT])
        self._seen, rewards, *ends, infos = self._env.step(actions)
        terminated, truncated = (end[LEARNER] for end in ends)
        return self._seen[LEARNER], rewards[LEARNER], terminated, truncated, infos[LEARNER]

    def close(self):
        """Free the engine."""
        self._env.close()


class Versions(BaseCallback):
    """Keeps versions of the policy as opponents, prints how races end; ends after a time [s]."""

    def __init__(self, seconds):
        super().__init__()
        self._until, self._next, self._ends = time.monotonic() + seconds, EVERY, []

    def _on_step(self):
        self._ends += [info["end"] for info in self.locals["infos"] if "episode" in info]
        if self.num_timesteps >= self._next:
            self._next += EVERY
            PAST.append(copy.deepcopy(self.model.policy))
            del PAST[:-KEPT]
            last = self._ends[-100:]
            print(f"{self.num_timesteps} actions: {last.count('lap')} of {len(last)} races won")
        return time.monotonic() < self._until


def main(words=None):
    """Train, write the policy, race it; returns races won against each opponent."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("policy", help="file of stable-baselines3 to write")
    parser.add_argument("--seconds", type=float, default=900.0, help="of training")
    parser.add_argument("--steps", type=int, default=1_000_000, help="actions at most")
    parser.add_argument("--races", type=int, default=20, help="against each opponent afterwards")
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args(words)
    torch.set_num_threads(1)
    gymnasium.register("Duel-v0", entry_point=Duel)
    PAST.clear()
    worlds = Threads({"id": "Duel-v0"}, 8)
    worlds.seed(given.seed)
    model = PPO("MlpPolicy", worlds, seed=given.seed, device="cpu", n_steps=128, batch_size=256,
                learning_rate=1e-3, gamma=0.98, policy_kwargs={"log_std_init": -0.7})  # fmt: skip
    model.learn(given.steps, callback=Versions(given.seconds))
    worlds.close()
    model.save(given.policy)
    env = RaceEnv()
    opponents = {
        f"pursuit at {speed} m/s": Avoiding(env.tasks[OPPONENT], speed).act
        for speed in (1.0, 1.5, 2.0)
    }
    if PAST:
        opponents["an earlier version"] = lambda seen: PAST[0].predict(seen, deterministic=True)[0]
    won = {}
    for name, act in opponents.items():
        drivers = {LEARNER: lambda seen: model.predict(seen, deterministic=True)[0], OPPONENT: act}
        won[name] = wins(race(env, drivers, given.races))
        print(f"against {name}: {won[name][LEARNER]} of {given.races} won, "
              f"{won[name][OPPONENT]} lost")  # fmt: skip
    env.close()
    return won


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    main()
