"""PPO of stable-baselines3 whose experience comes from actors, segment by segment."""

from dataclasses import replace

import numpy as np
import torch
from stable_baselines3 import PPO

from paddock_gym.training.worker import LOST


class RayPPO(PPO):
    """PPO for RayWorkers: everything but how a rollout is collected is that of PPO."""

    def collect_rollouts(self, env, callback, rollout_buffer, n_rollout_steps):
        """Fill the buffer; False: the callback ended the training."""
        self.policy.set_training_mode(False)
        rollout_buffer.reset()
        callback.on_rollout_start()
        parts = [[] for _ in range(env.num_envs)]
        for number, segment in env.unwrapped.collect(self.policy, n_rollout_steps):
            if segment is None:
                cut_off(parts[number], self.gamma)
                infos = [{"end": LOST}]
            else:
                parts[number].append(segment)
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
    """End a dead actor's run: its last reward gets the value of what would have followed."""
    if parts and not parts[-1].done:
        rewards = parts[-1].rewards.copy()  # Ray's arrays are read-only
        rewards[-1] += gamma * parts[-1].value
        parts[-1] = replace(parts[-1], rewards=rewards, done=True)


def fill(rollout_buffer, parts):
    """Put segments into a buffer.

    Args:
        rollout_buffer: of stable-baselines3, empty.
        parts: for each actor a list of Segments, as many actions in all as the buffer takes.
    """
    columns = [
        side_by_side(parts, name)
        for name in ("observations", "actions", "rewards", "starts", "values", "log_probs")
    ]
    for time in range(rollout_buffer.buffer_size):
        seen, actions, rewards, starts, values, log_probs = (at(time, column) for column in columns)
        rollout_buffer.add(
            seen, actions, rewards, starts, torch.as_tensor(values), torch.as_tensor(log_probs)
        )
    last = [segments[-1] for segments in parts]
    rollout_buffer.compute_returns_and_advantage(
        last_values=torch.tensor([segment.value for segment in last]),
        dones=np.array([segment.done for segment in last]),
    )


def side_by_side(parts, name):
    """Arrays (time, actor, ...) of an attribute of segments, or a dict of such."""
    found = [[getattr(segment, name) for segment in segments] for segments in parts]
    if isinstance(found[0][0], dict):
        return {
            key: np.stack([np.concatenate([part[key] for part in own]) for own in found], axis=1)
            for key in found[0][0]
        }
    return np.stack([np.concatenate(own) for own in found], axis=1)


def at(time, column):
    """The row of a time."""
    if isinstance(column, dict):
        return {key: array[time] for key, array in column.items()}
    return column[time]
