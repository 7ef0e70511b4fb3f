"""PID as ros_control's control_toolbox computes it, and the checks of its gains."""

import math
from dataclasses import dataclass

from bullet_sim.controllers.settings import as_number
from bullet_sim.errors import ControllerError

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


class Pid:
    """State of a PID: the integral and the last error.

    Args:
        gains: PidGains; may be replaced at any time, the state stays.

    Attributes:
        error, error_rate, integral: of the last computation.
        terms: (p, i, d) parts of the last output.
        output: the last output.
        last_error: what the next rate is a difference to, or None.
    """

    def __init__(self, gains):
        self.gains = gains
        self.reset()

    def reset(self):
        """Reset integral and last error."""
        self.error = self.error_rate = self.integral = self.output = 0.0
        self.terms = (0.0, 0.0, 0.0)
        self.last_error = None

    def compute(self, error, period, error_rate=None, gains=None):
        """Output for an error.

        Args:
            error: set point minus measurement.
            period: time since the last computation [s].
            error_rate: known rate of the error [1/s]; None: the difference to the last error, 0
                at the first one (no jump at a start).
            gains: PidGains to use instead of its own.

        Returns:
            The output; 0, without a change of state, when an input is not finite or no time passed;
            also 0 when the sum is not finite.
        """
        if not period > 0:
            return 0.0
        if error_rate is None:
            last = self.last_error
            error_rate = 0.0 if last is None else (error - last) / period
        gains = gains or self.gains
        integral = self.integral + error * period
        if gains.antiwindup and gains.i != 0:
            bounds = sorted((gains.i_clamp_min / gains.i, gains.i_clamp_max / gains.i))
            integral = min(max(integral, bounds[0]), bounds[1])
        by_integral = gains.i * integral
        if by_integral < gains.i_clamp_min:
            by_integral = gains.i_clamp_min
        elif by_integral > gains.i_clamp_max:
            by_integral = gains.i_clamp_max
        by_error, by_rate = gains.p * error, gains.d * error_rate
        output = 0.0 + by_error + by_integral + by_rate
        if not math.isfinite(output):
            if not (math.isfinite(error) and math.isfinite(error_rate)):
                return 0.0
            output = 0.0
        self.error, self.error_rate, self.last_error = error, error_rate, error
        self.integral, self.terms = integral, (by_error, by_integral, by_rate)
        self.output = output
        return output


def parse_pid(values, what, warnings=None):
    """Check a `pid` mapping.

    Args:
        values: mapping with p, i, d, and i_clamp or i_clamp_min and i_clamp_max.
        what: name for messages.
        warnings: list to which a sentence per unknown key is added; None: none.

    Raises:
        ControllerError: not a mapping, not a finite number, a gain beyond MAX_GAIN, no p.
    """
    if not isinstance(values, dict):
        raise ControllerError(f"{what} pid is {values!r}, must be a mapping with p, i, d")
    if warnings is not None:
        warnings.extend(
            f"{what} pid has key '{key}', which is not one of {', '.join(KEYS)}; it is ignored"
            for key in sorted(set(values) - set(KEYS), key=str)
        )
    if "p" not in values:
        raise ControllerError(f"{what} pid has no p")
    numbers = {}
    for key in NUMBERS:
        numbers[key] = as_number(values.get(key, 0.0))
        if numbers[key] is None:
            raise ControllerError(f"{what} pid {key} is {values[key]!r}, must be a finite number")
        if key in ("p", "i", "d") and abs(numbers[key]) > MAX_GAIN:
            raise ControllerError(
                f"{what} pid {key} is {values[key]!r}, must be from {-MAX_GAIN:g} to {MAX_GAIN:g}"
            )
    antiwindup = values.get("antiwindup", False)
    if not isinstance(antiwindup, bool):
        raise ControllerError(f"{what} pid antiwindup is {antiwindup!r}, must be true or false")
    low = numbers["i_clamp_min"] if "i_clamp_min" in values else numbers["i_clamp"]
    high = numbers["i_clamp_max"] if "i_clamp_max" in values else numbers["i_clamp"]
    return PidGains(numbers["p"], numbers["i"], numbers["d"], -abs(low), abs(high), antiwindup)
