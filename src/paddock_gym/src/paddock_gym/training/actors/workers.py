"""Environments as Ray actors, here or on the nodes of a cluster; one that dies is replaced."""

import numpy as np
import ray
import torch
from ray.exceptions import GetTimeoutError, RayActorError, RayError, RayTaskError
from stable_baselines3.common.vec_env.base_vec_env import VecEnv
from stable_baselines3.common.vec_env.subproc_vec_env import _stack_obs

from paddock_gym.errors import GymError
from paddock_gym.training.actors.cluster import share_of
from paddock_gym.training.actors.collector import Collector
from paddock_gym.training.worker import Parcel, environment
from paddock_gym.training.workers import ATTEMPTS, died_again

START_TIME = 300.0  # [s] until all actors must run


class Actor(Collector):
    """What runs on a node.

    Args:
        parcel: Parcel of the environment's options.
        gamma: discount factor.
    """

    def __init__(self, parcel, gamma):
        super().__init__(environment(parcel.unpacked()), gamma)
        torch.seed()  # those that replace dead ones get none: each draws actions of its own


class RayWorkers(VecEnv):
    """Actors that drive by themselves; for RayPPO, which asks for segments and not for steps.

    Args:
        options: keyword arguments of the environment.
        count: of actors.
        nodes: processors of each node; the actors share them.
        gamma: discount factor.

    Attributes:
        lost: how many actors died.

    Raises:
        GymError: they do not start.
    """

    def __init__(self, options, count, nodes, gamma):
        self._made_of = ray.put(Parcel.packed(options)), gamma
        self._actor, self._version = ray.remote(Actor), 0
        share = share_of(nodes, count)
        self.actors, self.lost = [self._new(share) for _ in range(count)], 0
        super().__init__(count, *self._spaces())

    def _new(self, share):
        """An actor; Ray starts it where there is place, evenly over the nodes."""
        options = {"num_cpus": share, "scheduling_strategy": "SPREAD"}
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
        begun = [actor.reset.remote(seed) for actor, seed in zip(self.actors, self._seeds)]
        self._reset_seeds()
        return _stack_obs(ray.get(begun), self.observation_space)

    def collect(self, policy, count):
        """Let all actors drive by a policy.

        Args:
            policy: of stable-baselines3.
            count: of actions of each actor.

        Yields:
            (number of the actor, Segment), or (number, None): it died and was replaced.

        Raises:
            GymError: an actor died again and again.
        """
        self._version += 1
        weights = {name: tensor.cpu().numpy() for name, tensor in policy.state_dict().items()}
        arguments = policy._get_constructor_parameters()
        lesson = self._version, type(policy), arguments, ray.put(weights)
        for actor in self.actors:
            actor.learn.remote(*lesson)
        left, deaths = [count] * self.num_envs, [0] * self.num_envs
        asked = {self._ask(number, count): number for number in range(self.num_envs)}
        while asked:
            ready = ray.wait(list(asked))[0][0]
            number, segment = asked.pop(ready), None
            try:
                segment = ray.get(ready)
                left[number] -= len(segment)
                deaths[number] = 0
            except RayTaskError:  # a fault of the program, not of the machine
                raise
            except RayError:  # actor or node died, or the node with the segment on it
                deaths[number] += 1
                if deaths[number] > ATTEMPTS:
                    raise died_again(number, self.num_envs) from None
                self._replace(number, lesson)
            if left[number]:
                asked[self._ask(number, left[number])] = number
            yield number, segment

    def _ask(self, number, most):
        return self.actors[number].collect.remote(self._version, most)

    def _replace(self, number, lesson):
        """Start an actor anew.

        It asks for no share of processors: when a node was lost, the others take its actors.
        """
        self.lost += 1
        ray.kill(self.actors[number])  # where only the way to it was lost
        self.actors[number] = self._new(0)
        self.actors[number].learn.remote(*lesson)

    def pids(self):
        """Process of each actor, on its node."""
        return ray.get([actor.pid.remote() for actor in self.actors])

    def close(self):
        """End all actors, and the connection to the cluster."""
        for actor in self.actors:
            ray.kill(actor)
        ray.shutdown()

    def step_async(self, actions):
        """Refused: a call for each action would take longer than the action."""
        raise NotImplementedError("actors drive by themselves: collect()")

    step_wait = step_async

    def get_attr(self, attr_name, indices=None):
        """None of each: actors give no attributes away."""
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
