"""Settings of the node `lap`."""

from dataclasses import dataclass

from paddock_common.settings import check, number, text


@dataclass(frozen=True)
class LapSettings:
    """Parameters of the node beyond ~out_dir and ~track.

    Attributes:
        driver: Name for the overlay and the report.
        model: Name of the car in the simulator.
        starts: Number of starts; with several all are placed at random.
        seed: Of the random places.
        time_limit: Of a lap [s] of ROS time.
        roam: Drive so long instead of a lap [s] of ROS time; 0: a lap.
        patience: Longest wall time without progress [s].
        film_rate: Of the film [Hz].
    """

    driver: str = text("", empty=True)
    model: str = text("racecar")
    starts: int = number(1, least=1, whole=True)
    seed: int = number(0, least=0, whole=True)
    time_limit: float = number(240.0, above=0.0, unit="s")
    roam: float = number(0.0, least=0.0, unit="s")
    patience: float = number(120.0, above=0.0, unit="s")
    film_rate: float = number(15.0, above=0.0, unit="Hz")

    def __post_init__(self):
        check(self)
