"""Teaches a robot to reach goals among obstacles by its lidar, with PPO of stable-baselines3.

    ./run setup --with learning
    ./run exec python src/paddock_gym/examples/reach_goals.py goals.onnx
    ./run drive-by goals.onnx PACKAGE FILE.launch --goal 2 1.5

The robot is examples/cart.urdf, or that of --launch "PACKAGE FILE.launch ...". What makes it learn
in minutes: runs end after 60 s, the robot does not back (its lidar looks ahead), an action lasts
0.2 s. What keeps it from obstacles: the network gets how near things are beside the ranges, which
hardly change where a few centimetres count, and the steps of the learning become smaller.
"""

import argparse
import os
import time
import warnings

import torch
from paddock_gym.envs.describe import policy_description
from paddock_gym.policy.export import export
from paddock_gym.training.worker import make
from paddock_gym.training.workers import Threads
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor

CART = os.path.join(os.path.dirname(os.path.realpath(__file__)), "cart.urdf")
RATE, LONGEST = 5.0, 60.0  # actions a second; of a run [s]
LIMITS = (0.0, -1.5), (0.8, 1.5)  # of speed and yaw rate [m/s, rad/s]
STEPS = 40_960  # actions
UNSEEN = 100_000  # seed of the first start that the training does not know
PRINT = 10.0  # [s] between lines
NEAR = 0.6  # [m] at which the nearness of an obstacle is 1 / e
ROLLOUT, BATCH = 2048, 512  # actions of an update, of a gradient step
LEARNING_RATE, LAST_RATE = 7e-4, 2e-5  # at the beginning, at the end


def options(launch="", scan="scan", command="cmd_vel"):
    """Keyword arguments of the environment."""
    robot = {"launch": launch} if launch else {"urdf": CART, "pose": (0.0, 0.0, 0.1, 0.0, 0.0, 0.0)}
    return {
        "id": "Paddock/Robot-v0",
        **robot,
        "observation": (scan,),
        "action": command,
        "limits": {command: LIMITS},
        "scaled": True,
        "task": "goal",
        "control_rate": RATE,
        "max_episode_steps": round(LONGEST * RATE),
    }


class Nearness(BaseFeaturesExtractor):
    """All observations in a row, and of the scan's ranges r [m] also exp(-r / NEAR).

    Args:
        space: Gymnasium's Dict of arrays (n,).
        scan: name of the scan, whose ranges are over their maximum.
        most: that maximum [m].
    """

    def __init__(self, space, scan, most):
        rays = space[scan].shape[0]
        super().__init__(space, rays + sum(box.shape[0] for box in space.spaces.values()))
        self._scan, self._scale = scan, most / NEAR

    def forward(self, observations):
        """(batch, features_dim) of name -> (batch, n)."""
        nearness = torch.exp(-observations[self._scan] * self._scale)
        return torch.cat([nearness, *(observations[name] for name in sorted(observations))], 1)


class Progress(BaseCallback):
    """Prints how the last hundred runs ended; ends the training after a time [s]."""

    def __init__(self, seconds):
        super().__init__()
        self._until, self._next, self._ends = time.monotonic() + seconds, 0.0, []

    def _on_step(self):
        self._ends += [info["end"] for info in self.locals["infos"] if "episode" in info]
        now, last = time.monotonic(), self._ends[-100:]
        if now > self._next and last:
            self._next = now + PRINT
            print(f"{self.num_timesteps} actions: {last.count('reached')} of {len(last)} reached")
        return now < self._until


def evaluate(model, env, count=100):
    """How runs from unseen starts end, by the policy's most probable actions: end -> how many."""
    ends = {}
    for number in range(count):
        (seen, info), over = env.reset(seed=UNSEEN + number), False
        while not over:
            action, _ = model.predict(seen, deterministic=True)
            seen, _, terminated, truncated, info = env.step(action)
            over = terminated or truncated
        ends[info["end"] or "late"] = ends.get(info["end"] or "late", 0) + 1
    return ends


def main(words=None):
    """Train, evaluate, write the policy; returns how the evaluation's runs ended."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("policy", help="ONNX file to write")
    parser.add_argument("--launch", default="", help="of a robot, in place of the cart")
    parser.add_argument("--scan", default="scan", help="topic of its lidar")
    parser.add_argument("--command", default="cmd_vel", help="topic of its Twist")
    parser.add_argument("--seconds", type=float, default=540.0, help="of training")
    parser.add_argument("--steps", type=int, default=STEPS, help="actions at most")
    parser.add_argument("--worlds", type=int, default=16, help="side by side")
    parser.add_argument("--starts", type=int, default=100, help="of the evaluation")
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args(words)
    torch.set_num_threads(1)
    chosen = options(given.launch, given.scan, given.command)
    env = make(chosen)
    most = env.unwrapped.agent.observed[given.scan].most
    worlds = Threads(chosen, given.worlds)
    worlds.seed(given.seed)
    model = PPO(
        "MultiInputPolicy",
        worlds,
        seed=given.seed,
        device="cpu",
        n_steps=max(1, ROLLOUT // given.worlds),
        batch_size=BATCH,
        learning_rate=lambda left: max(LEARNING_RATE * left, LAST_RATE),
        gamma=0.98,
        policy_kwargs={
            "net_arch": [64, 64],
            "log_std_init": -0.5,
            "features_extractor_class": Nearness,
            "features_extractor_kwargs": {"scan": given.scan, "most": most},
        },
    )
    model.learn(given.steps, callback=Progress(given.seconds))
    worlds.close()
    export(model.policy, env.observation_space, policy_description(env), given.policy)
    ends = evaluate(model, env, given.starts)
    env.close()
    print(f"{model.num_timesteps} actions; {given.starts} unseen starts: {ends}")
    return ends


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    main()
