"""PIDs: gains and their checks, the update of a joint, closed forms for stiff gains.

PID efforts that would be unstable as a constant torque over a physics step. A joint of inertia I
under tau = p (q_d - q) - d v, held constant over a step T, is stable only while d T / I and p T^2 /
I are small. Beyond that the motion of the free joint over T is known in closed form (a linear
oscillator), and the engine's velocity motor gets its mean velocity as target and |tau| as the most
it may push. A free joint then moves as the spring and damper say at any gain and step; one that
something holds is pushed with tau, as by the constant torque; one that moves more than its own
inertia (a wheel that carries a car) accelerates as tau lets it. The idea that the gains act on the
state at the step's end is that of Tan, Liu and Turk, "Stable Proportional-Derivative Controllers",
IEEE CG&A 31(4), 2011.
"""

import functools
import math
from dataclasses import dataclass
from math import inf, isfinite, nan, remainder
from typing import TYPE_CHECKING, Any, cast

from bullet_sim.component import Stateful
from bullet_sim.controllers import law
from bullet_sim.controllers.base import ControllerConfig, as_number
from bullet_sim.description.model import Joint
from bullet_sim.errors import ControllerError

if TYPE_CHECKING:
    from bullet_sim.controllers.hardware import JointHandle


def shortest_distance(start: float, end: float) -> float:
    """The shortest rotation [rad] from one angle to another, in (-pi, pi]."""
    return -remainder(start - end, law.TURN)


def limits_of(joint: Joint) -> tuple[float, float, bool]:
    """What law.position_error() has to know of a joint: its limits, whether it is prismatic."""
    lower, upper = joint.lower, joint.upper
    if lower is None or upper is None:
        lower = upper = nan
    return lower, upper, joint.kind == "prismatic"


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


