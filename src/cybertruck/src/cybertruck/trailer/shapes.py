"""Named paths: a table of shapes with their dimensions and defaults."""

import math
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.optimize import fsolve

from cybertruck.trailer.geometry import TrailerError
from cybertruck.trailer.paths import LONGEST, from_curvature


@dataclass(frozen=True)
class Shape:
    """A named path.

    Attributes:
        make: Function from the dimensions to a Path from (0, 0) along +x.
        names: Names of the dimensions, with units.
        defaults: Their values.
    """

    make: object
    names: tuple
    defaults: tuple


def smooth(ratio):
    """Rises from 0 to 1 with zero first and second derivative at both ends."""
    ratio = np.clip(ratio, 0.0, 1.0)
    return ratio**3 * (10.0 - 15.0 * ratio + 6.0 * ratio * ratio)


def line(length):
    """A straight line of a length [m]."""
    require(length > 0.0, "line: length", length, "above 0 m")
    return from_curvature(np.zeros_like, length)


def arc(radius, angle, run_up=1.5):
    """A circle of a radius [m], negative to the right, over an angle [rad].

    The curvature rises and falls over `run_up` [m], or a quarter of the length, if that is shorter.
    """
    require(abs(radius) >= 0.1, "arc: radius", radius, "0.1 m or more, or -0.1 or less")
    require(angle > 0.0, "arc: angle", angle, "above 0 rad")
    require(run_up > 0.0, "arc: run-up", run_up, "above 0 m")
    length = abs(radius) * angle
    rise = min(run_up, 0.5 * length)
    length += rise  # the heading changes in each ramp half as much as in an arc of its length

    def curvature(at):
        return smooth(at / rise) * smooth((length - at) / rise) / radius

    return from_curvature(curvature, length)


def s_bend(name, offset, advance, after=0.0, before=None):
    """Straight, S, straight; the S ends `advance` ahead and `offset` to the left [m].

    Without straights it is two opposite curves; with those of one length, which `before` is by
    default, a lane change; with a short one before, the way into a gap at the side, as in parallel
    parking.

    Its heading is a smooth bump of one height over arc length; height and arc length follow from
    advance and offset.
    """
    before = after if before is None else before
    require(advance > 0.0, f"{name}: length", advance, "above 0 m")
    require(after >= 0.0, f"{name}: straight", after, "0 m or more")
    require(abs(offset) < 0.8 * advance, f"{name}: offset", offset, f"within ±{0.8 * advance:g} m")

    def make_path(height, length):
        def curvature(at):  # derivative of the bump 64 (u (1 - u))³, whose top is 1
            ratio = np.clip((at - before) / length, 0.0, 1.0)
            return height / length * 192.0 * (ratio * (1.0 - ratio)) ** 2 * (1.0 - 2.0 * ratio)

        return from_curvature(curvature, before + length + after)

    def end_point(values):
        path = make_path(*values)
        return path.points[-1] - (before + after, 0.0) - (advance, offset)

    values = math.atan2(offset, advance) * 1.8, math.hypot(offset, advance)
    return make_path(*fsolve(end_point, values, xtol=1e-10, epsfcn=1e-10))


def require(condition, label, value, valid):
    """Raises a TrailerError with label, value and what is valid."""
    if not condition:
        raise TrailerError(f"{label} is {value:g}; it must be {valid}")


S_BEND = "offset to the left [m]", "length [m]", "straight [m]"
SHAPES = {
    "line": Shape(line, ("length [m]",), (10.0,)),
    "arc": Shape(
        arc, ("radius [m], left positive", "angle [rad]", "run-up [m]"), (3.0, math.pi, 1.5)
    ),
    "s": Shape(partial(s_bend, "s"), S_BEND[:2], (3.0, 8.0)),
    "lane-change": Shape(partial(s_bend, "lane-change"), S_BEND, (1.5, 5.0, 2.0)),
    "park": Shape(partial(s_bend, "park", before=0.2), S_BEND, (-1.2, 4.0, 2.0)),
}


def make_shape(name, size=()):
    """Makes a named path from (0, 0) along +x.

    Args:
        name: A key of SHAPES.
        size: The first of its dimensions, or none; the others have their defaults.

    Raises:
        TrailerError: No such shape, too many numbers, or one out of range.
    """
    shape = SHAPES.get(name)
    if shape is None:
        raise TrailerError(f"shape {name!r}: there are {', '.join(SHAPES)}")
    if len(size) > len(shape.names):
        raise TrailerError(f"{name}: {len(size)} numbers; it takes {', '.join(shape.names)}")
    for label, value in zip(shape.names, size):
        require(
            math.isfinite(value) and abs(value) <= LONGEST,
            f"{name}: {label}",
            value,
            f"finite and within ±{LONGEST:g}",
        )
    return shape.make(*(tuple(size) + shape.defaults[len(size) :]))
