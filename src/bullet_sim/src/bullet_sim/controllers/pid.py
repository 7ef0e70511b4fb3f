"""PIDs: gains and terms, servos for stiff gains, the update of a joint.

PID efforts that would be unstable as a constant torque over a physics step. A joint of inertia I
under tau = p (q_d - q) - d v, held constant over a step T, is stable only while d T / I and p T^2 /
I are small. Beyond that the motion of the free joint over T is known in closed form (a linear
oscillator), and the engine's velocity motor gets its mean velocity as target and |tau| as the most
it may push. A free joint then moves as the spring and damper say at any gain and step; one that
something holds is pushed with tau, as by the constant torque; one that moves more than its own
inertia (a wheel that carries a car) accelerates as tau lets it. The idea that the gains act on the
state at the step's end is that of Tan, Liu and Turk, "Stable Proportional-Derivative Controllers",
IEEE CG&A 31(4), 2011.

One joint of a PID controller with efforts: set point in, effort out. Controllers run in every
physics step, thousands of times a second, and a call of a function costs Python as much as what it
computes. So an update of a joint whose gains are stiff is one piece here, and calls none of
Pid.compute, position_error, PositionServo.target, VelocityServo.target. It gives what they give, to
the bit; where it is not the usual case, they are called (`_update_plainly`).
"""

import functools
import math
from dataclasses import dataclass
from math import isfinite, remainder

from bullet_sim.controllers.base import as_number
from bullet_sim.errors import ControllerError

TOLERANCE = 1e-9  # [rad] by which rounding may put an angle beyond a limit


def shortest_distance(start, end):
    """The shortest turn [rad] from one angle to another, in (-pi, pi]."""
    return -math.remainder(start - end, 2.0 * math.pi)


def distance_within(start, end, lower, upper):
    """The shortest turn [rad] to an angle (up to whole turns) that stays within limits.

    Args:
        start: where the joint is [rad].
        end: where it shall go, within the limits [rad].
        lower, upper: limits [rad].

    Returns:
        The shorter way round if it ends within the limits, else the longer one if that does, else
        end - start.
    """
    short = shortest_distance(start, end)
    long = short - math.copysign(2.0 * math.pi, short)
    for turn in (short, long):
        if lower - TOLERANCE <= start + turn <= upper + TOLERANCE:
            return turn
    return end - start


def position_error(joint, position, target):
    """Error [rad, m] of a joint's position, as ros_control's position controllers see it.

    Args:
        joint: bullet_sim.description.model.Joint.
        position, target: [rad, m]; a target beyond the joint's limits counts as the limit.
    """
    if joint.lower is not None:
        target = min(max(target, joint.lower), joint.upper)
    if joint.kind == "prismatic":
        return target - position
    if joint.lower is None:
        return shortest_distance(position, target)
    return distance_within(position, target, joint.lower, joint.upper)


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


# Below both a constant torque is within 3 % of the closed form, and is given as it is.
SOFT_DAMPING = 0.05  # d T / I, and p T / I of a velocity
SOFT_SPRING = 0.0025  # p T^2 / I


@functools.lru_cache(maxsize=1024)
def is_stiff(gains, goal, inertia, period):
    """Whether gains are unstable or inaccurate as a constant torque over a period.

    Args:
        gains: PidGains that give an effort.
        goal: "velocity" or "position".
        inertia: that the joint moves [kg m^2, kg].
        period: over which the effort is held [s].
    """
    if goal == "velocity":
        return gains.p >= 0.0 and gains.d >= 0.0 and gains.p * period > SOFT_DAMPING * inertia
    if gains.p < 0.0 or gains.d < 0.0:  # no spring, no damper: nothing that could be solved
        return False
    return gains.d * period > SOFT_DAMPING * inertia or gains.p * period**2 > SOFT_SPRING * inertia


@functools.lru_cache(maxsize=1024)
def oscillator(p, d, inertia, period):
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


def _grown(rate, time):
    """Integral of exp(rate t) from 0 to time."""
    return math.expm1(rate * time) / rate if abs(rate * time) > 1e-12 else time


class PositionServo:
    """Spring and damper of one joint towards a position.

    Args:
        inertia: that the joint moves [kg m^2, kg].

    Attributes:
        mean, end: velocities expected of and after the last period; None before it.
        gains, period: of the last update.
        motion: result of oscillator for these.
    """

    goal = "position"

    def __init__(self, inertia):
        self.inertia = inertia
        self.mean = self.end = None
        self.gains = self.period = self.motion = None

    def target(self, gains, error, velocity, by_integral, period):
        """Velocity that the motor is to track for a period, and how strong it may be.

        The engine's velocity is the mean one of its last step. The one at its end is what was
        expected of the free motion, plus what the mean was other than expected.

        Args:
            gains: PidGains.
            error: set point less position [rad, m].
            velocity: measured [rad/s, m/s].
            by_integral: effort of the integral term [N m, N].
            period: [s].

        Returns:
            Velocity [rad/s, m/s], effort [N m, N].
        """
        now = velocity if self.mean is None else self.end + velocity - self.mean
        if gains is not self.gains or period != self.period:
            self.gains, self.period = gains, period
            self.motion = oscillator(gains.p, gains.d, self.inertia, period)
        phi, psi, phi_rate, psi_rate = self.motion
        start = (gains.p * error + by_integral) / self.inertia
        self.mean = (phi * now + psi * start) / period
        self.end = phi_rate * now + psi_rate * start
        return self.mean, abs(gains.p * error - gains.d * velocity + by_integral)


