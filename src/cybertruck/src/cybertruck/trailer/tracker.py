"""Tracks a path backwards with the trailer, and holds the hitch angle.

Backs the trailer's axle along a path, one command at a time, for any number of trucks. After Leng
and Minor 2010 (doi 10.1109/IROS.2010.5650489): the target curvature of the trailer is the path's
plus a law in the trailer's lateral and heading error, so that both decay along arc length. The
error laws are derived in docs/trailer.md.
"""

import math
from dataclasses import dataclass

import numpy as np
from paddock_common.settings import Checked, number

from cybertruck.trailer.geometry import (
    TrailerError,
    backing_limit,
    towing_limit,
    trailer_curvature_limit,
)
from cybertruck.trailer.laws import backing_law, hold_law

START_WINDOW = 3.0  # a trailer starts on the first meters of its path [m]
TOP_SPEED = 0.7  # backing and pulling forward stay below [m/s]
STEEP = math.radians(80.0)  # approach and hitch angles are smaller [rad]
BACKING, PULLING, ARRIVED, FAILED = range(4)
MODES = ("backing", "pulling forward", "arrived", "failed")


@dataclass(frozen=True)
class Tuning(Checked, error=TrailerError):
    """Parameters of the tracker.

    Attributes:
        speed: Backwards [m/s].
        recovery_speed: Forward, when the hitch angle has to be undone [m/s].
        deceleration: Towards the path's end [m/s²].
        creep_speed: Minimum speed near the end [m/s].
        lateral_length: Distance in which a lateral error falls to 1/e [m].
        heading_length: The same for the heading error [m].
        approach_angle: Maximum angle at which the path is approached [rad].
        hitch_length: The same for the hitch angle, on-axle and when holding a curvature [m].
        steering_gain: kφ, factor on the steering angle.
        reference_limit: Maximum hitch angle of the target curvature [rad].
        guard_margin: Backing stops this far before the jackknife angle or the hitch's limit [rad].
        lost_angle: Backing stops at this heading error [rad].
        resume_hitch: Pulling forward stops when the hitch angle is within this [rad], ...
        resume_heading: ... and the trailer's heading error within this [rad].
        recovery_length: Distance in which the truck turns back to the path's direction [m].
        max_recoveries: More pulls forward than this are a failure.
        max_pull: A pull forward longer than this is a failure [m].
        end_tolerance: Distance to the path's end at which it is reached [m].
    """

    speed: float = number(0.3, above=0.0, below=TOP_SPEED, unit="m/s")
    recovery_speed: float = number(0.3, above=0.0, below=TOP_SPEED, unit="m/s")
    deceleration: float = number(0.3, above=0.0, unit="m/s²")
    creep_speed: float = number(0.05, above=0.0, below=TOP_SPEED, unit="m/s")
    lateral_length: float = number(0.8, above=0.0, unit="m")
    heading_length: float = number(0.4, above=0.0, unit="m")
    approach_angle: float = number(math.radians(35.0), above=0.0, below=STEEP, unit="rad")
    hitch_length: float = number(0.3, above=0.0, unit="m")
    steering_gain: float = number(1.1, above=0.0)
    reference_limit: float = number(math.radians(42.0), above=0.0, below=STEEP, unit="rad")
    guard_margin: float = number(math.radians(5.0), above=0.0, unit="rad")
    lost_angle: float = number(math.radians(80.0), above=0.0, below=math.pi, unit="rad")
    resume_hitch: float = number(math.radians(10.0), above=0.0, unit="rad")
    resume_heading: float = number(math.radians(30.0), above=0.0, unit="rad")
    recovery_length: float = number(0.5, above=0.0, unit="m")
    max_recoveries: int = number(5, above=0)
    max_pull: float = number(6.0, above=0.0, unit="m")
    end_tolerance: float = number(0.01, above=0.0, unit="m")


@dataclass
class Status:
    """Errors and commands of the trucks; every field has the tracker's shape.

    Attributes:
        speed: v for the truck, negative backwards [m/s].
        steering: φ [rad].
        target_curvature: κd of the trailer [1/m].
        arc: Arc length on the path [m].
        lateral: Lateral error of Q, positive left of the path as driven [m].
        heading: Heading error of the trailer as driven [rad].
        mode: BACKING, PULLING, ARRIVED or FAILED.
    """

    speed: np.ndarray
    steering: np.ndarray
    target_curvature: np.ndarray
    arc: np.ndarray
    lateral: np.ndarray
    heading: np.ndarray
    mode: np.ndarray


