"""Errors of the gym."""


class GymError(ValueError):
    """An option or a user's file is wrong; the message names item, value and what is valid."""


class RewardError(RuntimeError):
    """A user's reward function failed; the message has its traceback and the params."""
