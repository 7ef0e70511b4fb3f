"""Kinematics of truck and trailer, and drives by them: what trackers are tried on without a world.

Symbols are those of cybertruck.trailer.kinematics; the derivation is in docs/trailer.md.
"""

from dataclasses import dataclass

import numpy as np
from cybertruck.trailer.kinematics import rear_axle, trailer_axle
from cybertruck.trailer.tracker import ARRIVED, FAILED


def trailer_curvature(hitch_angle, curvature, geometry):
    """Returns κ2 = -(sin ψ + L1 F cos ψ) / (L2 (cos ψ - L1 F sin ψ)) [1/m]; Q does not slip."""
    cos, sin, offset = np.cos(hitch_angle), np.sin(hitch_angle), geometry.hitch_offset
    return -(sin + offset * curvature * cos) / (
        geometry.tongue_length * (cos - offset * curvature * sin)
    )


def hitch_rate(speed, hitch_angle, curvature, geometry):
    """Returns dψ/dt = -v (sin ψ / L2 + (L1/L2 cos ψ + 1) F) [rad/s]."""
    ratio = geometry.hitch_offset / geometry.tongue_length
    return -speed * (
        np.sin(hitch_angle) / geometry.tongue_length
        + (ratio * np.cos(hitch_angle) + 1.0) * curvature
    )


def derivative(state, speed, curvature, geometry):
    """Returns the time derivative (..., 4) of a state, see advance."""
    heading, hitch_angle = state[..., 2], state[..., 3]
    rates = (
        speed * np.cos(heading),
        speed * np.sin(heading),
        speed * curvature,
        hitch_rate(speed, hitch_angle, curvature, geometry),
    )
    return np.stack(np.broadcast_arrays(*rates), axis=-1)


def advance(state, speed, curvature, time_step, geometry):
    """Advances a state by one step of Runge and Kutta, speed and curvature constant.

    Args:
        state: (..., 4) x, y of C [m], θ1 and ψ [rad].
        speed: v [m/s].
        curvature: F [1/m].
        time_step: [s].

    Returns:
        (..., 4) the state after the step.
    """
    state = np.asarray(state, dtype=float)
    first = derivative(state, speed, curvature, geometry)
    second = derivative(state + 0.5 * time_step * first, speed, curvature, geometry)
    third = derivative(state + 0.5 * time_step * second, speed, curvature, geometry)
    fourth = derivative(state + time_step * third, speed, curvature, geometry)
    return state + time_step / 6.0 * (first + 2.0 * second + 2.0 * third + fourth)


@dataclass
class Run:
    """Motion of trucks with trailers; the first axis is time.

    Attributes:
        states: (n, ..., 4) x, y of C, θ1 and ψ [m, m, rad, rad].
        lateral: (n, ...) lateral errors [m].
        heading: (n, ...) heading errors [rad].
        arc: (n, ...) arc lengths [m].
        mode: (n, ...) modes of the tracker.
        struck: (...) whether the hitch reached its limit.
    """

    states: np.ndarray
    lateral: np.ndarray
    heading: np.ndarray
    arc: np.ndarray
    mode: np.ndarray
    struck: np.ndarray


def start_state(path, lateral, heading, hitch_angle, geometry):
    """Returns the truck's state for a trailer near the start of a path.

    Args:
        lateral: Q's distance to the left of the path's start [m], any shape.
        heading: Trailer's heading error as driven, of that shape [rad].
        hitch_angle: ψ, of that shape [rad].

    Returns:
        (..., 4) state.
    """
    x, y, direction, _ = path.sample(0.0)
    lateral, heading, hitch_angle = np.broadcast_arrays(lateral, heading, hitch_angle)
    rear = rear_axle(
        x - lateral * np.sin(direction),
        y + lateral * np.cos(direction),
        direction + heading - np.pi,
        hitch_angle,
        geometry,
    )
    return np.stack((*rear, hitch_angle), axis=-1)


def simulate(tracker, start, steering, geometry, time_limit, time_step=0.02, steering_rate=2.0):
    """Drives trucks with a tracker until all have stopped.

    Args:
        tracker: Tracker of the start's shape.
        start: (..., 4) states.
        steering: The truck's true map from steering angle to curvature.
        geometry: The true Geometry; the tracker may have another one.
        time_limit: [s].
        time_step: Period of the tracker [s].
        steering_rate: Of the front wheels [rad/s].

    Returns:
        Run.
    """
    state = np.array(start, dtype=float)
    angle = np.zeros(state.shape[:-1])
    struck = np.zeros(state.shape[:-1], dtype=bool)
    history = []
    for _ in range(int(round(time_limit / time_step))):
        x, y, heading = trailer_axle(*np.moveaxis(state[..., :3], -1, 0), state[..., 3], geometry)
        status = tracker.step(x, y, heading, state[..., 3])
        history.append((state, status.lateral, status.heading, status.arc, status.mode))
        if np.all((status.mode == ARRIVED) | (status.mode == FAILED)):
            break
        angle = angle + np.clip(
            status.steering - angle, -steering_rate * time_step, steering_rate * time_step
        )
        state = advance(state, status.speed, steering.curvature(angle), time_step, geometry)
        struck |= np.abs(state[..., 3]) >= geometry.hitch_stop
        state[..., 3] = np.clip(state[..., 3], -geometry.hitch_stop, geometry.hitch_stop)
    return Run(*(np.stack(values) for values in zip(*history)), struck)
