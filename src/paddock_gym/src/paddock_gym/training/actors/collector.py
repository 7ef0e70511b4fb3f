"""Collects experience with one environment and a copy of the policy, on whatever machine."""

import os
from dataclasses import dataclass

import numpy as np
import torch
from gymnasium import spaces

LONGEST = 64  # actions of a segment


@dataclass
class Segment:
    """A part of a run, at most to its end.

    Attributes:
        observations: (K, ...) as the policy sees them, or a dict of such.
        actions: (K, ...) as drawn, not yet clipped.
        rewards: (K,); of a run cut off with the value of what would have followed.
        starts: (K,) whether a run began with the action's observation.
        values, log_probs: (K,) of the policy.
        done: whether the run ended.
        value: of the observation after the last action; of the new run's first, where it ended.
        infos: of the last action, where the run ended, or none.
    """

    observations: object
    actions: np.ndarray
    rewards: np.ndarray
    starts: np.ndarray
    values: np.ndarray
    log_probs: np.ndarray
    done: bool
    value: float
    infos: list

    def __len__(self):
        return len(self.rewards)


class Collector:
    """An environment and a policy that drives it.

    Args:
        env: a Gymnasium environment.
        gamma: discount factor.
    """

    def __init__(self, env, gamma):
        torch.set_num_threads(1)
        self.env, self._gamma = env, gamma
        self._policy, self._version, self._observation = None, -1, None

    def pid(self):
        """Number of its process."""
        return os.getpid()

    def spaces(self):
        """(observation space, action space)."""
        return self.env.observation_space, self.env.action_space

    def reset(self, seed=None):
        """Start a run; returns the observation. The seed is that of actions, too."""
        if seed is not None:
            torch.manual_seed(seed)
        self._observation, _ = self.env.reset(seed=seed)
        self._start = True
        return self._observation

    def learn(self, version, maker, arguments, weights):
        """Take over a policy.

        Args:
            version: number of the policy.
            maker: its class.
            arguments: keyword arguments of its class.
            weights: dict of name -> array.
        """
        if self._policy is None:
            with torch.random.fork_rng():  # the first weights are drawn and thrown away
                self._policy = maker(**arguments)
            self._policy.set_training_mode(False)
        state = {name: torch.as_tensor(array) for name, array in weights.items()}
        self._policy.load_state_dict(state)
        self._version = version

    def collect(self, version, most):
        """Drive until the run ends.

        Args:
            version: number of the policy that must drive.
            most: greatest number of actions.

        Returns:
            Segment.
        """
        if version != self._version:
            raise RuntimeError(f"policy {version} should drive, but {self._version} came last")
        rows, infos, done = [], [], False
        if self._observation is None:
            self.reset()
        while not done and len(rows) < min(most, LONGEST):
            row, done, info = self._step()
            rows.append(row)
        if done:
            infos = [info]
            self.reset()
        seen, *columns = zip(*rows)
        columns = [np.array(column) for column in columns]
        value = self._value(self._observation)
        return Segment(_stacked(seen), *columns, done, value, infos)

    def _step(self):
        """One action; returns (a row of the segment, whether the run ended, info)."""
        seen, _ = self._policy.obs_to_tensor(self._observation)
        with torch.no_grad():
            drawn, value, log_prob = self._policy(seen)
        drawn = drawn.numpy()[0]
        action, space = drawn, self.env.action_space
        if isinstance(space, spaces.Box):
            action = np.clip(drawn, space.low, space.high)
        observation, reward, terminated, truncated, info = self.env.step(action)
        if truncated and not terminated:
            reward += self._gamma * self._value(observation)
        row = (
            seen,
            np.atleast_1d(drawn),
            float(reward),
            self._start,
            float(value),
            float(log_prob),
        )
        self._observation, self._start = observation, False
        return row, terminated or truncated, info

    def _value(self, observation):
        """The policy's value of an observation."""
        with torch.no_grad():
            return float(self._policy.predict_values(self._policy.obs_to_tensor(observation)[0]))


def _stacked(tensors):
    """Arrays (K, ...) of tensors (1, ...), or of dicts of such."""
    if isinstance(tensors[0], dict):
        return {name: _stacked([tensor[name] for tensor in tensors]) for name in tensors[0]}
    return torch.cat(tensors).numpy()
