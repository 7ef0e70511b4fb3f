"""One joint of a PID controller with efforts: set point in, effort out.

Controllers run in every physics step, thousands of times a second, and a call of a function costs
Python as much as what it computes. So an update of a joint whose gains are stiff is one piece here,
and calls none of Pid.compute, position_error, PositionServo.target, VelocityServo.target. It gives
what they give, to the bit; where it is not the usual case, they are called (`_update_plainly`).
"""

import math
from math import isfinite, remainder

from bullet_sim.controllers.angles import TOLERANCE, position_error

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
