"""At real time with the camera on: rate, gaps, pace, lateness, processor time."""

import time

from figures import gap_figures, lateness_figures, rate_of
from launching import Launch
from report import Row, spent_text
from usage import Watch, between, summarise

SETTLE = 1.5  # [s] between the start and the window


def measure(quick, log):
    """One window of driving a circle."""
    seconds = 6.0 if quick else 30.0
    with Launch(log, ["real_time_factor:=1.0", "lidar:=false"]) as launch:
        observer = launch.observer("drive")
        observer.answer()
        begin = time.monotonic() + SETTLE
        observer.tell(f"{begin} {begin + seconds}")
        roles = launch.roles()
        bridge = roles["bridge"][0]
        watch = Watch(roles, {"simulation": (bridge, bridge)})
        time.sleep(max(0.0, begin - time.monotonic()))
        reading = watch.read()
        time.sleep(max(0.0, begin + seconds - time.monotonic()))
        spent = summarise([between(reading, watch.read())])
        driven = observer.answer()
    factor = rate_of(driven["ticks"])
    return {
        "camera": gap_figures(driven["pictures"], seconds),
        "real_time_factor": factor,
        "car_speed_m_s": driven["speed"],
        "clock_lateness": lateness_figures(driven["ticks"]),
        "spent": spent,
    }


def rows(figures):
    """Camera, pace, lateness, processors."""
    camera, late = figures["camera"], figures["clock_lateness"]
    yield Row(
        "camera at real time",
        f"{camera['rate_hz']:.2f} Hz, gaps p50/p99/max "
        f"{camera['gap_ms_p50']:.1f} / {camera['gap_ms_p99']:.1f} / "
        f"{camera['gap_ms_max']:.1f} ms",
        camera["rate_hz"],
        "Hz",
    )
    yield Row(
        "real-time factor",
        f"{figures['real_time_factor']:.4f}",
        figures["real_time_factor"],
        form=".4f",
    )
    yield Row(
        "/clock late p50/p99.9/max",
        f"{late['late_ms_p50']:.2f} / {late['late_ms_p999']:.2f}"
        f" / {late['late_ms_max']:.2f} ms, as a subscriber receives it",
        late["late_ms_p999"],
        "ms",
    )
    yield Row("  processors", spent_text(figures["spent"]))
