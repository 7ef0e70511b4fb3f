"""Drivers that are compared in the environment."""

import math

from deepracer_control.drivers.pursuit import Path, Pursuit
from track_model.referee.rules import Car

from paddock_gym.ids import DEEPRACER
from paddock_gym.policy.onnx_policy import OnnxPolicy
from paddock_gym.simulation.car import GEOMETRY

REAR_AXLE = Car().rear  # x of the rear axle from base_link [m]


class PolicyDriver:
    """A trained policy.

    Args:
        path: of its ONNX file.
        env: as of OnnxPolicy.
    """

    def __init__(self, path, env=DEEPRACER):
        self.policy = OnnxPolicy(path, env)

    def restart(self):
        """Nothing to forget."""

    def act(self, observation, _env):
        """The action for an observation."""
        return self.policy.act(observation)


class PursuitDriver:
    """Pure pursuit along the centreline, from the true pose: the driver of ./run lap.

    Args:
        max_speed: on straights [m/s].
        gains: lookahead [m], max_lateral_acceleration [m/s^2] of Pursuit.
    """

    def __init__(self, max_speed=1.0, **gains):
        self._gains, self._pursuit = dict(gains, max_speed=max_speed), None

    def restart(self):
        """Forget the place on the path."""
        self._pursuit = None

    def act(self, _observation, env):
        """The action at the car's pose."""
        if self._pursuit is None:
            track = env.scene.track
            path = Path(track.centreline, closed=track.closed)
            self._pursuit = Pursuit(path, **self._gains)
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
