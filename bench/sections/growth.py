"""Memory and processor time of the bridge, idle and driving, over simulated minutes."""

from launching import Launch
from report import Row, lines
from usage import cpu_seconds, memory_bytes

MB = 1e6


def measure(quick, log):
    """Samples at even distances of simulated time; growth counts from a tenth of them on."""
    span = 30.0 if quick else 600.0  # simulated time of each phase [s]
    result = {}
    with Launch(log, ["real_time_factor:=0", "lidar:=false"]) as launch:
        observer = launch.observer("timing.growth", span)
        for phase in ("idle", "driving"):
            samples = []
            while not (answer := observer.answer()).get("done"):
                pid = launch.pid("bridge")
                samples.append((answer["sim"], memory_bytes(pid) / MB, cpu_seconds(pid)))
                observer.tell("go")
            first = samples[max(1, len(samples) // 10)]  # after warming up
            last = samples[-1]
            result[phase] = {
                "sim_s": last[0] - samples[0][0],
                "memory_mb_first": first[1],
                "memory_mb_last": last[1],
                "growth_percent": 100.0 * (last[1] / first[1] - 1.0),
                "cpu_s_per_sim_s": (last[2] - first[2]) / max(last[0] - first[0], 1e-9),
                "memory_mb": [round(sample[1], 2) for sample in samples],
                "at_sim_s": [round(sample[0], 1) for sample in samples],
            }
    return result


def rows(figures):
    """One a phase."""
    for phase, row in figures.items():
        yield Row(
            f"memory, {phase}",
            f"{row['memory_mb_first']:.1f} -> "
            f"{row['memory_mb_last']:.1f} MB ({row['growth_percent']:+.2f} %) over "
            f"{row['sim_s']:.0f} simulated s, {row['cpu_s_per_sim_s']:.3f} s of a processor "
            "per simulated s",
            row["memory_mb_last"],
            "MB",
            ".1f",
        )


def draw(figures, folder):
    """Memory over simulated time."""
    lines(
        {phase: (row["at_sim_s"], row["memory_mb"]) for phase, row in figures.items()},
        folder / "growth.png",
        "simulated s",
        "memory of the bridge (PSS) [MB]",
    )
