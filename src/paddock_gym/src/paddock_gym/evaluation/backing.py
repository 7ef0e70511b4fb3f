"""The tracker of cybertruck as a driver of the backing environment: the baseline."""

import numpy as np
from cybertruck.trailer.steering import IdealSteering
from cybertruck.trailer.tracker import Tracker, Tuning

from paddock_gym.envs.backing import TOP_SPEED


class TrackerDriver:
    """Backs by the law of cybertruck.trailer.tracker."""

    def __init__(self):
        self._tracker = None

    def restart(self):
        """Begin a new path."""
        self._tracker = None

    def act(self, _observation, env):
        """The action for the rig's pose."""
        geometry = env.rig.geometry
        if self._tracker is None:
            steering = IdealSteering(geometry.wheelbase, geometry.max_steering)
            self._tracker = Tracker(env.path, geometry, steering, Tuning())
        status = self._tracker.step(*env.rig.trailer(), env.rig.hitch_angle())
        return np.array(
            (float(status.steering) / geometry.max_steering, float(status.speed) / TOP_SPEED),
            np.float32,
        )
