"""Environments in processes of their own."""

import multiprocessing
import os
import pathlib
import signal
from dataclasses import dataclass

import gymnasium
import numpy as np
from bullet_sim.files import OwnFolder
from stable_baselines3.common.vec_env import SubprocVecEnv
from stable_baselines3.common.vec_env.base_vec_env import CloudpickleWrapper
from stable_baselines3.common.vec_env.subproc_vec_env import _stack_obs, _worker

from paddock_gym.errors import GymError, RewardError

LOST = "worker lost"  # as the end of a run
KEPT = ("end", "progress", "time", "x", "y")  # of the last info, for the log of runs
FILES = ("track", "action", "reward")  # options that may be paths


@dataclass(frozen=True)
class Parcel:
    """Options of an environment with the content of the files they name, for another machine.

    Attributes:
        options: keyword arguments of the environment.
        files: option -> (file name, bytes).
    """

    options: dict
    files: dict

    @classmethod
    def packed(cls, options):
        """Read the files that options name."""
        paths = {name: pathlib.Path(str(options.get(name))) for name in FILES}
        files = {name: (path.name, path.read_bytes()) for name, path in paths.items()
                 if path.is_file()}  # fmt: skip
        return cls(options, files)

    def unpacked(self):
        """Options whose files are there: written to a temporary folder where they differ here.

        The folder lives as long as this process, see bullet_sim.files.
        """
        options, folder = dict(self.options), None
        for name, (file, content) in self.files.items():
            path = pathlib.Path(options[name])
            if not path.is_file() or path.read_bytes() != content:
                folder = folder or OwnFolder()
                path = pathlib.Path(folder.path) / name / file
                path.parent.mkdir()
                path.write_bytes(content)
            options[name] = str(path)
        return options


def environment(options):
    """One environment, in a process that leaves Ctrl-C to its parent.

    Args:
        options: keyword arguments of the environment; id: its Gymnasium id (DeepRacer).
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    os.environ.setdefault("LP_NUM_THREADS", "0")  # Mesa draws in this process's one thread
    from paddock_gym.ids import IDS  # the package registers the environments

    env = Reporting(gymnasium.make(**{"id": IDS[0], **options}))
    return gymnasium.wrappers.RecordEpisodeStatistics(env, buffer_length=1)


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