class Tracker:
    """Computes commands of trucks from their poses.

    Args:
        path: Path of the trailer's axle, in the order in which it is driven backwards.
        steering: IdealSteering or MeasuredSteering.
        shape: Shape of the arrays of trucks, () for one.

    Raises:
        TrailerError: The path's curvature is higher than the trailer may be backed.
    """

    def __init__(self, path, geometry, steering, tuning: Tuning = Tuning(), shape=()):
        self.path, self.geometry, self.steering, self.tuning = path, geometry, steering, tuning
        self.hitch_limit = backing_limit(geometry, tuning.guard_margin)
        reference = min(tuning.reference_limit, self.hitch_limit - tuning.guard_margin)
        if reference <= 0.0:
            raise TrailerError(
                f"guard_margin {tuning.guard_margin:g} rad leaves no hitch angle "
                f"to back with; the limit is {self.hitch_limit:g} rad"
            )
        self.max_target_curvature = trailer_curvature_limit(reference, geometry)
        sharpest = float(np.max(np.abs(path.curvatures)))
        if sharpest > self.max_target_curvature:
            raise TrailerError(
                f"path: it has a radius of {1.0 / sharpest:.2f} m, the "
                f"trailer can be backed at {1.0 / self.max_target_curvature:.2f} m or more"
            )
        self.towing = min(towing_limit(geometry), steering.max_curvature)
        self.mode = np.full(shape, BACKING)
        self.recoveries = np.zeros(shape, dtype=int)
        self.arc = None
        self.length = path.length
        self._pull_start = np.zeros(shape)

    def start(self, x, y, arc=None):
        """Finds the trucks' arc lengths on the path.

        Args:
            x, y: Trailer axles' centers, of the tracker's shape [m].
            arc: Arc lengths to search from [m]; None: the nearest point on the path's
                first meters.
        """
        x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
        if arc is None:
            arc = [
                self.path.first_nearest(*point, START_WINDOW) for point in zip(x.ravel(), y.ravel())
            ]
        self.arc = np.reshape(arc, self.mode.shape) + 0.0

    def step(self, x, y, trailer_heading, hitch_angle) -> Status:
        """Returns the commands for the trucks' poses.

        Args:
            x, y: Q [m].
            trailer_heading: θ2 [rad].
            hitch_angle: ψ [rad].
        """
        if self.arc is None:
            self.start(x, y)
        arc = self.path.nearest(x, y, self.arc)
        # while backing the arc length only grows, so that a path may cross itself
        self.arc = np.where(self.mode == BACKING, np.maximum(arc, self.arc), arc)
        lateral, heading = self.path.errors(x, y, trailer_heading + math.pi, self.arc)
        self._change_mode(hitch_angle, heading)
        target_curvature = self.target_curvature(lateral, heading)
        backing = backing_law(
            target_curvature, hitch_angle, self.tuning.hitch_length, self.geometry
        )
        pulling = np.clip(
            (hitch_angle - heading) / self.tuning.recovery_length, -self.towing, self.towing
        )
        is_pulling = self.mode == PULLING
        curvature = np.where(
            is_pulling,
            pulling,
            np.clip(backing, -self.steering.max_curvature, self.steering.max_curvature),
        )
        gain = np.where(is_pulling, 1.0, self.tuning.steering_gain)
        steering = np.clip(
            gain * self.steering.steering(curvature),
            -self.steering.max_steering,
            self.steering.max_steering,
        )
        return Status(
            self._speed(), steering, target_curvature, self.arc, lateral, heading, self.mode
        )

    def target_curvature(self, lateral, heading):
        """Returns κd of the trailer from its errors.

        Along the driven arc length s, with e to the left and h = heading error, e' = sin h and
        h' = κ - κp cos h / (1 - κp e). The target is an approach angle a(e) = -A tanh(e / (l1 A)),
        and h' = a' - (h - a) / l2: near the path both errors then decay with l1 and l2. A trailer
        that is pushed backwards has the opposite curvature: κd = -κ.

        Args:
            lateral: e [m].
            heading: h [rad].

        Returns:
            κd, limited so that its steady hitch angle stays within the reference limit [1/m].
        """
        tuning = self.tuning
        _, _, _, path_curvature = self.path.sample(self.arc)
        ratio = np.tanh(lateral / (tuning.lateral_length * tuning.approach_angle))
        approach = -tuning.approach_angle * ratio
        approach_rate = -(1.0 - ratio * ratio) / tuning.lateral_length * np.sin(heading)
        shrink = np.maximum(1.0 - path_curvature * lateral, 0.3)
        driven = (
            path_curvature * np.cos(heading) / shrink
            + approach_rate
            - (heading - approach) / tuning.heading_length
        )
        return np.clip(-driven, -self.max_target_curvature, self.max_target_curvature)

    def _change_mode(self, hitch_angle, heading):
        """Changes modes between backing, pulling forward, arrived and failed."""
        tuning, mode = self.tuning, self.mode
        folded = (np.abs(hitch_angle) > self.hitch_limit) | (np.abs(heading) > tuning.lost_angle)
        starts = (mode == BACKING) & folded
        self.recoveries = self.recoveries + starts
        self._pull_start = np.where(starts, self.arc, self._pull_start)
        pulled = (mode == PULLING) & (np.abs(self.arc - self._pull_start) > tuning.max_pull)
        straight = (
            (mode == PULLING)
            & (np.abs(hitch_angle) < tuning.resume_hitch)
            & (np.abs(heading) < tuning.resume_heading)
        )
        arrived = (mode == BACKING) & (self.arc >= self.path.length - tuning.end_tolerance)
        mode = np.where(arrived, ARRIVED, mode)
        mode = np.where(starts & ~arrived, PULLING, mode)
        mode = np.where(straight, BACKING, mode)
        self.mode = np.where((self.recoveries > tuning.max_recoveries) | pulled, FAILED, mode)

    def _speed(self):
        """Returns v [m/s]: slower towards the end of the path, forward while pulling."""
        backing = backing_speed(self.path.length - self.arc, self.tuning)
        return np.choose(self.mode, (backing, self.tuning.recovery_speed, 0.0, 0.0))


