"""Drivers that are compared in the environment."""

import math

from deepracer_control.drivers.pursuit import Path, Pursuit

from paddock_gym.policy.onnx_policy import OnnxPolicy
from paddock_gym.simulation.car import GEOMETRY

REAR_AXLE = -0.081663  # x of the rear axle from base_link [m]


class PolicyDriver:
    """A trained policy.

    Args:
        path: of its ONNX file.
    """

    def __init__(self, path):
        self.policy = OnnxPolicy(path)

    def restart(self):
        """Nothing to forget."""

    def act(self, observation, _env):
        """The action for an observation."""
        return self.policy.act(observation)


class PursuitDriver:
    """Pure pursuit along the centreline, from the true pose: the driver of ./run lap.

    Args:
        speed: on straights [m/s].
    """

    def __init__(self, speed=1.0):
        self._speed, self._pursuit, self._track = speed, None, None

    def restart(self):
        """Forget the place on the path."""
        self._pursuit = None

    def act(self, _observation, env):
        """The action at the car's pose."""
        if self._pursuit is None:
            track = env.scene.track
            path = Path(track.centreline, closed=track.closed)
            self._pursuit = Pursuit(path, max_speed=self._speed)
        motion = env.run.motion
        speed, curvature = self._pursuit.command(
            motion.x + REAR_AXLE * math.cos(motion.yaw),
            motion.y + REAR_AXLE * math.sin(motion.yaw),
            motion.yaw,
        )
        steering = math.atan(GEOMETRY.wheelbase * curvature)
        return env.options.actions.action(speed, steering)


DRIVERS = {
    "pursuit": lambda: PursuitDriver(1.0),
    "fast_pursuit": lambda: PursuitDriver(2.0),
}
