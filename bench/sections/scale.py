"""1 to 32 cars with a lidar of 360 rays each: pace, cost per car, memory per car.

The reference is bare stepping of one car; a ratio counts cars times pace against it, so that the
same ratio for any number of cars means the same cost for each.
"""

import statistics

from figures import BenchError, Spread
from launching import Launch
from pairs import Round, alternate, pairs_of
from report import Row, compared, ratio_row
from usage import Monitor, memory_bytes
from worlds.car_description import SPEED, WHEEL_RADIUS

MB = 1e6
COUNTS, QUICK_COUNTS = (1, 2, 4, 8, 16, 32), (1, 2, 4)
CARS_SECONDS, BARE_SECONDS = 2.0, 1.0  # of a round


def measure(quick, log):
    """Cars are added to one world; rounds for each count."""
    counts = QUICK_COUNTS if quick else COUNTS
    found = []
    with Launch(
        log, ["real_time_factor:=0"], ("gazebo_ros", "empty_world.launch"), parameters=True
    ) as launch:
        observer = launch.observer("stepping.scale", *counts)
        for cars in counts:
            observer.answer()

            def many(cars=cars):
                answer = observer.ask(f"cars {CARS_SECONDS}")
                return Round(cars * answer["pace"], answer)

            pairs = alternate(
                lambda: observer.ask(f"bare {BARE_SECONDS}")["pace"],
                {"cars": many},
                pairs_of(quick),
                Monitor(launch.roles()),
            )["cars"]
            answers = [one_round.details for one_round in pairs.variant]
            slowest = min(answer["speed"] for answer in answers)
            if slowest < 0.5 * SPEED * WHEEL_RADIUS:
                raise BenchError(
                    f"the last of {cars} cars drives at {slowest:.2f} m/s only, its wheels' speed "
                    f"is {SPEED * WHEEL_RADIUS:.2f} m/s"
                )
            found.append(
                {
                    **pairs.figures(),
                    "cars": cars,
                    "pace": Spread.of(answer["pace"] for answer in answers).figures(),
                    **{
                        name: statistics.median(answer[name] for answer in answers)
                        for name in ("speed", "scan_rate")
                    },
                    "memory_mb": memory_bytes(launch.pid("bridge")) / MB,
                }
            )
            observer.tell("next")
    return {
        "rows": found,
        "memory_mb_per_car": (found[-1]["memory_mb"] - found[0]["memory_mb"])
        / (found[-1]["cars"] - found[0]["cars"]),
    }


def rows(figures):
    """Pace and ratio of each count; a ratio is called lower or higher than that of one car."""
    one = figures["rows"][0]
    for row in figures["rows"]:
        name = f"{row['cars']} car{'s' if row['cars'] > 1 else ''} with lidar"
        pace = Spread.read(row["pace"])
        yield Row(
            name,
            f"{pace.text()} simulated s per s, {row['memory_mb']:.0f} MB, scans "
            f"{row['scan_rate']:.2f} Hz",
            pace,
        )
        ratio = ratio_row(f"cars x pace, {row['cars']}", row, "one bare car", "car s per s")
        more = "" if row is one else f"; {compared(row, one, 'one car')}"
        yield Row(ratio.label, ratio.text + more, ratio.value)
    yield Row(
        "memory per car",
        f"{figures['memory_mb_per_car']:.1f} MB",
        figures["memory_mb_per_car"],
        "MB",
    )
