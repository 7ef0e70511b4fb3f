"""Learning to drive: Gymnasium environments on Paddock's simulation core, without ROS.

Importing this package registers its environments where Gymnasium is installed.
"""

import importlib.util

from paddock_gym.errors import GymError
from paddock_gym.ids import IDS, ROBOT

MAX_STEPS = 3000  # actions of an episode: 200 s at 15 Hz


def register() -> None:
    """Register the environments with Gymnasium; a second call has no effect."""
    import gymnasium

    if IDS[0] not in gymnasium.registry:
        gymnasium.register(
            IDS[0],
            entry_point="paddock_gym.envs.deepracer:DeepRacerEnv",
            vector_entry_point="paddock_gym.envs.worlds:WorldsEnv",
            max_episode_steps=MAX_STEPS,
        )
        gymnasium.register(
            IDS[1],
            entry_point="paddock_gym.envs.backing:BackingEnv",
            max_episode_steps=MAX_STEPS,
        )
        gymnasium.register(
            ROBOT,
            entry_point="paddock_gym.envs.robot:RobotEnv",
            vector_entry_point="paddock_gym.envs.worlds:RobotWorldsEnv",
            max_episode_steps=MAX_STEPS,
        )


if importlib.util.find_spec("gymnasium"):  # a driver on a robot needs none
    register()

__all__ = ["IDS", "ROBOT", "GymError", "register"]
