"""Controllers: the registry of their types, their configuration and what they do."""

from bullet_sim.controllers import drive, four_wheel, gripper, joint, trajectory
from bullet_sim.controllers.base import (
    CONTROLLERS,
    MAX_COMMAND,
    Controller,
    check_command,
    configure,
)
from bullet_sim.controllers.settings import ControllerConfig, Settings

__all__ = [
    "CONTROLLERS",
    "MAX_COMMAND",
    "Controller",
    "ControllerConfig",
    "Settings",
    "check_command",
    "configure",
    "drive",
    "four_wheel",
    "gripper",
    "joint",
    "trajectory",
]
