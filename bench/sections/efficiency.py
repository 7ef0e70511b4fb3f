"""The bridge as fast as possible over PyBullet's stepping alone, and who had the processors."""

import json
import statistics
from dataclasses import dataclass

from figures import BenchError, Spread
from launching import WORLDS, Launch
from pairs import Round, alternate, matched, pairs_of
from report import Row, compared, ratio_row, spent_text
from worlds.car_description import SPEED, WHEEL_RADIUS

TOPICS = ("/racecar/joint_states", "/racecar/odom", "/tf", "/clock")
CAR = {"model": "racecar", "description": "/robot_description", "namespace": "/racecar", "x": 0.0}
SECOND = {
    "model": "second",
    "description": "/second/robot_description",
    "namespace": "/second/racecar",
    "x": 3.0,
}
SAME_SPEED = 0.2  # largest difference of the bridge's car's speed and the bare one's
PAUSED_LIMIT = 0.1  # processors that a paused graph may take beside the reference
BASE = "as_launched"  # what the other variants are compared with


@dataclass(frozen=True)
class Variant:
    """A world to launch.

    Attributes:
        topics: subscribed beyond TOPICS.
        file: launch file in worlds/, or None: track_model's world.launch.
        cars: for the bare world, see observers.stepping.
        quick: whether a quick run takes it, too.
    """

    topics: tuple = ()
    arguments: tuple = ()
    file: str = None
    cars: tuple = (CAR,)
    quick: bool = False


VARIANTS = {
    "as_launched": Variant(quick=True),
    "bridge_alone": Variant((), ("state_publisher:=false",), quick=True),
    "robot_state_publisher": Variant((), ("state_publisher:=true",), quick=True),
    "lidar_600_rays_10_hz": Variant(("/scan",), quick=True),
    "lidar_1081_rays_40_hz": Variant(("/scan",), file="lidar.launch"),
    "camera_160x120_30_hz": Variant(
        ("/camera/image",), ("camera_width:=160", "camera_height:=120")
    ),
    "camera_640x480_30_hz": Variant(("/camera/image",), quick=True),
    "six_effort_pids": Variant(
        file="effort.launch", cars=(dict(CAR, description="/bare_description"),), quick=True
    ),
    "two_cars": Variant(
        ("/second/racecar/joint_states", "/second/racecar/odom"),
        file="two_cars.launch",
        cars=(CAR, SECOND),
    ),
    "imu_1_khz": Variant(("/imu",), ("imu_rate:=1000",), "rates.launch"),
    "ground_truth_1_khz": Variant(("/truth",), ("truth_rate:=1000",), "rates.launch"),
    "lidar_16_layers_10_hz": Variant(("/points",), ("layers:=16",), "rates.launch"),
    "eight_listeners": Variant(file="listeners.launch"),
    "eight_listeners_same_priority": Variant((), ("niceness:=0",), "listeners.launch"),
    "model_and_link_states": Variant(("/gazebo/model_states", "/gazebo/link_states")),
}


def measure(quick, log):
    """Each variant in a launch of its own, in alternation with the bare world of its own."""
    seconds = 1.5 if quick else 2.5
    figures, errors = {}, {}
    for name, variant in VARIANTS.items():
        if variant.quick or not quick:
            try:
                measured = measure_variant(variant, seconds, pairs_of(quick), log)
                figures[name] = _beside_a_resting_graph(measured)
            except BenchError as error:
                errors[name] = str(error)
    return dict(figures, errors=errors)


def measure_variant(variant, seconds, pairs, log):
    """Figures of one variant.

    Args:
        seconds: of a round, wall time.
        log: file for what programs print.

    Raises:
        BenchError: the cars drive differently, or a topic is silent.
    """
    file = (str(WORLDS / variant.file),) if variant.file else ("track_model", "world.launch")
    topics = (*TOPICS, *variant.topics)
    with Launch(log, ["real_time_factor:=0", *variant.arguments], file) as launch:
        observer = launch.observer(
            "stepping.free", json.dumps({"topics": topics, "cars": variant.cars})
        )
        told = observer.answer()
        roles = launch.roles()
        bridge = roles.get("bridge", [None])[0]
        if bridge is None:
            raise BenchError(f"the bridge is not among the processes {sorted(roles)}")
        threads = {"simulation": (bridge, bridge), "reference": (told["pid"], told["pid"])}
        observer.tell(json.dumps({"roles": roles, "threads": threads}))

        def one_round(kind):
            answer = observer.ask(f"{kind} {seconds}")
            return Round(answer["pace"], answer)

        measured = alternate(
            lambda: one_round("bare"), {"free": lambda: one_round("bridge")}, pairs
        )["free"]
    bare, free = (
        [one_round.details for one_round in rounds]
        for rounds in (measured.reference, measured.variant)
    )
    return {
        **measured.figures(),
        "step_s": told["step"],
        "window_s": seconds,
        "own_time_ratio": _own_time(bare, free),
        "car_speeds_m_s": _same_speeds(bare, free),
        "received_per_sim_s": _received(free),
        "shares": _shares(free),
        "paused_graph": _paused(bare),
    }


