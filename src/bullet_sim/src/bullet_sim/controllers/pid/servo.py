"""PID efforts that would be unstable as a constant torque over a physics step.

A joint of inertia I under tau = p (q_d - q) - d v, held constant over a step T, is stable only
while d T / I and p T^2 / I are small. Beyond that the motion of the free joint over T is known in
closed form (a linear oscillator), and the engine's velocity motor gets its mean velocity as target
and |tau| as the most it may push. A free joint then moves as the spring and damper say at any gain
and step; one that something holds is pushed with tau, as by the constant torque; one that moves
more than its own inertia (a wheel that carries a car) accelerates as tau lets it. The idea that the
gains act on the state at the step's end is that of Tan, Liu and Turk, "Stable
Proportional-Derivative Controllers", IEEE CG&A 31(4), 2011.
"""

import functools
import math

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
