"""Command to the joint states that show it, at real time, with and without camera."""

from figures import BenchError, percentile
from launching import WORLDS, Launch
from report import Row

SEEN = 0.95  # part of the commands that have to be seen
WORLD = ("track_model", "world.launch")
EACH_STEP = (str(WORLDS / "latency.launch"),)  # joint states at 1 kHz: the joint's own effect
# Name -> observer's second argument, launch file.
CASES = {
    "camera": ("camera", WORLD),
    "no_camera": ("no_camera", WORLD),
    "camera_1_khz": ("camera", EACH_STEP),
}


def measure(quick, log):
    """Two ways of commanding: a hinge's Float64, and /cmd_vel through the control node."""
    count = 20 if quick else 60
    result = {}
    for name in ("camera",) if quick else CASES:
        kind, file = CASES[name]
        with Launch(log, ["real_time_factor:=1.0", "lidar:=false"], file, True) as launch:
            answer = launch.observer("timing.latency", count, kind).answer()
        for kind in ("hinge", "wheel"):
            found = [value * 1e3 for value in answer[kind]]
            if len(found) < SEEN * answer["asked"]:
                raise BenchError(f"{len(found)} of {answer['asked']} commands were seen ({kind})")
            result[f"{kind}_{name}"] = {
                "samples": len(found),
                "publish_period_ms": answer["period"] * 1e3,
                "ms_p50": percentile(found, 0.5),
                "ms_p99": percentile(found, 0.99),
                "ms_max": max(found),
            }
    return result


def rows(figures):
    """One for the middle and one for the late ones."""
    for name, row in figures.items():
        yield Row(
            f"latency {name}, p50",
            f"{row['ms_p50']:.1f} ms (publish period {row['publish_period_ms']:.0f} ms)",
            row["ms_p50"],
            "ms",
        )
        yield Row(
            f"latency {name}, p99",
            f"{row['ms_p99']:.1f} ms, max {row['ms_max']:.1f}",
            row["ms_p99"],
            "ms",
        )