def _own_time(bare, free):
    """Spread of the ratios of simulated time per processor time of the two stepping threads.

    What the simulation thread does beside stepping lowers it; what others take from it does not.
    None where the kernel does not tell a thread's times.
    """
    if any(len(one_round["spent"]["threads"]) < 2 for one_round in bare + free):
        return None

    def per_processor(one_round, thread):
        return one_round["pace"] / one_round["spent"]["threads"][thread]["cpu"]

    return Spread.of(
        per_processor(mine, "simulation") / per_processor(its, "reference")
        for its, mine in matched(bare, free)
    ).figures()


def _same_speeds(bare, free):
    """Speeds of the bridge's cars; they have to drive as the bare ones do."""
    found = []
    for car, _ in enumerate(bare[0]["speeds"]):
        its = statistics.median(one_round["speeds"][car] for one_round in bare)
        mine = statistics.median(one_round["speeds"][car] for one_round in free)
        if its < 0.5 * SPEED * WHEEL_RADIUS or abs(mine / its - 1.0) > SAME_SPEED:
            raise BenchError(
                f"car {car + 1} drives at {mine:.2f} m/s in the bridge and at "
                f"{its:.2f} m/s in the bare world, its wheels' speed is "
                f"{SPEED * WHEEL_RADIUS:.2f} m/s: not the same work"
            )
        found.append(mine)
    return found


def _received(free):
    """Messages per simulated second of each topic; none may be silent."""
    sim = sum(one_round["sim"] for one_round in free)
    counts = {
        topic: sum(one_round["received"][topic] for one_round in free)
        for topic in free[0]["received"]
    }
    silent = [topic for topic, count in counts.items() if not count]
    if silent:
        raise BenchError(f"nothing came on {', '.join(silent)}")
    return {topic: count / sim for topic, count in counts.items()}


def _shares(free):
    """Medians of what the simulation thread's time went into: part -> fraction."""
    return {
        part: statistics.median(one_round["shares"][part] for one_round in free)
        for part in free[0]["shares"]
    }


def _bound(row):
    """Words for what limits a variant, and for its ratio without all the rest of it."""
    shares = sorted(row["shares"].items(), key=lambda item: -item[1])
    ratio = Spread.read(row["ratio"]).median
    parts = ", ".join(f"{part} {100 * share:.0f} %" for part, share in shares)
    part, share = shares[0]
    return f"{parts}; with nothing but {part} it would be {ratio / share:.2f}"


def _paused(bare):
    """Processors that the paused graph took beside the reference."""
    return statistics.median(
        sum(share for role, share in one_round["spent"]["cpu"].items() if role != "observer")
        for one_round in bare
    )


def _beside_a_resting_graph(figures):
    """A variant's figures, if the paused graph took next to nothing from the reference."""
    if figures["paused_graph"] > PAUSED_LIMIT:
        raise BenchError(
            f"the paused graph took {figures['paused_graph']:.2f} processors beside the "
            f"reference, at most {PAUSED_LIMIT} are allowed"
        )
    return figures


def rows(figures):
    """Ratio and processors of each variant."""
    for name, row in figures.items():
        ratio = ratio_row(f"free, {name}", row, "bare stepping", "simulated s per s")
        text = ratio.text
        if name != BASE and BASE in figures:
            text += f"; {compared(row, figures[BASE], BASE)}"
        yield Row(ratio.label, text, ratio.value)
        if row["own_time_ratio"] is not None:
            own = Spread.read(row["own_time_ratio"])
            text = f"{own.text()} per processor time of the stepping thread"
            yield Row(f"own time, {name}", text, own)
        if max(row["shares"].values()) > 0.0:
            yield Row("  simulation thread", _bound(row))
        yield Row("  processors", spent_text(row["spent"]))
        yield Row(
            "  beside the reference",
            f"paused graph {row['paused_graph']:.3f}, others "
            f"{row['reference_spent']['others']:.2f}, stolen "
            f"{row['reference_spent']['stolen']:.2f}",
        )
