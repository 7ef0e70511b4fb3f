"""PIDs: gains and their checks, and one computation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite, isnan, nan, remainder
from typing import Any

from bullet_sim.component import Stateful
from bullet_sim.controllers.settings import ControllerConfig, as_number
from bullet_sim.description.model import Joint
from bullet_sim.engine.api import Motor
from bullet_sim.engine.efforts import EffortRow
from bullet_sim.engine.quickstep import law
from bullet_sim.errors import ControllerError


def shortest_distance(start: float, end: float) -> float:
    """The shortest rotation [rad] from one angle to another, in (-pi, pi]."""
    return -remainder(start - end, law.TURN)


def limits_of(joint: Joint) -> tuple[float, float, float]:
    """What law.position_error() has to know of a joint: its limits and the way."""
    lower, upper = joint.lower, joint.upper
    if lower is None or upper is None:
        lower = upper = nan
    return lower, upper, law.WAY_LINEAR if joint.kind == "prismatic" else law.WAY_SHORT


def position_error(joint: Joint, position: float, target: float) -> float:
    """Error [rad, m] of a joint's position, see law.position_error()."""
    return law.position_error(position, target, *limits_of(joint))


NUMBERS = ("p", "i", "d", "i_clamp", "i_clamp_max", "i_clamp_min")
MAX_GAIN = 1e15  # of p, i, d: what is computed with them stays finite
KEYS = NUMBERS + ("antiwindup", "publish_state")


@dataclass(frozen=True)
class PidGains:
    """Gains and the bounds of the integral term's contribution.

    Attributes:
        p, i, d: output per unit of error, of its integral [s] and of its rate [1/s].
        i_clamp_min, i_clamp_max: bounds of i times the integral, min <= 0 <= max; both 0 (the
            default) leave nothing of the integral term, as upstream.
        antiwindup: bound the stored integral, too, so that it does not wind up behind the bounds.
    """

    p: float
    i: float = 0.0
    d: float = 0.0
    i_clamp_min: float = 0.0
    i_clamp_max: float = 0.0
    antiwindup: bool = False


@dataclass(frozen=True)
class PidConfig(ControllerConfig):
    """Configuration of a controller whose joints may have PIDs.

    Attributes:
        gains: of each joint; none where the type has no PID.
        gain_names: of their parameters below the controller's.
        publish_pid: whether each joint's PID publishes its inner state.
    """

    gains: tuple[PidGains, ...] = ()
    gain_names: tuple[str, ...] = ()
    publish_pid: tuple[bool, ...] = ()


class Pid(Stateful):
    """A PID, as control_toolbox's.

    Args:
        gains: PidGains; may be replaced at any time, the state stays.
        goal: "position" or "velocity", of which the errors are.

    Attributes:
        target: its set point, where it has one [rad, m, rad/s, m/s].
        error, error_rate, integral: of the last update.
        terms: (p, i, d) parts of the last output.
        output: the last output.
        last_error: what the next rate is a difference to, or None.
    """

    STATE = (
        "gains",
        "goal",
        "target",
        "error",
        "error_rate",
        "integral",
        "output",
        "terms",
        "last_error",
    )

    def __init__(self, gains: PidGains, goal: str = "position") -> None:
        self.gains, self.goal, self.target = gains, goal, 0.0
        self.reset()

    def reset(self) -> None:
        """Reset integral and last error."""
        self.error = self.error_rate = self.integral = self.output = 0.0
        self.terms = (0.0, 0.0, 0.0)
        self.last_error: float | None = None

    def update(self, error: float, period: float, error_rate: float | None = None) -> float:
        """Compute the command for an error.

        Args:
            error: set point less measurement.
            period: since the last update, and to the next [s].
            error_rate: None: the difference of the error to the last, 0 at the first (no jump at a
                start).

        Returns:
            The output; 0, without a change of terms, when an input is not finite or no time
            passed; also 0 when the sum is not finite.
        """
        if not period > 0:
            return 0.0
        gains, rate = self.gains, error_rate
        if rate is None:
            last = self.last_error
            rate = 0.0 if last is None else (error - last) / period
        output, integral, by_error, by_integral, by_rate = law.pid_terms(
            error, rate, self.integral, period, gains.p, gains.i, gains.d, gains.i_clamp_min,
            gains.i_clamp_max, gains.antiwindup,
        )  # fmt: skip
        if not isfinite(output):
            output = 0.0
            if not (isfinite(error) and isfinite(rate)):
                self.output = output
                return output
        self.error = self.last_error = error
        self.error_rate, self.integral, self.output = rate, integral, output
        self.terms = by_error, by_integral, by_rate
        return output

    def row(
        self,
        motor: Motor,
        limits: tuple[float, float, float],
        of_force: tuple[float, float],
        bounds: Sequence[float],
    ) -> EffortRow:
        """This PID of a joint's effort, for several steps of an engine; arguments of EffortRow.

        Args:
            limits: see limits_of().
        """
        gains, last = self.gains, self.last_error
        return EffortRow(
            motor,
            of_force,
            bounds,
            self.output,
            self.goal,
            self.target,
            (*limits, gains.p, gains.i, gains.d, gains.i_clamp_min, gains.i_clamp_max,
             gains.antiwindup),
            (nan if last is None else last, self.integral, self.error_rate, *self.terms),
        )  # fmt: skip

    def take_state(self, row: EffortRow) -> None:
        """An engine has computed it for several steps."""
        last, self.integral, self.error_rate, by_error, by_integral, by_rate = row.pid_state
        self.terms, self.output = (by_error, by_integral, by_rate), row.output
        if not isnan(last):
            self.error = self.last_error = last


def parse_pid(values: Any, label: str, warnings: list[str] | None = None) -> PidGains:
    """Check a `pid` mapping.

    Args:
        values: mapping with p, i, d, and i_clamp or i_clamp_min and i_clamp_max.
        warnings: list to which a message per unknown key is added; None: none.

    Raises:
        ControllerError: not a mapping, not a finite number, a gain beyond MAX_GAIN, no p.
    """
    if not isinstance(values, dict):
        raise ControllerError(f"{label} pid is {values!r}, must be a mapping with p, i, d")
    if warnings is not None:
        warnings.extend(
            f"{label} pid has key '{key}', which is not one of {', '.join(KEYS)}; it is ignored"
            for key in sorted(set(values) - set(KEYS), key=str)
        )
    if "p" not in values:
        raise ControllerError(f"{label} pid has no p")
    numbers: dict[str, float] = {}
    for key in NUMBERS:
        number = as_number(values.get(key, 0.0))
        if number is None:
            raise ControllerError(f"{label} pid {key} is {values[key]!r}, must be a finite number")
        if key in ("p", "i", "d") and abs(number) > MAX_GAIN:
            raise ControllerError(
                f"{label} pid {key} is {values[key]!r}, must be from {-MAX_GAIN:g} to {MAX_GAIN:g}"
            )
        numbers[key] = number
    antiwindup = values.get("antiwindup", False)
    if not isinstance(antiwindup, bool):
        raise ControllerError(f"{label} pid antiwindup is {antiwindup!r}, must be true or false")
    low = numbers["i_clamp_min"] if "i_clamp_min" in values else numbers["i_clamp"]
    high = numbers["i_clamp_max"] if "i_clamp_max" in values else numbers["i_clamp"]
    return PidGains(numbers["p"], numbers["i"], numbers["d"], -abs(low), abs(high), antiwindup)
