"""Environments in processes of their own; one that dies is replaced and costs only its episode."""

import multiprocessing
import os
import signal

import gymnasium
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import SubprocVecEnv
from stable_baselines3.common.vec_env.base_vec_env import CloudpickleWrapper
from stable_baselines3.common.vec_env.subproc_vec_env import _stack_obs, _worker

from paddock_gym.errors import RewardError

LOST = "worker lost"
_GONE = (EOFError, ConnectionError, BrokenPipeError)
KEPT = ("end", "progress", "time", "x", "y")  # of the last info, for the log of episodes


def factory(options):
    """A function that makes one environment, in a process that leaves Ctrl-C to its parent.

    Args:
        options: keyword arguments of the environment.
    """

    def make():
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        os.environ.setdefault("LP_NUM_THREADS", "0")  # Mesa draws in this process's one thread
        import paddock_gym  # noqa: F401  (registers the environment)

        env = Reporting(gymnasium.make("Paddock/DeepRacer-v0", **options))
        return Monitor(env, info_keywords=KEPT)

    return make


class Reporting(gymnasium.Wrapper):
    """Reports what a user's reward function raised: the run ends with info["error"]."""

    def reset(self, **options):
        """Start a run."""
        self._last = self.env.reset(**options)
        return self._last

    def step(self, action):
        """Take an action."""
        try:
            observation, reward, terminated, truncated, info = self.env.step(action)
        except RewardError as error:
            observation, info = self._last
            return observation, 0.0, True, False, dict(info, error=str(error))
        self._last = observation, info
        return observation, reward, terminated, truncated, info


class Workers(SubprocVecEnv):
    """SubprocVecEnv that starts a new process for one that died.

    Args:
        makers: functions of factory().

    Attributes:
        lost: how many processes died.
    """

    def __init__(self, makers):
        self._makers, self.lost = makers, 0
        super().__init__(makers, start_method="forkserver")
        self._before = [None] * len(makers)  # the last observation of each

    def reset(self):
        """Reset all."""
        for number, remote in enumerate(self.remotes):
            self._send(number, remote, ("reset", (self._seeds[number], self._options[number])))
        results = [self._receive(number) for number in range(self.num_envs)]
        results = [
            self._replace(number) if result is None else result
            for number, result in enumerate(results)
        ]
        observations, self.reset_infos = zip(*results)
        self._before = list(observations)
        self._reset_seeds()
        self._reset_options()
        return _stack_obs(observations, self.observation_space)

    def step_async(self, actions):
        """Send the actions."""
        for number, (remote, action) in enumerate(zip(self.remotes, actions)):
            self._send(number, remote, ("step", action))
        self.waiting = True

    def step_wait(self):
        """Collect what they led to; a dead worker's run ends here, cut off."""
        results = []
        for number in range(self.num_envs):
            result = self._receive(number)
            results.append(self._cut_off(number) if result is None else result)
        self.waiting = False
        observations, rewards, dones, infos, self.reset_infos = zip(*results)
        self._before = list(observations)
        import numpy as np

        stacked = _stack_obs(observations, self.observation_space)
        return stacked, np.stack(rewards), np.stack(dones), infos

    def _send(self, number, remote, message):
        try:
            remote.send(message)
        except _GONE:
            pass  # _receive() notices

    def _receive(self, number):
        """A worker's answer, or None: it is dead."""
        try:
            return self.remotes[number].recv()
        except _GONE:
            return None

    def _cut_off(self, number):
        info = {"TimeLimit.truncated": True, "terminal_observation": self._before[number]}
        observation, reset_info = self._replace(number)
        return observation, 0.0, True, dict(info, end=LOST), reset_info

    def _replace(self, number):
        """Start a process anew; returns (observation, info) of its reset."""
        self.lost += 1
        self.remotes[number].close()
        self.processes[number].join()
        context = multiprocessing.get_context("forkserver")
        here, there = context.Pipe()
        process = context.Process(
            target=_worker,
            args=(there, here, CloudpickleWrapper(self._makers[number])),
            daemon=True,
        )
        process.start()
        there.close()
        self.remotes = (*self.remotes[:number], here, *self.remotes[number + 1 :])
        self.processes[number] = process
        here.send(("reset", (None, {})))
        return here.recv()
