"""The controller on the kinematic model, with a steering that turns at a limited rate."""

from dataclasses import dataclass

import numpy as np

from cybertruck.trailer.kinematics import advance, rear_axle, trailer_axle
from cybertruck.trailer.tracker import ARRIVED, FAILED


@dataclass
class Run:
    """Motion of rigs; the first axis is time.

    Attributes:
        states: (n, ..., 4) x, y of C, θ1 and ψ [m, m, rad, rad].
        lateral: (n, ...) lateral errors [m].
        heading: (n, ...) heading errors [rad].
        arc: (n, ...) arc lengths [m].
        mode: (n, ...) modes of the tracker.
        struck: (...) whether the hitch met its stop.
    """

    states: np.ndarray
    lateral: np.ndarray
    heading: np.ndarray
    arc: np.ndarray
    mode: np.ndarray
    struck: np.ndarray


def start_state(path, lateral, heading, hitch_angle, geometry):
    """Returns the truck's state for a trailer beside the start of a path.

    Args:
        path: Path.
        lateral: Q's distance to the left of the path's start [m], any shape.
        heading: Trailer's heading error as driven, of that shape [rad].
        hitch_angle: ψ, of that shape [rad].
        geometry: Geometry.

    Returns:
        (..., 4) state.
    """
    x, y, direction, _ = path.place(0.0)
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
    """Drives rigs with a tracker until all have ended.

    Args:
        tracker: Tracker for rigs of the start's shape.
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
