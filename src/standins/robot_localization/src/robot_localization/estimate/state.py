"""The 15 numbers of the state: what they are called and where they stand."""

from dataclasses import dataclass

import numpy as np

NAMES = (
    "x",
    "y",
    "z",
    "roll",
    "pitch",
    "yaw",
    "x_velocity",
    "y_velocity",
    "z_velocity",
    "roll_velocity",
    "pitch_velocity",
    "yaw_velocity",
    "x_acceleration",
    "y_acceleration",
    "z_acceleration",
)
SIZE = len(NAMES)
POSITION = slice(0, 3)  # in the world frame [m]
ANGLES = slice(3, 6)  # roll, pitch, yaw in the world frame [rad]
POSE = slice(0, 6)
VELOCITY = slice(6, 9)  # in the robot's frame [m/s]
RATES = slice(9, 12)  # in the robot's frame [rad/s]
TWIST = slice(6, 12)
ACCELERATION = slice(12, 15)  # in the robot's frame [m/s^2]
OUT_OF_PLANE = (2, 3, 4, 8, 9, 10, 14)  # z, roll, pitch and their rates, z acceleration

# Upstream's default: variances that grow in each second.
PROCESS_NOISE = np.diag(
    (0.05, 0.05, 0.06, 0.03, 0.03, 0.06, 0.025, 0.025, 0.04, 0.01, 0.01, 0.02, 0.01, 0.01, 0.015)
)


@dataclass(frozen=True)
class Measurement:
    """Some of the state's numbers, measured.

    Attributes:
        source: Name of the input.
        time: When it was measured [s].
        index: (n,) which numbers of the state.
        value: (n,).
        covariance: (n, n).
        threshold: Mahalanobis distance from which on it counts as an outlier.
    """

    source: str
    time: float
    index: np.ndarray
    value: np.ndarray
    covariance: np.ndarray
    threshold: float = float("inf")
