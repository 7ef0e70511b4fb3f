"""Environments of a training: in threads of its process, or in processes of their own, of which
one that dies is replaced; only its episode is lost."""

import multiprocessing

import numpy as np
from stable_baselines3.common.env_util import is_wrapped
from stable_baselines3.common.vec_env import SubprocVecEnv
from stable_baselines3.common.vec_env.base_vec_env import CloudpickleWrapper, VecEnv
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


class Threads(VecEnv):
    """Environments in threads of this process, see Worlds; as stable-baselines3 wants them.

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
        first = self._worlds.envs[0]
        self.render_mode = None
        super().__init__(count, first.observation_space, first.action_space)
        self._actions = None

    def reset(self):
        """Reset all."""
        envs, seeds, options = self._worlds.envs, self._seeds, self._options

        def reset(index):
            given = {"options": options[index]} if options[index] else {}
            return envs[index].reset(seed=seeds[index], **given)

        observations, self.reset_infos = zip(*self._worlds.each(reset))
        self._reset_seeds()
        self._reset_options()
        return _stack_obs(observations, self.observation_space)

    def step_async(self, actions):
        """Take the actions."""
        self._actions = actions

    def step_wait(self):
        """Apply them; a run that has ended starts anew."""
        observations, rewards, dones, infos, self.reset_infos = zip(*self._worlds.each(self._step))
        stacked = _stack_obs(observations, self.observation_space)
        return stacked, np.array(rewards, np.float32), np.array(dones), list(infos)

    def _step(self, index):
        env, reset_info = self._worlds.envs[index], self.reset_infos[index]
        observation, reward, terminated, truncated, info = env.step(self._actions[index])
        info["TimeLimit.truncated"] = truncated and not terminated
        done = terminated or truncated
        if done:
            info["terminal_observation"] = observation
            observation, reset_info = env.reset()
        return observation, reward, done, info, reset_info

    def close(self):
        """Free all."""
        self._worlds.close()

    def get_attr(self, attr_name, indices=None):
        """An attribute of each."""
        return [env.get_wrapper_attr(attr_name) for env in self._chosen(indices)]

    def set_attr(self, attr_name, value, indices=None):
        """Set an attribute of each."""
        for env in self._chosen(indices):
            setattr(env.unwrapped, attr_name, value)

    def env_method(self, method_name, *arguments, indices=None, **options):
        """Results of a method of each, in its thread."""
        chosen = set(self._get_indices(indices))

        def call(index):
            if index in chosen:
                method = self._worlds.envs[index].get_wrapper_attr(method_name)
                return method(*arguments, **options)
            return None

        results = self._worlds.each(call)
        return [results[index] for index in self._get_indices(indices)]

    def env_is_wrapped(self, wrapper_class, indices=None):
        """Whether each has a wrapper of a class."""
        return [is_wrapped(env, wrapper_class) for env in self._chosen(indices)]

    def _chosen(self, indices):
        return [self._worlds.envs[index] for index in self._get_indices(indices)]


def died_again(index, count):
    """The error of a worker that cannot be replaced."""
    return GymError(
        f"worker {index} died {ATTEMPTS} times in a row; is there memory for {count} workers?"
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
        for index in range(self.num_envs):
            self._send(index, ("reset", (self._seeds[index], self._options[index])))
        results = [self._receive(index) for index in range(self.num_envs)]
        results = [
            self._replace(index) if result is None else result
            for index, result in enumerate(results)
        ]
        observations, self.reset_infos = zip(*results)
        self._before = list(observations)
        self._reset_seeds()
        self._reset_options()
        return _stack_obs(observations, self.observation_space)

    def step_async(self, actions):
        """Send the actions."""
        for index, action in enumerate(actions):
            self._send(index, ("step", action))
        self.waiting = True

    def step_wait(self):
        """Collect their results; the run of a dead worker is truncated."""
        self.waiting = False
        results = [self._receive(index) for index in range(self.num_envs)]
        results = [
            self._truncate(index) if result is None else result
            for index, result in enumerate(results)
        ]
        observations, rewards, dones, infos, self.reset_infos = zip(*results)
        self._before = list(observations)
        stacked = _stack_obs(observations, self.observation_space)
        return stacked, np.stack(rewards), np.stack(dones), infos

    def close(self):
        """Stop all processes, also after an error."""
        if not self.closed:
            for index in range(self.num_envs):
                self._send(index, ("close", None))
            for process in self.processes:
                process.join()
            self.closed = True

    def _send(self, index, message):
        try:
            self.remotes[index].send(message)
        except _CONNECTION_LOST:
            pass  # _receive() notices

    def _receive(self, index):
        """A worker's response, or None: it is dead."""
        try:
            return self.remotes[index].recv()
        except _CONNECTION_LOST:
            return None

    def _truncate(self, index):
        info = {"TimeLimit.truncated": True, "terminal_observation": self._before[index]}
        observation, reset_info = self._replace(index)
        return observation, 0.0, True, dict(info, end=LOST), reset_info

    def _replace(self, index):
        """Replace a process; returns (observation, info) of its reset.

        Raises:
            GymError: the new ones die as well.
        """
        for _ in range(ATTEMPTS):
            self.lost += 1
            self._start(index)
            self._send(index, ("reset", (None, {})))
            started = self._receive(index)
            if started is not None:
                return started
        raise died_again(index, self.num_envs)

    def _start(self, index):
        self.remotes[index].close()
        self.processes[index].join()
        context = multiprocessing.get_context("forkserver")
        here, there = context.Pipe()
        process = context.Process(
            target=_worker,
            args=(there, here, CloudpickleWrapper(self._makers[index])),
            daemon=True,
        )
        process.start()
        there.close()
        self.remotes = (*self.remotes[:index], here, *self.remotes[index + 1 :])
        self.processes[index] = process
