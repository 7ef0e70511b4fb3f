"""Efforts that an engine has act on joints before each step: of a PID, or one that stays."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from bullet_sim.engine.quickstep import layout as col

MAX_RECORDED = 64  # steps for which an engine records its joints
_NO_PID = (math.nan, math.nan, 0.0, *[0.0] * 6)
_NO_STATE = (math.nan, *[0.0] * 5)


class EffortRow:
    """An effort on a joint, see quickstep.law.effort_of().

    Args:
        motor: api.Motor of the joint.
        of_force: speed and effort of law.truncated().
        bounds: limit, lower, upper, speed, soft_lower, soft_upper, k_position, k_velocity of
            law.effort_bounds().
        effort: the last one [N m, N].
        goal: what the PID's errors are of, a key of layout.GOALS; "": none, the effort stays.
        target: of the PID [rad, m, rad/s, m/s].
        pid: lower and upper limit and the way of law.position_error(); p, i, d, low, high,
            antiwindup of law.pid_terms().
        state: of the PID: last error (NaN: none), integral, rate, parts of the last output by
            error, integral and rate.

    Attributes:
        numbers: the same in the columns PID_* of layout.py; those from PID_STATE on change.
    """

    __slots__ = ("motor", "numbers")

    def __init__(
        self,
        motor: Any,
        of_force: tuple[float, float],
        bounds: Sequence[float],
        effort: float,
        goal: str = "",
        target: float = 0.0,
        pid: Sequence[float] = _NO_PID,
        state: Sequence[float] = _NO_STATE,
    ) -> None:
        self.motor = motor
        self.numbers: list[Any] = [
            0.0, *of_force, col.GOALS[goal], target, *pid, *bounds, *state, effort, 0.0
        ]  # fmt: skip

    @property
    def output(self) -> float:
        """The last output of the PID, or the effort that stays [N m, N]."""
        return self.numbers[col.PID_OUTPUT]

    @property
    def applied(self) -> float:
        """What of it acted: within the bounds and as law.truncated() lets it."""
        return self.numbers[col.PID_APPLIED]

    @property
    def pid_state(self) -> list[float]:
        """State of the PID, as the argument."""
        return self.numbers[col.PID_STATE : col.PID_OUTPUT]
