"""Wheel speeds and odometry of gazebo_ros's drive plugins for bases with two sides."""

import math

import numpy as np

from bullet_sim.pose import Pose


class WheelDrive:
    """Wheel speeds of both sides for a command, and odometry from the wheels' angles.

    Args:
        spec: WheelDriveSpec.
    """

    def __init__(self, spec):
        self._spec = spec
        self.restart()

    def restart(self):
        """Restart at rest, odometry at zero."""
        self._speeds = np.zeros(2)  # of the rims, left and right [m/s]
        self._angles = None
        self._place = np.zeros(3)  # x, y [m], yaw [rad]
        self._twist = np.zeros(2)  # forward [m/s], left turn [rad/s]

    def wheel_speeds(self, forward, turn, elapsed):
        """Speeds [rad/s] of the left and the right wheels.

        Args:
            forward: commanded speed [m/s].
            turn: commanded turn to the left [rad/s].
            elapsed: simulated time since the last call [s], for the acceleration limit.
        """
        half = turn * self._spec.separation / 2.0
        wanted = np.array((forward - half, forward + half))
        if self._spec.acceleration > 0.0:
            most = self._spec.acceleration * elapsed
            wanted = self._speeds + np.clip(wanted - self._speeds, -most, most)
        self._speeds = wanted
        return tuple((wanted / (self._spec.diameter / 2.0)).tolist())

    def measure(self, left, right, elapsed):
        """Update with the angles [rad] of a left and a right wheel, `elapsed` s after the last."""
        angles = np.array((left, right))
        if self._angles is not None and elapsed > 0.0:
            way = (angles - self._angles) * self._spec.diameter / 2.0
            forward, turned = way.mean(), (way[1] - way[0]) / self._spec.separation
            middle = self._place[2] + turned / 2.0
            self._place += (forward * math.cos(middle), forward * math.sin(middle), turned)
            self._twist = np.array((forward, turned)) / elapsed
        self._angles = angles

    @property
    def pose(self):
        """Pose in the odometry frame by the wheels."""
        return Pose.from_xyz_rpy((self._place[0], self._place[1], 0.0), (0, 0, self._place[2]))

    @property
    def twist(self):
        """Linear (3,) [m/s] and angular (3,) [rad/s] velocity by the wheels, base's axes."""
        return (np.array((self._twist[0], 0.0, 0.0)), np.array((0.0, 0.0, self._twist[1])))
