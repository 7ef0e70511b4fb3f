"""At real time with the camera on: rate, gaps, pace, lateness, processor time."""

import time

from figures import gap_figures, lateness_figures, rate_of
from launching import WORLDS, Launch
from report import Row, spent_text
from usage import Monitor, spent_within

ALL_AT_ONCE = (str(WORLDS / "all_at_once.launch"),)
SETTLE = 1.5  # [s] between the start and the window


def measure(quick, log):
    """A window of driving a circle: the camera alone, and with all that is dear at once."""
    seconds = 6.0 if quick else 30.0
    alone = measure_world(seconds, log, ["lidar:=false"])
    return dict(alone, all_at_once=measure_world(seconds, log, [], ALL_AT_ONCE))


def measure_world(seconds, log, arguments, file=("track_model", "world.launch")):
    """Figures of one launch.

    Args:
        seconds: of the window, wall time.
        log: file for what programs print.
        file: words after roslaunch.
    """
    with Launch(log, ["real_time_factor:=1.0", *arguments], file) as launch:
        observer = launch.observer("timing.drive")
        observer.answer()
        begin = time.monotonic() + SETTLE
        observer.tell(f"{begin} {begin + seconds}")
        roles = launch.roles()
        bridge = roles["bridge"][0]
        monitor = Monitor(roles, {"simulation": (bridge, bridge)})
        spent = spent_within(monitor, begin, seconds)
        driven = observer.answer()
    return {
        "camera": gap_figures(driven["images"], seconds),
        "scans_hz": driven["scans"] / seconds,
        "real_time_factor": rate_of(driven["ticks"]),
        "car_speed_m_s": driven["speed"],
        "clock_lateness": lateness_figures(driven["ticks"]),
        "spent": spent,
    }


def rows(figures):
    """Camera, pace, lateness, processors; of both worlds."""
    yield from _world_rows(figures, "")
    if together := figures.get("all_at_once"):
        text = "six effort PIDs, a lidar of 1,081 rays at 40 Hz, the camera"
        yield Row("all at once", f"{text}: {together['scans_hz']:.2f} scans a second")
        yield from _world_rows(together, "all at once, ")


def _world_rows(figures, world):
    camera, late = figures["camera"], figures["clock_lateness"]
    yield Row(
        f"{world}camera at real time",
        f"{camera['rate_hz']:.2f} Hz, gaps p50/p99/max "
        f"{camera['gap_ms_p50']:.1f} / {camera['gap_ms_p99']:.1f} / "
        f"{camera['gap_ms_max']:.1f} ms",
        camera["rate_hz"],
        "Hz",
    )
    yield Row(
        f"{world}real-time factor",
        f"{figures['real_time_factor']:.4f}",
        figures["real_time_factor"],
    )
    yield Row(
        f"{world}/clock late",
        f"p50/p99.9/max {late['late_ms_p50']:.2f} / {late['late_ms_p999']:.2f}"
        f" / {late['late_ms_max']:.2f} ms, as a subscriber receives it",
        late["late_ms_p999"],
        "ms",
    )
    yield Row("  processors", spent_text(figures["spent"]))
