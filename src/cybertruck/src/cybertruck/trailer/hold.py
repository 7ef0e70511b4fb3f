"""Holding a trailer's curvature backwards, without a path (Werling et al. 2014)."""

import math

import numpy as np

from cybertruck.trailer.geometry import TrailerError, backing_limit, trailer_curvature_limit
from cybertruck.trailer.laws import hold_law
from cybertruck.trailer.tracker import ARRIVED, BACKING, FAILED, Status, Tuning, backing_speed

LONGEST = 1000.0  # [m]


class CurvatureHold:
    """Commands a rig backwards so that its trailer's curvature converges; used like a Tracker.

    Attributes:
        path: None; errors are reported as 0.
        length: Distance to drive [m].
        arc: Distance that the trailer's axle has driven [m].
    """

    path = None

    def __init__(self, curvature, length, geometry, steering, tuning=Tuning()):
        """Starts.

        Args:
            curvature: As driven, positive to the left; κd of the trailer is its negative [1/m].
            length: Distance to drive [m].
            geometry: Geometry.
            steering: IdealSteering or MeasuredSteering.
            tuning: Tuning.

        Raises:
            TrailerError: The trailer cannot be backed so sharply, or the distance is no distance.
        """
        limit = trailer_curvature_limit(tuning.reference_limit, geometry)
        if not abs(curvature) <= limit:
            raise TrailerError(
                f"hold: curvature is {curvature:g} 1/m; it must be within ±{limit:.3f}"
            )
        if not 0.0 < length <= LONGEST:
            raise TrailerError(
                f"hold: length is {length:g} m; it must be above 0 and at most {LONGEST:g}"
            )
        self.wanted, self.length = -curvature, length
        self.geometry, self.steering, self.tuning = geometry, steering, tuning
        self.guard = backing_limit(geometry, tuning.guard_margin)
        self.arc, self.mode, self._last = 0.0, BACKING, None

    def step(self, x, y, trailer_heading, hitch_angle):
        """Returns the command for the rig's pose; see Tracker.step.

        A hitch angle beyond the guard ends it: there is no path to go back to.
        """
        if self._last is not None:
            self.arc += math.hypot(x - self._last[0], y - self._last[1])
        self._last = x, y
        if self.mode == BACKING and abs(hitch_angle) > self.guard:
            self.mode = FAILED
        if self.mode == BACKING and self.arc >= self.length - self.tuning.end_tolerance:
            self.mode = ARRIVED
        speed = backing_speed(self.length - self.arc, self.tuning) if self.mode == BACKING else 0.0
        return Status(
            speed, self.steering_angle(hitch_angle), self.wanted, self.arc, 0.0, 0.0, self.mode
        )

    def steering_angle(self, hitch_angle):
        """Returns φ [rad] for a hitch angle [rad], either of any shape."""
        curvature = hold_law(self.wanted, hitch_angle, self.tuning.hitch_length, self.geometry)
        limit = self.steering.max_curvature
        return np.clip(
            self.steering.steering(np.clip(curvature, -limit, limit)),
            -self.steering.max_steering,
            self.steering.max_steering,
        )