@dataclass(frozen=True, kw_only=True)
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
    """A PID that commands its joint's effort, or only computes its output.

    Where the gains are stiff for the inertia that the joint's effort moves, the joint tracks the
    closed form's velocity with at most the effort instead (see the module's docstring).

    Args:
        gains: PidGains; may be replaced at any time, the state stays.
        joint: JointHandle of the errors; None: the caller has its state.
        goal: "position" or "velocity", of which the errors are.
        acts: whether it commands the joint's effort.

    Attributes:
        target: of the caller [rad, m, rad/s, m/s].
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
        "_mean",
        "_end",
    )
    CACHE = ("_gains", "_period", "_is_stiff", "_inertia", "_motion", "_share")

    def __init__(
        self,
        gains: PidGains,
        joint: "JointHandle | None" = None,
        goal: str = "position",
        acts: bool = True,
    ) -> None:
        self.gains, self.goal, self.target = gains, goal, 0.0
        self.joint = cast("JointHandle", joint)  # is there where it acts
        self._acts = acts and joint is not None
        self._gains: PidGains | None = None  # those that the following were computed for
        self._period, self._is_stiff, self._inertia = 0.0, False, 0.0
        self._motion: tuple[float, ...] = ()  # of stiff gains for a position ...
        self._share = 0.0  # ... of the error that a period corrects, of those for a velocity
        self.reset()

    def reset(self) -> None:
        """Reset integral and last error."""
        self.error = self.error_rate = self.integral = self.output = 0.0
        self.terms = (0.0, 0.0, 0.0)
        self.last_error: float | None = None
        # velocities expected of and after the last period of the closed form; None before one
        self._mean: float | None = None
        self._end = 0.0

    def update(
        self,
        error: float,
        velocity: float,
        period: float,
        goal_velocity: float | None = None,
        feedforward: float = 0.0,
        limit: float = inf,
    ) -> float:
        """Compute the output for an error and command the joint, if there is one.

        All in one piece: it runs for each joint in every physics step.

        Args:
            error: set point less measurement.
            velocity: of the joint [rad/s, m/s].
            period: since the last update, and to the next [s].
            goal_velocity: of the set point of a position [rad/s, m/s]; None: unknown, the error's
                rate is its difference to the last, 0 at the first (no jump at a start).
            feedforward: effort in addition to the PID's [N m, N].
            limit: max effort in either direction [N m, N].

        Returns:
            The output; 0, without a change of terms, when an input is not finite or no time
            passed; also 0 when the sum is not finite.
        """
        gains, joint = self.gains, self.joint
        if gains is not self._gains or period != self._period:
            if not period > 0:
                return 0.0
            self._prepare(period)
        stiff, own = self._is_stiff, velocity
        if stiff:
            if goal_velocity is not None:
                own = velocity - goal_velocity  # as seen from the goal
            rate = -own if self._motion else 0.0
        elif goal_velocity is not None:
            rate = goal_velocity - velocity
        else:
            last = self.last_error
            rate = 0.0 if last is None else (error - last) / period
        output, integral, by_error, by_integral, by_rate = law.pid_terms(
            error, rate, self.integral, period, gains.p, gains.i, gains.d, gains.i_clamp_min,
            gains.i_clamp_max, gains.antiwindup,
        )  # fmt: skip
        if not isfinite(output):
            output = 0.0
            if not (isfinite(error) and isfinite(rate)):
                self.output, self._mean = output, None
                if self._acts:
                    joint.push(output)
                return output
        self.error = self.last_error = error
        self.error_rate, self.integral, self.output = rate, integral, output
        self.terms = by_error, by_integral, by_rate
        if not self._acts:
            return output
        if not stiff:
            joint.push(min(max(output + feedforward, -limit), limit))
            return output
        by_integral += feedforward
        hardware, name = joint.hardware, joint.name
        if self._motion:
            # The engine's velocity is the mean one of its last step. The one at its end is what was
            # expected of the free motion, plus what the mean was other than expected.
            mean = self._mean
            now = own if mean is None or name not in hardware.tracked else self._end + own - mean
            phi, psi, phi_rate, psi_rate = self._motion
            start = (by_error + by_integral) / self._inertia
            self._mean = speed = (phi * now + psi * start) / period
            self._end = phi_rate * now + psi_rate * start
            effort = abs(by_error - gains.d * own + by_integral)
        else:
            speed = own + self._share * (error + by_integral / gains.p)
            effort = abs(by_error + by_integral)
        if goal_velocity is not None:
            speed += goal_velocity
        if name in hardware.efforts:
            del hardware.efforts[name]
        hardware.tracked[name] = speed, effort if effort < limit else limit
        return output

    def joint_pid(
        self, body: int, joint: int, target: float, bounds: tuple[float, float, float, float]
    ) -> law.JointPid:
        """This PID for several steps of a solver.

        Args:
            body, joint: the engine's numbers.
            target: what it follows.
            bounds: of the effort, see JointPid.
        """
        gains = self.gains
        return law.JointPid(
            body,
            joint,
            self.goal,
            target,
            limits_of(self.joint.limits),
            (gains.p, gains.i, gains.d, gains.i_clamp_min, gains.i_clamp_max, gains.antiwindup),
            bounds,
            [
                nan if self.last_error is None else self.last_error,
                *(self.integral, self.error_rate, *self.terms, self.output, 0.0),
            ],
        )

    def note(self, pid: law.JointPid) -> None:
        """The solver has computed it for several steps."""
        last, self.integral, self.error_rate, by_error, by_integral, by_rate = pid.state[:6]
        self.terms, self.output = (by_error, by_integral, by_rate), pid.output
        if not math.isnan(last):
            self.error = self.last_error = last

    def follow(self, goal: str) -> None:
        """Set what the errors are of from now on: "position" or "velocity"."""
        if goal != self.goal:
            self.goal, self._gains, self._mean = goal, None, None

    def _prepare(self, period: float) -> None:
        """Determine whether gains are stiff, and their closed form."""
        gains, joint = self.gains, self.joint
        self._gains, self._period, self._motion = gains, period, ()
        inertia = joint.inertia if self._acts else None
        if inertia is None or not is_stiff(gains, self.goal, inertia, period):
            self._is_stiff, self._mean = False, None
            return
        self._is_stiff, self._inertia = True, inertia
        if self.goal == "position":
            self._motion = oscillator(gains.p, gains.d, inertia, period)
        else:
            self._share = -math.expm1(-gains.p * period / (inertia + gains.d))


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


# Below both a constant torque is within 3 % of the closed form, and is given as it is.
SOFT_DAMPING = 0.05  # d T / I, and p T / I of a velocity
SOFT_SPRING = 0.0025  # p T^2 / I


@functools.lru_cache(maxsize=1024)
def is_stiff(gains: PidGains, goal: str, inertia: float, period: float) -> bool:
    """Whether gains are unstable or inaccurate as a constant torque over a period.

    Args:
        goal: "velocity" or "position".
        inertia: that the joint moves [kg m^2, kg].
        period: over which the effort is constant [s].
    """
    if goal == "velocity":
        return gains.p >= 0.0 and gains.d >= 0.0 and gains.p * period > SOFT_DAMPING * inertia
    if gains.p < 0.0 or gains.d < 0.0:  # no spring, no damper: nothing that could be solved
        return False
    return gains.d * period > SOFT_DAMPING * inertia or gains.p * period**2 > SOFT_SPRING * inertia


@functools.lru_cache(maxsize=1024)
def oscillator(
    p: float, d: float, inertia: float, period: float
) -> tuple[float, float, float, float]:
    """Free motion of a joint under tau = p (q_d - q) - d v over a period.

    Args:
        p, d: [N m/rad], [N m s/rad]; not negative.
        inertia: [kg m^2].
        period: [s].

    Returns:
        (phi, psi, phi_rate, psi_rate): with v the velocity and u the acceleration p (q_d - q) / I
        at its start, the joint moves by phi v + psi u and has the velocity phi_rate v + psi_rate u
        at its end.
    """
    a, square, t = d / (2.0 * inertia), p / inertia, period
    disc = a * a - square
    if abs(disc) * t * t < 1e-10:  # critically damped
        decay = math.exp(-a * t)
        phi, rate = t * decay, (1.0 - a * t) * decay
    elif disc > 0.0:
        s = math.sqrt(disc)
        slow, fast = -square / (a + s), -(a + s)
        phi = (math.exp(slow * t) - math.exp(fast * t)) / (2.0 * s)
        rate = (slow * math.exp(slow * t) - fast * math.exp(fast * t)) / (2.0 * s)
        psi = (_grown(slow, t) - _grown(fast, t)) / (2.0 * s)
        return phi, psi, rate, phi
    else:
        w, decay = math.sqrt(-disc), math.exp(-a * t)
        phi = decay * math.sin(w * t) / w
        rate = decay * (math.cos(w * t) - a / w * math.sin(w * t))
    psi = (1.0 - rate - 2.0 * a * phi) / square if square * t * t > 1e-8 else 0.5 * t * t
    return phi, psi, rate, phi


def _grown(rate: float, time: float) -> float:
    """Integral of exp(rate t) from 0 to time."""
    return math.expm1(rate * time) / rate if abs(rate * time) > 1e-12 else time
