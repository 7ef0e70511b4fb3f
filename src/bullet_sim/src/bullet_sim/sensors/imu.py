"""An inertial measurement unit: its readings, in its own frame."""

import numpy as np

from bullet_sim.sensors.frames import matrix_from_quaternion

GRAVITY_IN_WORLD = (0.0, 0.0, -9.81)


def reading(
    orientation, angular_velocity_in_world, acceleration_in_world, gravity_in_world=GRAVITY_IN_WORLD
):
    """Angular velocity and specific force; at rest +9.81 m/s^2 upwards (REP 145).

    Args:
        orientation: (x, y, z, w), sensor frame in the world.
        angular_velocity_in_world: (3,) [rad/s].
        acceleration_in_world: (3,) [m/s^2], of the sensor, without gravity.
        gravity_in_world: (3,) [m/s^2].

    Returns:
        (angular_velocity (3,) [rad/s], linear_acceleration (3,) [m/s^2]), in the sensor frame.
    """
    to_sensor = matrix_from_quaternion(orientation).T
    force = np.asarray(acceleration_in_world, dtype=float) - np.asarray(gravity_in_world)
    return to_sensor @ np.asarray(angular_velocity_in_world, dtype=float), to_sensor @ force


def mean_acceleration(velocity, velocity_before, elapsed):
    """Acceleration over one sensor period.

    Args:
        velocity, velocity_before: (3,) [m/s] in the world.
        elapsed: simulated time between them [s], > 0.

    Returns:
        (3,) [m/s^2] in the world.
    """
    if not elapsed > 0.0:
        raise ValueError(f"elapsed {elapsed} s: time > 0 between two readings is expected")
    return (np.asarray(velocity, dtype=float) - np.asarray(velocity_before)) / elapsed


def add_noise(values, stddev, rng, mean=0.0):
    """White Gaussian noise of a mean and a standard deviation (unit of `values`); 0 = none."""
    if mean:
        values = np.asarray(values, dtype=float) + mean
    if stddev <= 0.0:
        return values
    return values + rng.normal(0.0, stddev, np.shape(values))
