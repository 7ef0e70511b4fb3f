"""Training on several machines: Ray's actors collect, PPO learns."""

import logging
import os
import socket
from dataclasses import dataclass, replace

import numpy as np
import ray
import torch
from gymnasium import spaces
from ray._private import ray_constants
from ray.exceptions import GetTimeoutError, RayActorError, RayError, RayTaskError
from stable_baselines3 import PPO
from stable_baselines3.common.vec_env.base_vec_env import VecEnv
from stable_baselines3.common.vec_env.subproc_vec_env import _stack_obs

from paddock_gym.errors import GymError
from paddock_gym.training.worker import LOST, Parcel, environment
from paddock_gym.training.workers import ATTEMPTS, died_again


class RayPPO(PPO):
    """PPO for RayWorkers: it differs from PPO only in how rollouts are collected."""

    def collect_rollouts(self, env, callback, rollout_buffer, n_rollout_steps):
        """Fill the buffer; False: the callback stopped the training."""
        self.policy.set_training_mode(False)
        rollout_buffer.reset()
        callback.on_rollout_start()
        parts = [[] for _ in range(env.num_envs)]
        for index, segment in env.unwrapped.collect(self.policy, n_rollout_steps):
            if segment is None:
                cut_off(parts[index], self.gamma)
                infos = [{"end": LOST}]
            else:
                parts[index].append(segment)
                self.num_timesteps += len(segment)
                infos = segment.infos
            callback.update_locals({"infos": infos})
            if not callback.on_step():
                return False
            self._update_info_buffer(infos)
        fill(rollout_buffer, parts)
        callback.on_rollout_end()
        return True


def cut_off(parts, gamma):
    """End a dead actor's run; its last reward includes the value of the next state."""
    if parts and not parts[-1].done:
        rewards = parts[-1].rewards.copy()  # Ray's arrays are read-only
        rewards[-1] += gamma * parts[-1].value
        parts[-1] = replace(parts[-1], rewards=rewards, done=True)


def fill(rollout_buffer, parts):
    """Put segments into a buffer.

    Args:
        rollout_buffer: of stable-baselines3, empty.
        parts: for each actor a list of Segments, together as many actions as the buffer has rows.
    """
    columns = [
        side_by_side(parts, name)
        for name in ("observations", "actions", "rewards", "starts", "values", "log_probs")
    ]
    for time in range(rollout_buffer.buffer_size):
        *row, values, log_probs = (at(time, column) for column in columns)
        rollout_buffer.add(*row, torch.as_tensor(values), torch.as_tensor(log_probs))
    last = [segments[-1] for segments in parts]
    rollout_buffer.compute_returns_and_advantage(
        last_values=torch.tensor([segment.value for segment in last]),
        dones=np.array([segment.done for segment in last]),
    )


def side_by_side(parts, name):
    """Arrays (time, actor, ...) of an attribute of segments, or a dict of these."""
    columns = [[getattr(segment, name) for segment in segments] for segments in parts]
    if isinstance(columns[0][0], dict):
        return {
            key: np.stack(
                [np.concatenate([array[key] for array in arrays]) for arrays in columns], axis=1
            )
            for key in columns[0][0]
        }
    return np.stack([np.concatenate(arrays) for arrays in columns], axis=1)


def at(time, column):
    """The row of a time."""
    if isinstance(column, dict):
        return {key: array[time] for key, array in column.items()}
    return column[time]


LONGEST = 64  # actions of a segment


