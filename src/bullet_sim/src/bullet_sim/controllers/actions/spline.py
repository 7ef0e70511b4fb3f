"""Segments of a joint's trajectory: polynomials through what is given of both ends."""

from dataclasses import dataclass

from bullet_sim.controllers.actions.tolerances import NO_TOLERANCE, Tolerance


@dataclass(frozen=True)
class End:
    """An end of a segment: position [rad, m], velocity and acceleration, None where not given."""

    position: float
    velocity: float | None = None
    acceleration: float | None = None


class Segment:
    """A polynomial of time between two ends.

    Linear where one end has no velocity, cubic where both have one, of the fifth degree where both
    have accelerations, too: the lowest degree that has these values at its ends. A segment without
    duration is at its first end.

    Args:
        start, end: times [s].
        first, last: Ends.
        goal: whose segment it is; None: nobody's.
        from_start: time of the first end since the start of its trajectory [s].
        path, arrival: Tolerances along it and of its end.
        patience: time after its end to get within `arrival` [s].
    """

    def __init__(
        self,
        start,
        first,
        end,
        last,
        goal=None,
        from_start=0.0,
        path: Tolerance = NO_TOLERANCE,
        arrival: Tolerance = NO_TOLERANCE,
        patience=0.0,
    ):
        self.start, self.end = start, end
        self.goal, self.from_start = goal, from_start
        self.path, self.arrival, self.patience = path, arrival, patience
        self._coefficients = _coefficients(first, last, end - start)

    def sample(self, time):
        """Position, velocity and acceleration at a time; at rest before and after it."""
        duration = self.end - self.start
        t = min(max(time - self.start, 0.0), duration)
        position = velocity = acceleration = 0.0
        for c in reversed(self._coefficients):
            acceleration = acceleration * t + 2.0 * velocity
            velocity = velocity * t + position
            position = position * t + c
        if not 0.0 <= time - self.start <= duration:
            return position, 0.0, 0.0
        return position, velocity, acceleration


def _coefficients(first, last, duration):
    """Of 1, t, t^2 ... for a segment's ends."""
    p, way = first.position, last.position - first.position
    if duration <= 0.0:
        return (p,)
    if first.velocity is None or last.velocity is None:
        return p, way / duration
    # in units of the duration: what is left beyond the start's own motion
    u, v = first.velocity * duration, last.velocity * duration
    if first.acceleration is None or last.acceleration is None:
        scaled = (p, u, 3.0 * way - 2.0 * u - v, u + v - 2.0 * way)
    else:
        a, b = first.acceleration * duration**2 / 2.0, last.acceleration * duration**2 / 2.0
        scaled = (
            p,
            u,
            a,
            10.0 * way - 6.0 * u - 4.0 * v - 3.0 * a + b,
            -15.0 * way + 8.0 * u + 7.0 * v + 3.0 * a - 2.0 * b,
            6.0 * way - 3.0 * u - 3.0 * v - a + b,
        )
    return tuple(c / duration**n for n, c in enumerate(scaled))


def active(segments, time):
    """The segment that acts at a time: the last that has started, or the first."""
    for segment in reversed(segments):
        if segment.start <= time:
            return segment
    return segments[0]
