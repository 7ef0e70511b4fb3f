"""The observation `state`: where the car is in its lane, how it moves, how the lane goes on."""

import math

import numpy as np

AHEAD = np.array((0.2, 0.5, 0.8, 1.2, 1.6, 2.0))  # where curvatures are taken [m]
LIMIT = 4.0  # of all numbers
STEP = 0.02  # of the table of curvatures [m]
SPEED_SCALE = 4.0  # [m/s]
SIDEWAYS_SCALE = 1.0  # [m/s]
YAW_RATE_SCALE = 4.0  # [rad/s]
STEERING_SCALE = math.radians(30.0)
NAMES = (
    "lateral offset / half lane",
    "sine of the heading error",
    "cosine of the heading error",
    "forward speed / 4 m/s",
    "leftward speed / 1 m/s",
    "yaw rate / 4 rad/s",
    "commanded steering / 30 degrees",
    "commanded speed / 4 m/s",
    *(f"curvature {ahead:g} m ahead [1/m]" for ahead in AHEAD),
)
SHAPE = (len(NAMES),)


class StateObserver:
    """Observes the state on one course.

    Args:
        projector: track_model.referee.projector.Projector.
    """

    def __init__(self, projector):
        count = round(projector.length / STEP)
        self._step, self._count = projector.length / count, count
        at = (np.arange(count) * self._step)[:, None] + AHEAD
        bends = [projector.curvature(row) for row in at]
        self._bends = np.clip(bends, -LIMIT, LIMIT).astype(np.float32)

    def observe(self, motion, place, last):
        """Observe the state.

        Args:
            motion: Motion of the car.
            place: Standing, or anything with its s, lateral, heading_error, left and right.
            last: commanded (speed [m/s], steering [rad]).

        Returns:
            (14,) float32, the numbers of NAMES, each from -LIMIT to LIMIT.
        """
        left, right, error = place.left, place.right, place.heading_error
        speed, steering = last
        row = np.empty(SHAPE, np.float32)
        row[:8] = (
            _cut((place.lateral - (left - right) / 2.0) * 2.0 / (left + right)),
            math.sin(error),
            math.cos(error),
            _cut(motion.forward / SPEED_SCALE),
            _cut(motion.leftward / SIDEWAYS_SCALE),
            _cut(motion.yaw_rate / YAW_RATE_SCALE),
            steering / STEERING_SCALE,
            speed / SPEED_SCALE,
        )
        row[8:] = self._bends[min(max(int(place.s / self._step), 0), self._count - 1)]
        return row


def _cut(value):
    return min(max(value, -LIMIT), LIMIT)
