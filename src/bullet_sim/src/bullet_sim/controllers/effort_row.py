"""What computes a joint's effort before each of several steps that a solver makes in one call."""

from __future__ import annotations

import math
from dataclasses import dataclass

MAX_NOTED_STEPS = 64  # steps in one call of a solver that notes what is before each
NO_LIMITS = (math.nan, math.nan, False)
NO_GAINS = (0.0, 0.0, 0.0, 0.0, 0.0, False)


@dataclass
class EffortRow:
    """A PID that computes a joint's effort, or an effort alone; see law.py.

    Attributes:
        body, joint: the engine's numbers.
        goal: "position" or "velocity", of which the errors are; "": an effort alone.
        target: [rad, m, rad/s, m/s].
        limits: lower, upper of position_error(), and whether the joint is prismatic.
        gains: p, i, d, low, high, antiwindup of pid_terms().
        bounds: limit, lower, upper, speed of effort_bounds().
        of_force: speed and effort of truncated().
        state: last error (NaN: none), integral, rate, parts by error, integral and rate of the
            last output, the last output, and what of it was within the bounds.
    """

    body: int
    joint: int
    goal: str
    target: float
    limits: tuple[float, float, bool]
    gains: tuple[float, float, float, float, float, bool]
    bounds: tuple[float, float, float, float]
    of_force: tuple[float, float]
    state: list[float]

    @property
    def output(self) -> float:
        """The last output."""
        return self.state[6]

    @property
    def applied(self) -> float:
        """What of it was within the bounds."""
        return self.state[7]


def constant_row(
    body: int,
    joint: int,
    effort: float,
    bounds: tuple[float, float, float, float],
    of_force: tuple[float, float],
) -> EffortRow:
    """The row of an effort [N m, N] alone."""
    state = [math.nan, *[0.0] * 5, effort, 0.0]
    return EffortRow(body, joint, "", 0.0, NO_LIMITS, NO_GAINS, bounds, of_force, state)
