"""Lengths and limits of truck and trailer, and quantities that follow from them."""

import math
from dataclasses import dataclass

import numpy as np
from paddock_common.settings import Checked, flag, number

HITCH_STOP = math.radians(80.0)  # angle of the hitch's mechanical limit [rad]
ON_AXLE_RATIO = 0.15  # fraction of the tongue's length below which a hitch counts as on the axle


class TrailerError(ValueError):
    """A value of geometry, path, goal or map is not valid; the text names it and what is valid."""


@dataclass(frozen=True)
class Geometry(Checked, error=TrailerError):
    """Lengths and limits of a truck with one trailer.

    Attributes:
        wheelbase: L, front to rear axle of the truck [m].
        hitch_offset: L1, rear axle to hitch, positive behind the axle, 0 for on-axle [m].
        tongue_length: L2, hitch to the trailer's axle [m].
        max_steering: Maximum angle of the bicycle's front wheel [rad].
        hitch_stop: Hitch angle at the joint's limit [rad].
    """

    wheelbase: float = number(0.508, above=0.0, unit="m")
    hitch_offset: float = number(0.30, min=0.0, unit="m")
    tongue_length: float = number(0.70, above=0.0, unit="m")
    max_steering: float = number(0.7854, above=0.0, below=math.pi / 2, unit="rad")
    hitch_stop: float = number(HITCH_STOP, above=0.0, below=math.pi, unit="rad")

    @property
    def max_curvature(self):
        """Fmax: curvature of the truck at full lock [1/m]."""
        return math.tan(self.max_steering) / self.wheelbase

    @property
    def near_axle(self):
        """Whether the hitch is too close to the axle to set the trailer's curvature by steering."""
        return self.hitch_offset < ON_AXLE_RATIO * self.tongue_length


def towing_curvature(hitch_angle, geometry: Geometry):
    """Returns the truck's curvature that holds a hitch angle, sin ψ = -F (L2 + L1 cos ψ).

    Args:
        hitch_angle: ψ [rad].

    Returns:
        F [1/m], of the sign opposite to the hitch angle's.
    """
    length = geometry.tongue_length + geometry.hitch_offset * np.cos(hitch_angle)
    return -np.sin(hitch_angle) / length


def steady_hitch_angle(curvature, geometry: Geometry):
    """Returns the hitch angle at which a trailer settles when the truck drives forward on a circle.

    sin ψ + F (L1 cos ψ + L2) = 0, solved as one sine:
    sin(ψ + atan(F L1)) = -F L2 / sqrt(1 + F²L1²).

    Args:
        curvature: F of the truck [1/m], any shape.

    Returns:
        ψ [rad]; NaN where the hitch's circle is smaller than the tongue and the trailer folds.
    """
    curvature = np.asarray(curvature, dtype=float)
    offset = curvature * geometry.hitch_offset
    ratio = -curvature * geometry.tongue_length / np.sqrt(1.0 + offset * offset)
    with np.errstate(invalid="ignore"):
        return np.arcsin(ratio) - np.arctan(offset)


def has_steady_towing(curvature, geometry: Geometry):
    """Returns whether a circle of the truck can be towed: sqrt(R² + L1²) >= L2.

    Args:
        curvature: F of the truck [1/m], any shape.
    """
    curvature = np.asarray(curvature, dtype=float)
    offset = curvature * geometry.hitch_offset
    return np.abs(curvature) * geometry.tongue_length <= np.sqrt(1.0 + offset * offset)


def jackknife_angle(geometry):
    """Returns the hitch angle beyond which backing folds the trailer at any steering angle.

    It is the smallest root of sin ψ = Fmax (L2 + L1 cos ψ), the angle that full lock just holds.

    Returns:
        The angle [rad], or None where no root exists: full lock unfolds from anywhere.
    """
    angle = float(-steady_hitch_angle(geometry.max_curvature, geometry))
    return None if math.isnan(angle) else angle


def backing_limit(geometry: Geometry, margin):
    """Returns the hitch angle up to which the trailer may be backed.

    Args:
        margin: To the jackknife angle or the hitch's limit, whichever is smaller [rad].
    """
    angle = jackknife_angle(geometry)
    return min(geometry.hitch_stop, math.inf if angle is None else angle) - margin


def towing_limit(geometry: Geometry, hitch_angle=math.radians(45.0)):
    """Returns the maximum curvature to drive forward with at which no circle folds the trailer.

    Args:
        hitch_angle: Maximum hitch angle allowed in steady towing [rad].

    Returns:
        F > 0, no more than the truck's own limit [1/m].
    """
    return min(geometry.max_curvature, float(-towing_curvature(hitch_angle, geometry)))


@dataclass(frozen=True)
class TowingTruck(Geometry):
    """Settings of a truck that drives forward, with or without a trailer.

    Attributes:
        trailer: Whether the truck pulls a trailer; the curvature is then limited further.
        max_hitch_angle: Hitch angle that the tightest circle with a trailer settles at [rad].
    """

    trailer: bool = flag(False)
    max_hitch_angle: float = number(math.radians(60.0), above=0.0, below=math.pi / 2, unit="rad")

    @property
    def max_curvature(self):
        """Maximum curvature of the rear axle's path: full lock, or what a trailer follows [1/m]."""
        full_lock = super().max_curvature
        if not self.trailer:
            return full_lock
        return min(full_lock, float(-towing_curvature(self.max_hitch_angle, self)))


def steady_trailer(trailer_curvature, geometry: Geometry):
    """Returns the truck's curvature and the hitch angle of a trailer on a circle.

    The hitch is on one circle with both axles: R² + L1² = R2² + L2².

    Args:
        trailer_curvature: κ2 [1/m], any shape.

    Returns:
        (F [1/m], ψ [rad]); NaN where no circle of the truck leads the trailer's.
    """
    kappa = np.asarray(trailer_curvature, dtype=float)
    square = 1.0 + kappa * kappa * (geometry.tongue_length**2 - geometry.hitch_offset**2)
    with np.errstate(invalid="ignore", divide="ignore"):
        curvature = kappa / np.sqrt(np.where(square > 0.0, square, np.nan))
    angle = -np.arctan(geometry.tongue_length * kappa) - np.arctan(
        geometry.hitch_offset * curvature
    )
    return curvature, angle


def trailer_curvature_limit(hitch_angle, geometry: Geometry):
    """Returns the curvature of a trailer that is towed or backed steadily at a hitch angle.

    Args:
        hitch_angle: |ψ| below a right angle [rad].

    Returns:
        κ2 > 0 [1/m].
    """
    curvature = float(-towing_curvature(abs(hitch_angle), geometry))
    square = 1.0 - curvature**2 * (geometry.tongue_length**2 - geometry.hitch_offset**2)
    if not 0.0 < abs(hitch_angle) < math.pi / 2 or square <= 0.0:
        raise TrailerError(
            f"hitch angle {math.degrees(hitch_angle):.1f} degrees: no trailer "
            "circles steadily there; it must lie between 0 and 90"
        )
    return curvature / math.sqrt(square)
