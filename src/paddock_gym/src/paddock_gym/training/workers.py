"""Environments of a training: in threads of its process, or in processes of their own, of which
one that dies is replaced; only its episode is lost."""

import contextlib
import multiprocessing

import numpy as np
from stable_baselines3.common.vec_env import DummyVecEnv, SubprocVecEnv
from stable_baselines3.common.vec_env.base_vec_env import CloudpickleWrapper
from stable_baselines3.common.vec_env.subproc_vec_env import _stack_obs, _worker

from paddock_gym.envs.worlds import Worlds
from paddock_gym.errors import GymError
from paddock_gym.training.worker import LOST, environment, make

ATTEMPTS = 3  # to replace a worker
_CONNECTION_LOST = (EOFError, ConnectionError)


def factory(options):
    """A function that makes one environment.

    Args:
        options: keyword arguments of the environment.
    """
    return lambda: environment(options)


class Threads(DummyVecEnv):
    """DummyVecEnv whose environments reset and step in threads of this process, see Worlds.

    Args:
        options: keyword arguments of each environment.
        count: how many environments.
        threads: how many; None: as many as there are processors.

    Attributes:
        lost: 0, as of Workers.
    """

    lost = 0

    def __init__(self, options, count, threads=None):
        self._worlds = Worlds([lambda: make(options)] * count, threads)
        super().__init__([lambda env=env: env for env in self._worlds.envs])

    def reset(self):
        """Reset all."""

        def reset(index):
            options = {"options": self._options[index]} if self._options[index] else {}
            return self.envs[index].reset(seed=self._seeds[index], **options)

        observations, self.reset_infos = zip(*self._worlds.map(reset))
        self._reset_seeds()
        self._reset_options()
        return _stack_obs(observations, self.observation_space)

    def step_wait(self):
        """Apply the actions; a run that has ended starts anew."""
        results = zip(*self._worlds.map(self._step))
        observations, rewards, dones, infos, self.reset_infos = results
        stacked = _stack_obs(observations, self.observation_space)
        return stacked, np.array(rewards, np.float32), np.array(dones), list(infos)

    def _step(self, index):
        env, reset_info = self.envs[index], self.reset_infos[index]
        observation, reward, terminated, truncated, info = env.step(self.actions[index])
        info["TimeLimit.truncated"] = truncated and not terminated
        done = terminated or truncated
        if done:
            info["terminal_observation"] = observation
            observation, reset_info = env.reset()
        return observation, reward, done, info, reset_info

    def env_method(self, method_name, *arguments, indices=None, **options):
        """Results of a method of each, in its thread."""
        chosen = self._get_indices(indices)

        def call(index):
            if index in chosen:
                return self.envs[index].get_wrapper_attr(method_name)(*arguments, **options)
            return None

        results = self._worlds.map(call)
        return [results[index] for index in chosen]

    def close(self):
        """Free all."""
        self._worlds.close()


def died_again(index, count):
    """The error of a worker that cannot be replaced."""
    return GymError(
        f"worker {index} died {ATTEMPTS} times in a row; is there memory for {count} workers?"
    )


class Connection:
    """A worker's connection as SubprocVecEnv uses it: a process that died is replaced.

    Args:
        workers: Workers of which it is number `index`.
    """

    def __init__(self, workers, index, pipe):
        self._workers, self._index, self._pipe = workers, index, pipe
        self._command = self._observation = None  # the last command, the last observation

    def send(self, message):
        """Send a command; recv() notices if nobody takes it."""
        self._command = message[0]
        with contextlib.suppress(*_CONNECTION_LOST):
            self._pipe.send(message)

    def recv(self):
        """The response; the run of a dead worker is truncated."""
        try:
            result = self._pipe.recv()
        except _CONNECTION_LOST:
            if self._command not in ("reset", "step"):
                raise
            info = {"TimeLimit.truncated": True, "terminal_observation": self._observation}
            result = self._restarted()
            if self._command == "step":
                result = result[0], 0.0, True, dict(info, end=LOST), result[1]
        if self._command in ("reset", "step"):
            self._observation = result[0]
        return result

    def _restarted(self):
        """(observation, info) of the reset of a new process.

        Raises:
            GymError: the new ones die as well.
        """
        for _ in range(ATTEMPTS):
            self._pipe.close()
            self._pipe = self._workers.restart(self._index)
            try:
                self._pipe.send(("reset", (None, {})))
                return self._pipe.recv()
            except _CONNECTION_LOST:
                pass
        raise died_again(self._index, self._workers.num_envs)


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
        self.remotes = [Connection(self, *numbered) for numbered in enumerate(self.remotes)]

    def restart(self, index):
        """Start another process for a dead one; returns the connection to it."""
        self.lost += 1
        self.processes[index].join()
        context = multiprocessing.get_context("forkserver")
        here, there = context.Pipe()
        maker = CloudpickleWrapper(self._makers[index])
        process = context.Process(target=_worker, args=(there, here, maker), daemon=True)
        process.start()
        there.close()
        self.processes[index] = process
        return here

    def close(self):
        """Stop all processes, also after an error."""
        self.waiting = False  # for results, some of which may have been received
        super().close()