@dataclass
class Segment:
    """A part of a run, at most to its end.

    Attributes:
        observations: (K, ...) as the policy sees them, or a dict of these.
        actions: (K, ...) as sampled, before clipping.
        rewards: (K,); the last one of a truncated run includes the value of the next state.
        starts: (K,) whether a run started with the action's observation.
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
    """An environment and a policy that drives it."""

    def __init__(self, env, gamma):
        torch.set_num_threads(1)
        self.env, self._gamma = env, gamma
        self._policy, self._version, self._observation = None, -1, None

    def pid(self):
        """ID of its process."""
        return os.getpid()

    def spaces(self):
        """(observation space, action space)."""
        return self.env.observation_space, self.env.action_space

    def reset(self, seed=None):
        """Start a run; returns the observation. The seed also applies to the actions."""
        if seed is not None:
            torch.manual_seed(seed)
        self._observation, _ = self.env.reset(seed=seed)
        self._start = True
        return self._observation

    def learn(self, version, maker, arguments, weights):
        """Load a policy.

        Args:
            weights: dict of name -> array.
        """
        if self._policy is None:
            with torch.random.fork_rng():  # the initial weights are random and overwritten
                self._policy = maker(**arguments)
            self._policy.set_training_mode(False)
        state = {name: torch.as_tensor(array) for name, array in weights.items()}
        self._policy.load_state_dict(state)
        self._version = version

    def collect(self, version, max_actions) -> Segment:
        """Drive until the run ends.

        Args:
            version: number of the policy that must drive.
        """
        if version != self._version:
            raise RuntimeError(f"policy {version} should drive, but {self._version} came last")
        rows, infos, done = [], [], False
        if self._observation is None:
            self.reset()
        while not done and len(rows) < min(max_actions, LONGEST):
            row, done, info = self._step()
            rows.append(row)
        if done:
            infos = [info]
            self.reset()
        observations, *columns = zip(*rows)
        columns = [np.array(column) for column in columns]
        value = self._value(self._observation)
        return Segment(_stacked(observations), *columns, done, value, infos)

    def _step(self):
        """One action; returns (a row of the segment, whether the run ended, info)."""
        observations, _ = self._policy.obs_to_tensor(self._observation)
        with torch.no_grad():
            sampled, value, log_prob = self._policy(observations)
        sampled = sampled.numpy()[0]
        action, space = sampled, self.env.action_space
        if isinstance(space, spaces.Box):
            action = np.clip(sampled, space.low, space.high)
        observation, reward, terminated, truncated, info = self.env.step(action)
        if truncated and not terminated:
            reward += self._gamma * self._value(observation)
        row = (
            observations,
            np.atleast_1d(sampled),
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
    """Arrays (K, ...) of tensors (1, ...), or of dicts of these."""
    if isinstance(tensors[0], dict):
        return {name: _stacked([tensor[name] for tensor in tensors]) for name in tensors[0]}
    return torch.cat(tensors).numpy()


AUTO = "auto"
START_ATTEMPTS = 3  # to start on a busy machine
CONNECT_TIMEOUT = 10.0  # [s] for a connection to a head
ENVIRONMENT = {"RAY_USAGE_STATS_ENABLED": "0"}


def connect(address, log=print):
    """Join a cluster.

    Args:
        address: HOST:PORT of its head, or auto: the one that this machine belongs to; without one,
            a cluster of this machine alone is started and stops with this process.
        log: function of one line.

    Returns:
        Processors of each node.

    Raises:
        GymError: there is no such cluster.
    """
    os.environ.update(ENVIRONMENT)
    if address != AUTO:
        _check_listens(address)
    common = {"log_to_driver": False, "logging_level": logging.ERROR}
    try:
        ray.init(address=address, **common)
    except ConnectionError as error:
        if address != AUTO:
            raise _bad_address(address, error) from error
        _start_here(common)
    except (ValueError, RuntimeError) as error:
        raise _bad_address(address, error) from error
    nodes = [node["Resources"].get("CPU", 0.0) for node in ray.nodes() if node["Alive"]]
    if not sum(nodes):
        raise GymError(f"the Ray cluster {address} offers no processors; it must have one or more")
    text = "1 node" if len(nodes) == 1 else f"{len(nodes)} nodes"
    log(f"train: Ray with {text}, {sum(nodes):g} processors")
    return nodes


def _check_listens(address):
    """Raise GymError if the port does not listen; Ray itself would retry for minutes."""
    host, _, port = address.rpartition(":")
    try:
        socket.create_connection((host.strip("[]"), int(port)), CONNECT_TIMEOUT).close()
    except (OSError, ValueError, OverflowError) as error:
        raise _bad_address(address, error) from error


def _start_here(common):
    """Start a cluster of this machine alone, on loopback and not on the machine's address."""
    os.environ["RAY_ENABLE_WINDOWS_OR_OSX_CLUSTER"] = "0"  # read by Ray's processes as they start
    ray_constants.ENABLE_RAY_CLUSTER = False  # this process has read it before
    for attempt in range(START_ATTEMPTS):
        try:
            ray.init(address="local", include_dashboard=False, **common)
            return
        except Exception as error:  # Ray's time-out is 30 s, and it raises a plain Exception
            ray.shutdown()
            if "timed out" not in str(error) or attempt == START_ATTEMPTS - 1:
                reason = str(error).strip().split("\n")[0]
                raise GymError(f"Ray did not start on this machine: {reason}") from error


def _bad_address(address, error):
    reason = str(error).strip().split("\n")[0]
    return GymError(
        f"ray is {address!r}; it must be auto, or HOST:PORT of the head of a cluster that this "
        f"machine has joined by ./run cluster ({reason})"
    )


def cpus_per_actor(nodes, count):
    """Return the fraction of a processor per actor with which all actors fit on the nodes.

    Args:
        nodes: processors of each node.
    """
    cpus = min(1.0, sum(nodes) / count)
    while sum(int(processors / cpus) for processors in nodes) < count:
        cpus *= 0.95
    return int(cpus * 1000) / 1000