def backing_speed(left, tuning):
    """Returns v < 0 [m/s] for a remaining distance [m], from which the truck can still stop."""
    fastest = np.sqrt(2.0 * tuning.deceleration * np.maximum(left, 0.0))
    return -np.clip(fastest, min(tuning.creep_speed, tuning.speed), tuning.speed)


LONGEST = 1000.0  # [m]


class CurvatureHold:
    """Commands a truck backwards so that its trailer's curvature converges; used like a Tracker.

    Args:
        curvature: As driven, positive to the left; κd of the trailer is its negative [1/m].
        length: Distance to drive [m].
        steering: IdealSteering or MeasuredSteering.

    Raises:
        TrailerError: The trailer cannot be backed so sharply, or the distance is not valid.

    Attributes:
        path: None; errors are reported as 0.
        length: Distance to drive [m].
        arc: Distance that the trailer's axle has driven [m].
    """

    path = None

    def __init__(self, curvature, length, geometry, steering, tuning: Tuning = Tuning()):
        limit = trailer_curvature_limit(tuning.reference_limit, geometry)
        if not abs(curvature) <= limit:
            raise TrailerError(
                f"hold: curvature is {curvature:g} 1/m; it must be within ±{limit:.3f}"
            )
        if not 0.0 < length <= LONGEST:
            raise TrailerError(
                f"hold: length is {length:g} m; it must be above 0 and at most {LONGEST:g}"
            )
        self.target_curvature, self.length = -curvature, length
        self.geometry, self.steering, self.tuning = geometry, steering, tuning
        self.hitch_limit = backing_limit(geometry, tuning.guard_margin)
        self.arc, self.mode, self._last = 0.0, BACKING, None

    def step(self, x, y, trailer_heading, hitch_angle):
        """Returns the command for the truck's pose; see Tracker.step.

        A hitch angle beyond the limit fails: there is no path to return to.
        """
        if self._last is not None:
            self.arc += math.hypot(x - self._last[0], y - self._last[1])
        self._last = x, y
        if self.mode == BACKING and abs(hitch_angle) > self.hitch_limit:
            self.mode = FAILED
        if self.mode == BACKING and self.arc >= self.length - self.tuning.end_tolerance:
            self.mode = ARRIVED
        speed = backing_speed(self.length - self.arc, self.tuning) if self.mode == BACKING else 0.0
        return Status(
            speed,
            self.steering_angle(hitch_angle),
            self.target_curvature,
            self.arc,
            0.0,
            0.0,
            self.mode,
        )

    def steering_angle(self, hitch_angle):
        """Returns φ [rad] for a hitch angle [rad], either of any shape."""
        curvature = hold_law(
            self.target_curvature, hitch_angle, self.tuning.hitch_length, self.geometry
        )
        limit = self.steering.max_curvature
        return np.clip(
            self.steering.steering(np.clip(curvature, -limit, limit)),
            -self.steering.max_steering,
            self.steering.max_steering,
        )
