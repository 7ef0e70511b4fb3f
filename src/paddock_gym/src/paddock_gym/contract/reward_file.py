"""A user's reward_function.py, run as it is."""

from __future__ import annotations

import importlib.util
import math
import numbers
import os
import pprint
import sys
import traceback
from typing import Any

from paddock_gym.errors import GymError, RewardError

FUNCTION = "reward_function"
CRASH_REWARD = 1e-8  # AWS's


class RewardFile:
    """The reward function of a file.

    Args:
        path: of a Python file with reward_function(params).

    Raises:
        GymError: it cannot be loaded, or has no such function.
    """

    def __init__(self, path: str) -> None:
        self.path = os.path.abspath(path)
        if not os.path.isfile(self.path):
            raise GymError(f"reward is {path!r}; it must be progress, or a Python file")
        spec: Any = importlib.util.spec_from_file_location("user_reward_function", self.path)
        module = importlib.util.module_from_spec(spec)
        folder = os.path.dirname(self.path)
        if folder not in sys.path:
            sys.path.append(folder)  # for what it imports from beside it; Python's own comes first
        try:
            spec.loader.exec_module(module)
        except Exception as error:
            raise GymError(
                f"{path} cannot be loaded:\n{_users_traceback(error, self.path)}"
            ) from error
        self._function: Any = getattr(module, FUNCTION, None)
        if not callable(self._function):
            raise GymError(f"{path} has no function {FUNCTION}(params)")

    def reward(self, params: dict[str, Any]) -> float:
        """The reward for some params.

        Raises:
            RewardError: the function raised something, or its reward is not a finite number.
        """
        if params["is_crashed"]:
            return CRASH_REWARD
        try:
            reward = self._function(params)
        except Exception as error:
            raise RewardError(
                f"{FUNCTION} of {self.path} failed:\n{_users_traceback(error, self.path)}"
                f"params were:\n{_format_params(params)}"
            ) from error
        if not isinstance(reward, numbers.Real) or not math.isfinite(reward):
            raise RewardError(
                f"{FUNCTION} of {self.path} returned {reward!r}; it must be a finite number\n"
                f"params were:\n{_format_params(params)}"
            )
        return float(reward)


def _users_traceback(error: BaseException, path: str) -> str:
    """The traceback from the user's file on."""
    trace = error.__traceback__
    while trace is not None and trace.tb_frame.f_code.co_filename != path:
        trace = trace.tb_next
    return "".join(traceback.format_exception(type(error), error, trace))


def _format_params(params: dict[str, Any]) -> str:
    short = dict(params, waypoints=f"<{len(params['waypoints'])} points>")
    return pprint.pformat(short, sort_dicts=False)
