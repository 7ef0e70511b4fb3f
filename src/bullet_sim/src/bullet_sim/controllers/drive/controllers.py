"""Controllers of whole bases: velocity in, wheel speeds and odometry out."""

import math

from bullet_sim.controllers.drive.odometry import Odometry
from bullet_sim.controllers.joint_control import Controller


class Drive(Controller):
    """Base class of both kinds of bases: time-out, limits, odometry.

    Attributes:
        odometry: Odometry.
        limited: (forward [m/s], turning) command after the limits.
    """

    periodic = True

    def __init__(self, spec, hardware):
        super().__init__(spec, hardware)
        self.odometry = Odometry(spec.drive.window)
        self._forget()

    def _forget(self):
        self.limited = self._before = (0.0, 0.0)
        self._wanted, self._age, self._written = (0.0, 0.0), math.inf, None

    def start(self, time):
        """Start at rest and continue the odometry."""
        self._forget()
        self._positions = dict(zip(self.spec.joints, self.hardware.positions_of(self.spec.joints)))
        self._time = time
        self.odometry.start(time)
        self._write_once(self._outputs(0.0, 0.0))

    def restart(self, time):
        """Restart at the origin."""
        self.odometry.reset(time)
        self.start(time)

    def command(self, values):
        """Set (forward [m/s], turning); valid until the time-out."""
        self._wanted, self._age = values, 0.0

    def brake(self):
        """Drop the command: the base slows down within its limits."""
        self._wanted = (0.0, 0.0)

    def update(self, state, time, period):
        """Odometry, then wheel speeds within the limits."""
        self.observe(state, time)
        drive = self.spec.drive
        wanted = self._wanted if self._age <= drive.timeout else (0.0, 0.0)
        self._age += period
        now = tuple(
            limiter.limit(value, last, before, period)
            for limiter, value, last, before in zip(
                (drive.linear, drive.angular), wanted, self.limited, self._before
            )
        )
        self._before, self.limited = self.limited, now
        self._write_once(self._outputs(*now))

    def observe(self, state, time):
        """Update the odometry to a state."""
        if self.spec.drive.open_loop:
            period = time - self._time
            distance, turn = (v * period for v in self._motion(*self.limited))
        else:
            positions = state[0]
            distance, turn = self._travelled(
                {joint: positions[joint] - self._positions[joint] for joint in self.spec.joints},
                positions,
            )
            self._positions = {joint: positions[joint] for joint in self.spec.joints}
        self._time = time
        self.odometry.move(distance, turn, time)

    def _write_once(self, outputs):
        if outputs != self._written:
            self._written = outputs
            self._write(outputs)


class DiffDrive(Drive):
    """Left and right wheels; commands are m/s forward and rad/s to the left."""

    def _outputs(self, linear, angular):
        drive = self.spec.drive
        across = angular * drive.separation / 2
        return (linear - across) / drive.radii[0], (linear + across) / drive.radii[1]

    def _write(self, outputs):
        drive = self.spec.drive
        self.hardware.velocities(
            self.spec.joints, (outputs[0],) * len(drive.left) + (outputs[1],) * len(drive.right)
        )

    def _motion(self, linear, angular):
        return linear, angular

    def _travelled(self, turned, _):
        drive = self.spec.drive
        left, right = (
            radius * math.fsum(turned[joint] for joint in joints) / len(joints)
            for radius, joints in zip(drive.radii, (drive.left, drive.right))
        )
        return (left + right) / 2, (right - left) / drive.separation


class Ackermann(Drive):
    """One rear wheel and one steering joint; commands are m/s forward and the steering angle.

    As upstream, the second number of the command is an angle [rad] and no rate. Unlike upstream
    the odometry of open_loop uses it as an angle, too.
    """

    def _outputs(self, linear, angle):
        return linear / self.spec.drive.radii[1], angle

    def _write(self, outputs):
        drive = self.spec.drive
        self.hardware.velocities(drive.left, outputs[:1])
        self.hardware.positions(drive.right, outputs[1:])

    def _motion(self, linear, angle):
        return linear, linear * math.tan(angle) / self.spec.drive.separation

    def _travelled(self, turned, positions):
        drive = self.spec.drive
        distance = turned[drive.left[0]] * drive.radii[0]
        angle = positions[drive.right[0]] * drive.steer_multiplier
        return distance, distance * math.tan(angle) / drive.separation
