"""Environments in processes of their own; one that dies is replaced and costs only its episode."""

import multiprocessing

import numpy as np
from stable_baselines3.common.vec_env import SubprocVecEnv
from stable_baselines3.common.vec_env.base_vec_env import CloudpickleWrapper
from stable_baselines3.common.vec_env.subproc_vec_env import _stack_obs, _worker

from paddock_gym.errors import GymError
from paddock_gym.training.worker import LOST, environment

ATTEMPTS = 3  # to replace a worker
_GONE = (EOFError, ConnectionError)


def factory(options):
    """A function that makes one environment.

    Args:
        options: keyword arguments of the environment.
    """
    return lambda: environment(options)


def died_again(number, count):
    """The error of a worker that cannot be replaced."""
    return GymError(
        f"worker {number} died {ATTEMPTS} times in a row; is there memory for {count} workers?"
    )


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
        for number in range(self.num_envs):
            self._send(number, ("reset", (self._seeds[number], self._options[number])))
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
        for number, action in enumerate(actions):
            self._send(number, ("step", action))
        self.waiting = True

    def step_wait(self):
        """Collect what they led to; a dead worker's run ends here, cut off."""
        self.waiting = False
        results = [self._receive(number) for number in range(self.num_envs)]
        results = [
            self._cut_off(number) if result is None else result
            for number, result in enumerate(results)
        ]
        observations, rewards, dones, infos, self.reset_infos = zip(*results)
        self._before = list(observations)
        stacked = _stack_obs(observations, self.observation_space)
        return stacked, np.stack(rewards), np.stack(dones), infos

    def close(self):
        """End all processes, also after an error."""
        if not self.closed:
            for number in range(self.num_envs):
                self._send(number, ("close", None))
            for process in self.processes:
                process.join()
            self.closed = True

    def _send(self, number, message):
        try:
            self.remotes[number].send(message)
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
        """Start a process anew; returns (observation, info) of its reset.

        Raises:
            GymError: new ones die as well.
        """
        for _ in range(ATTEMPTS):
            self.lost += 1
            self._start(number)
            self._send(number, ("reset", (None, {})))
            begun = self._receive(number)
            if begun is not None:
                return begun
        raise died_again(number, self.num_envs)

    def _start(self, number):
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