START_TIME = 300.0  # [s] until all actors must run


class Actor(Collector):
    """A Collector that runs on a node.

    Args:
        parcel: Parcel of the environment's options.
    """

    def __init__(self, parcel, gamma):
        super().__init__(environment(parcel.unpacked()), gamma)
        torch.seed()  # actors that replace dead ones are not seeded: their actions differ


class RayWorkers(VecEnv):
    """Actors that drive alone; for RayPPO, which requests segments instead of steps.

    Args:
        options: keyword arguments of the environment.
        nodes: processors of each node; the actors share them.

    Attributes:
        lost: how many actors died.

    Raises:
        GymError: they do not start.
    """

    def __init__(self, options, count, nodes, gamma):
        self._made_of = ray.put(Parcel.packed(options)), gamma
        self._actor, self._version = ray.remote(Actor), 0
        cpus = cpus_per_actor(nodes, count)
        self.actors, self.lost = [self._new(cpus) for _ in range(count)], 0
        super().__init__(count, *self._spaces())

    def _new(self, cpus):
        """Create an actor; Ray starts it on a node with free processors, evenly."""
        options = {"num_cpus": cpus, "scheduling_strategy": "SPREAD"}
        return self._actor.options(**options).remote(*self._made_of)

    def _spaces(self):
        """(observation space, action space), when all actors run."""
        try:
            return ray.get([actor.spaces.remote() for actor in self.actors], timeout=START_TIME)[0]
        except GetTimeoutError as error:
            raise GymError(
                f"{len(self.actors)} workers did not start within {START_TIME:g} s; Ray has "
                f"{ray.available_resources().get('CPU', 0):g} processors free"
            ) from error
        except RayActorError as error:
            raise GymError(f"an environment did not start on its node: {error}") from error

    def reset(self):
        """Start a run in each; returns the observations."""
        started = [actor.reset.remote(seed) for actor, seed in zip(self.actors, self._seeds)]
        self._reset_seeds()
        return _stack_obs(ray.get(started), self.observation_space)

    def collect(self, policy, count):
        """Make all actors drive by a policy.

        Args:
            count: of actions of each actor.

        Yields:
            (index of the actor, Segment), or (index, None): it died and was replaced.

        Raises:
            GymError: an actor died again and again.
        """
        self._version += 1
        weights = {name: tensor.cpu().numpy() for name, tensor in policy.state_dict().items()}
        arguments = policy._get_constructor_parameters()
        lesson = self._version, type(policy), arguments, ray.put(weights)
        for actor in self.actors:
            actor.learn.remote(*lesson)
        left, failures = [count] * self.num_envs, [0] * self.num_envs
        pending = {self._collect(index, count): index for index in range(self.num_envs)}
        while pending:
            ready = ray.wait(list(pending))[0][0]
            index, segment = pending.pop(ready), None
            try:
                segment = ray.get(ready)
                left[index] -= len(segment)
                failures[index] = 0
            except RayTaskError:  # an error of the program, not of the machine
                raise
            except RayError:  # actor or node died, or the node with the segment on it
                failures[index] += 1
                if failures[index] > ATTEMPTS:
                    raise died_again(index, self.num_envs) from None
                self._replace(index, lesson)
            if left[index]:
                pending[self._collect(index, left[index])] = index
            yield index, segment

    def _collect(self, index, max_actions):
        return self.actors[index].collect.remote(self._version, max_actions)

    def _replace(self, index, lesson):
        """Replace an actor.

        It requests no processors: when a node has died, the others take its actors.
        """
        self.lost += 1
        ray.kill(self.actors[index])  # if only the connection to it was lost
        self.actors[index] = self._new(0)
        self.actors[index].learn.remote(*lesson)

    def pids(self):
        """Process of each actor, on its node."""
        return ray.get([actor.pid.remote() for actor in self.actors])

    def close(self):
        """Kill all actors and close the connection to the cluster."""
        for actor in self.actors:
            ray.kill(actor)
        ray.shutdown()

    def step_async(self, actions):
        """Refused: a call for each action would take longer than the action."""
        raise NotImplementedError("actors drive alone: collect()")

    step_wait = step_async

    def get_attr(self, attr_name, indices=None):
        """None of each: attributes of actors are not available."""
        return [None for _ in self._get_indices(indices)]

    def set_attr(self, attr_name, value, indices=None):
        """Refused."""
        raise NotImplementedError("environments in actors have no attributes to set")

    def env_method(self, method_name, *method_args, indices=None, **method_kwargs):
        """Refused."""
        raise NotImplementedError("environments in actors have no methods to call")

    def env_is_wrapped(self, wrapper_class, indices=None):
        """False of each."""
        return np.zeros(len(list(self._get_indices(indices))), bool).tolist()
