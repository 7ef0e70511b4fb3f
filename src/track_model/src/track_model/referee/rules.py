"""Rules and car of the referee: checked values."""

import math
from dataclasses import dataclass, fields


@dataclass(frozen=True)
class Rules:
    """Rules of the referee.

    Attributes:
        off_track: 'all': the car is off when all four wheels are outside the lane (the DeepRacer
            league's rule), 'one': when one is.
        off_track_penalty, collision_penalty: added per excursion and per crash [s]; 5 s each is
            what the DeepRacer community's evaluation template sets.
        stuck_time: [s] without progress, once a lap runs.
        stuck_distance: progress that ends being stuck [m].
        wrong_way_distance: driving back by more is the wrong way [m].
        standing_start: a car first seen up to this far behind the line [m] starts its first lap
            when it first moves; any other starts it when it crosses the line.
        auto_reset: put the car back on the track when it is off, crashed or stuck.
    """

    off_track: str = "all"
    off_track_penalty: float = 5.0
    collision_penalty: float = 5.0
    stuck_time: float = 5.0
    stuck_distance: float = 0.05
    wrong_way_distance: float = 0.3
    standing_start: float = 0.2
    auto_reset: bool = False

    def __post_init__(self):
        if self.off_track not in ("all", "one"):
            raise ValueError(f"off_track is '{self.off_track}', must be all or one")
        if not isinstance(self.auto_reset, bool):
            raise ValueError(f"auto_reset is {self.auto_reset!r}, must be true or false")
        for field in fields(self):
            value = getattr(self, field.name)
            if isinstance(field.default, float) and not (
                isinstance(value, (int, float))
                and not isinstance(value, bool)
                and math.isfinite(value)
                and value >= 0
            ):
                raise ValueError(f"{field.name} is {value!r}, must be a number of 0 or more")


@dataclass(frozen=True)
class Car:
    """Wheel and corner positions, from the reference point (base_link) [m].

    Attributes:
        front, rear: x of the axles.
        front_half_track, rear_half_track: y of the wheels' centres.
        nose, tail: x of the outline's ends.
        half_width: of the outline.
    """

    front: float = 0.082311
    rear: float = -0.081663
    front_half_track: float = 0.079601
    rear_half_track: float = 0.08105
    nose: float = 0.16
    tail: float = -0.13
    half_width: float = 0.0945

    @property
    def wheels(self):
        """((x, y), ...) of front left, front right, rear left, rear right."""
        return (
            (self.front, self.front_half_track),
            (self.front, -self.front_half_track),
            (self.rear, self.rear_half_track),
            (self.rear, -self.rear_half_track),
        )

    @property
    def corners(self):
        """((x, y), ...) of the outline, counter-clockwise."""
        return (
            (self.nose, self.half_width),
            (self.tail, self.half_width),
            (self.tail, -self.half_width),
            (self.nose, -self.half_width),
        )
