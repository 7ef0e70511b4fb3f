"""Rules and car of the referee: checked values."""

from dataclasses import dataclass

from paddock_common.settings import check, choice, flag, number


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

    off_track: str = choice("all", ("all", "one"))
    off_track_penalty: float = number(5.0, least=0.0, unit="s")
    collision_penalty: float = number(5.0, least=0.0, unit="s")
    stuck_time: float = number(5.0, least=0.0, unit="s")
    stuck_distance: float = number(0.05, least=0.0, unit="m")
    wrong_way_distance: float = number(0.3, least=0.0, unit="m")
    standing_start: float = number(0.2, least=0.0, unit="m")
    auto_reset: bool = flag(False)

    def __post_init__(self):
        check(self)


@dataclass(frozen=True)
class Car:
    """Wheel and corner positions, from the reference point (base_link) [m].

    Attributes:
        front, rear: x of the axles.
        front_half_track, rear_half_track: y of the wheels' centres.
        nose, tail: x of the outline's ends.
        half_width: of the outline.
    """

    front: float = number(0.082311, unit="m")
    rear: float = number(-0.081663, unit="m")
    front_half_track: float = number(0.079601, unit="m")
    rear_half_track: float = number(0.08105, unit="m")
    nose: float = number(0.16, unit="m")
    tail: float = number(-0.13, unit="m")
    half_width: float = number(0.0945, unit="m")

    def __post_init__(self):
        check(self)

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
