"""Fκ: the truck's curvature over steering angle, ideal or measured, and its inverse."""

import math

import numpy as np
from scipy.interpolate import PchipInterpolator

from cybertruck.trailer.geometry import TrailerError
from paddock_common import yaml_file

BISECTIONS = 60  # bisections of an interval of a few radians to a float's precision
EXTRAPOLATION = 0.03  # how far the map continues past the outermost measured angles [rad]


class IdealSteering:
    """The bicycle's curvature, tan φ / L."""

    def __init__(self, wheelbase, max_steering):
        """Stores the wheelbase [m] and the maximum steering angle [rad]."""
        self.wheelbase = wheelbase
        self.max_steering = max_steering
        self.max_curvature = math.tan(max_steering) / wheelbase

    def curvature(self, steering):
        """Returns the curvature [1/m] of steering angles [rad], which are limited first."""
        limited = np.clip(steering, -self.max_steering, self.max_steering)
        return np.tan(limited) / self.wheelbase

    def steering(self, curvature):
        """Returns the steering angle [rad] of curvatures [1/m], within the limit."""
        angle = np.arctan(np.asarray(curvature) * self.wheelbase)
        return np.clip(angle, -self.max_steering, self.max_steering)


class MeasuredSteering:
    """Measured curvatures, interpolated monotonically (PCHIP) and inverted.

    Args:
        angles: (n,) steering angles, strictly increasing, n >= 3 [rad].
        curvatures: (n,) measured curvatures, strictly increasing [1/m].
        extrapolation: How far the end slopes continue past the table [rad].

    Raises:
        TrailerError: The table is too short, has gaps, or is not monotone.
    """

    def __init__(self, angles, curvatures, extrapolation=EXTRAPOLATION):
        angles, curvatures = (np.asarray(value, dtype=float) for value in (angles, curvatures))
        if angles.ndim != 1 or angles.shape != curvatures.shape or len(angles) < 3:
            raise TrailerError(
                f"steering map: {angles.size} angles and {curvatures.size} "
                "curvatures; it must be the same number, 3 or more"
            )
        for name, values in (("angles", angles), ("curvatures", curvatures)):
            if not np.all(np.isfinite(values)):
                raise TrailerError(f"steering map: {name} contain a value that is not finite")
            if not np.all(np.diff(values) > 0.0):
                worst = int(np.argmin(np.diff(values)))
                raise TrailerError(
                    f"steering map: {name} must increase strictly, but "
                    f"{values[worst]:g} is followed by {values[worst + 1]:g}"
                )
        if not (math.isfinite(extrapolation) and extrapolation >= 0.0):
            raise TrailerError(f"steering map: extrapolation {extrapolation!r} must be 0 or more")
        self.angles, self.curvatures = angles, curvatures
        self._inner = PchipInterpolator(angles, curvatures)
        slope = self._inner.derivative()
        self._slopes = float(slope(angles[0])), float(slope(angles[-1]))
        self.lowest = float(angles[0]) - extrapolation
        self.highest = float(angles[-1]) + extrapolation
        self.max_steering = min(-self.lowest, self.highest)
        if self.max_steering <= 0.0:
            raise TrailerError(
                "steering map: the angles must lie on both sides of 0, "
                f"not from {angles[0]:g} to {angles[-1]:g}"
            )
        self.max_curvature = float(min(-self.curvature(self.lowest), self.curvature(self.highest)))

    def curvature(self, steering):
        """Returns the curvature [1/m] of steering angles [rad], limited to the map first."""
        # np.clip takes 3 times as long
        angle = np.minimum(np.maximum(steering, self.lowest), self.highest)
        inside = np.minimum(np.maximum(angle, self.angles[0]), self.angles[-1])
        past = angle - inside
        return self._inner(inside) + past * np.where(past < 0.0, *self._slopes)

    def steering(self, curvature):
        """Returns the steering angle [rad] of curvatures [1/m], limited to the map's ends."""
        curvature = np.asarray(curvature, dtype=float)
        low = np.full(curvature.shape, self.lowest)
        high = np.full(curvature.shape, self.highest)
        for _ in range(BISECTIONS):
            center = 0.5 * (low + high)
            below = self.curvature(center) < curvature
            low, high = np.where(below, center, low), np.where(below, high, center)
        return 0.5 * (low + high)


def write_map(path, angles, curvatures, notes=()):
    """Writes a steering map as YAML.

    Args:
        angles: (n,) [rad].
        curvatures: (n,) [1/m].
        notes: Lines of comment for the header of the file.
    """
    MeasuredSteering(angles, curvatures)  # raises for a table that could not be read back
    lines = [f"# {note}" for note in notes]
    for name, unit, values in (("angles", "rad", angles), ("curvatures", "1/m", curvatures)):
        lines.append(f"{name}:  # [{unit}]")
        lines += [f"  - {float(value):.6f}" for value in values]
    with open(path, "w") as stream:
        stream.write("\n".join(lines) + "\n")


def parse_map(data, source="steering map"):
    """Makes a MeasuredSteering from a map's YAML.

    Args:
        data: Dict with the lists angles and curvatures, and optionally extrapolation [rad].
        source: What is read, for errors.

    Raises:
        TrailerError: A key is missing, unknown, or not a list of numbers.
    """
    known = {"angles", "curvatures", "extrapolation"}
    if not isinstance(data, dict) or not {"angles", "curvatures"} <= set(data):
        raise TrailerError(f"{source}: it must have the lists angles and curvatures")
    unknown = sorted(str(key) for key in set(data) - known)
    if unknown:
        raise TrailerError(
            f"{source}: unknown {', '.join(unknown)}; there are: {', '.join(sorted(known))}"
        )
    try:
        return MeasuredSteering(
            np.array(data["angles"], dtype=float),
            np.array(data["curvatures"], dtype=float),
            float(data.get("extrapolation", EXTRAPOLATION)),
        )
    except (TypeError, ValueError, OverflowError) as error:
        raise TrailerError(f"{source}: {error}") from None


def read_map(path):
    """Reads a steering map.

    Raises:
        TrailerError: The file is missing, is not YAML, or contains no map.
    """
    try:
        data = yaml_file.read(path)
    except ValueError as error:
        raise TrailerError(f"steering map {error}") from None
    return parse_map(data, f"steering map {path}")