class VelocityServo:
    """The same towards a velocity: tau = p (v_d - v); d adds to the inertia.

    Attributes:
        gains, period: of the last update.
        share: of the error, that a period corrects with these.
    """

    goal = "velocity"

    def __init__(self, inertia):
        self.inertia = inertia
        self.gains = self.period = self.share = None

    def target(self, gains, error, velocity, by_integral, period):
        """As PositionServo.target; the error is one of velocity."""
        if gains is not self.gains or period != self.period:
            self.gains, self.period = gains, period
            self.share = -math.expm1(-gains.p * period / (self.inertia + gains.d))
        wanted = velocity + self.share * (error + by_integral / gains.p)
        return wanted, abs(gains.p * error + by_integral)


SERVOS = {"position": PositionServo, "velocity": VelocityServo}


_TURN = 2.0 * math.pi


class PidLoop:
    """Regulates a joint by efforts.

    Args:
        hardware: Hardware of the robot.
        joint: its name.
        pid: its Pid.

    Attributes:
        target: set point [rad, m, rad/s, m/s].
        last: fields of the last update's Sample, or None.
    """

    goal = None  # "position" or "velocity"

    def __init__(self, hardware, joint, pid):
        self._hardware, self._joint, self._pid = hardware, joint, pid
        self._limits, self._tracked = hardware.limits[joint], hardware.tracked
        self._servo = None  # of stiff gains, from the last update
        self._soft = None  # (gains, period) that give a constant effort, from the last update
        self.target, self.last = 0.0, None

    def reset(self):
        """Begin anew."""
        self.forget()
        self.last = None

    def forget(self):
        """The joint is no longer regulated."""
        self._servo = self._soft = None

    def update(self, state, time, period):
        """Compute the joint's effort and command it.

        Args:
            state: Hardware.state().
            time: now [s].
            period: since the last update [s].
        """

    def _update_plainly(self, target, value, moving, error, velocity, time, period):
        """The update of any gains and any numbers, beginning with the error."""
        joint, pid, hardware, soft = self._joint, self._pid, self._hardware, self._soft
        gains = pid.gains
        if soft is not None and soft[0] is gains and soft[1] == period:
            hardware.constant[joint] = pid.compute(error, period) + 0.0  # as regulate()
        else:
            hardware.regulate(joint, pid, self.goal, error, velocity, period)
            servo = hardware.servo(joint)
            self._soft = (gains, period) if servo is None else None
            self._servo = None if gains.antiwindup else servo
        self.last = time, period, target, value, moving, error, pid.output


class PositionLoop(PidLoop):
    """Towards a position."""

    goal = "position"

    def __init__(self, hardware, joint, pid):
        super().__init__(hardware, joint, pid)
        self._is_prismatic = self._limits.kind == "prismatic"

    def update(self, state, time, period):
        positions, velocities = state
        joint, limits, target = self._joint, self._limits, self.target
        position, velocity, lower = positions[joint], velocities[joint], limits.lower
        if lower is not None:
            target = min(max(target, lower), limits.upper)
        if self._is_prismatic:
            error = target - position
        else:
            error = -remainder(position - target, _TURN)
            if lower is not None and not (
                lower - TOLERANCE <= position + error <= limits.upper + TOLERANCE
            ):
                error = position_error(limits, position, target)
        pid, servo = self._pid, self._servo
        gains = pid.gains
        if servo is None or servo.gains is not gains or servo.period != period:
            self._update_plainly(target, position, velocity, error, velocity, time, period)
            return
        p, i, d = gains.p, gains.i, gains.d
        integral = pid.integral + error * period
        by_integral = i * integral
        if by_integral < gains.i_clamp_min:
            by_integral = gains.i_clamp_min
        elif by_integral > gains.i_clamp_max:
            by_integral = gains.i_clamp_max
        by_error, by_rate = p * error, d * -velocity
        output = 0.0 + by_error + by_integral + by_rate
        if not isfinite(output):
            self._update_plainly(target, position, velocity, error, velocity, time, period)
            return
        pid.error = pid.last_error = error
        pid.error_rate, pid.integral, pid.output = -velocity, integral, output
        pid.terms = by_error, by_integral, by_rate
        by_integral += 0.0  # -0 becomes 0, as in regulate()
        mean = servo.mean
        now = velocity if mean is None else servo.end + velocity - mean
        phi, psi, phi_rate, psi_rate = servo.motion
        start = (by_error + by_integral) / servo.inertia
        servo.mean = mean = (phi * now + psi * start) / period
        servo.end = phi_rate * now + psi_rate * start
        self._tracked[joint] = mean, abs(by_error - d * velocity + by_integral)
        self.last = time, period, target, position, velocity, error, output


class VelocityLoop(PidLoop):
    """Towards a velocity."""

    goal = "velocity"

    def update(self, state, time, period):
        joint, target = self._joint, self.target
        velocity = state[1][joint]
        error = target - velocity
        pid, servo = self._pid, self._servo
        gains = pid.gains
        if servo is None or servo.gains is not gains or servo.period != period:
            self._update_plainly(target, velocity, 0.0, error, velocity, time, period)
            return
        integral = pid.integral + error * period
        by_integral = gains.i * integral
        if by_integral < gains.i_clamp_min:
            by_integral = gains.i_clamp_min
        elif by_integral > gains.i_clamp_max:
            by_integral = gains.i_clamp_max
        by_error = gains.p * error
        output = 0.0 + by_error + by_integral
        if not isfinite(output):
            self._update_plainly(target, velocity, 0.0, error, velocity, time, period)
            return
        pid.error = pid.last_error = error
        pid.error_rate, pid.integral, pid.output = 0.0, integral, output
        pid.terms = by_error, by_integral, 0.0
        wanted = velocity + servo.share * (error + by_integral / gains.p)
        self._tracked[joint] = wanted, abs(by_error + by_integral)
        self.last = time, period, target, velocity, 0.0, error, output


LOOPS = {"position": PositionLoop, "velocity": VelocityLoop}
