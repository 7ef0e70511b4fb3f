"""Mapping and navigating at real time: pace, lateness, what arrives, processor time of each node.

The robot alone comes first: what the simulator does with it is what the others are compared with.
What ./run add brings has to be there: navigation gmapping turtlebot3.
"""

import os
import shutil
import subprocess
import time

from figures import BenchError, lateness_figures, rate_of
from launching import WORLDS, Launch
from report import Row, spent_text
from usage import Monitor, spent_within

NOTED = 0.05  # processors, of a node that has a row of its own
SETTLE = 3.0  # [s] between the start of the drive and the window
TURTLEBOT3 = str(WORLDS / "turtlebot3.launch")
TRUCK = ("paddock_navigation", "vehicle.launch")
MAPPING = ("paddock_navigation", "map.launch")
# Name -> words after roslaunch, launch arguments, how it is driven (see observers.navigating).
WORLDS_OF = {
    "truck": (TRUCK, (), "0.5 0.4"),
    "truck_maps": (MAPPING, (), "0.5 0.4"),
    "turtlebot3": ((TURTLEBOT3,), ("stack:=none",), "0.15 0.3"),
    "turtlebot3_maps": ((TURTLEBOT3,), ("stack:=slam",), "0.15 0.3"),
    "turtlebot3_navigates": ((TURTLEBOT3,), ("stack:=navigation",), "goals"),
}
QUICK = ("turtlebot3", "turtlebot3_maps")
NEEDED = {"truck": "rospy", "truck_maps": "gmapping", "turtlebot3": "turtlebot3_gazebo"}
NEEDED.update(turtlebot3_maps="gmapping", turtlebot3_navigates="move_base")


def measure(quick, log):
    """A window of each world."""
    seconds = 8.0 if quick else 40.0
    os.environ.setdefault("TURTLEBOT3_MODEL", "burger")  # its launch files want it
    figures, errors = {}, {}
    for name in QUICK if quick else WORLDS_OF:
        try:
            figures[name] = measure_world(name, seconds, log)
        except BenchError as error:
            errors[name] = str(error)
    return dict(figures, errors=errors)


def measure_world(name, seconds, log):
    """Figures of one world.

    Args:
        seconds: of the window, wall time.
        log: file for what programs print.

    Raises:
        BenchError: a package is missing, or something that is due does not come.
    """
    file, arguments, drive = WORLDS_OF[name]
    for package in {NEEDED[name], "turtlebot3_gazebo" if TURTLEBOT3 in file else "rospy"}:
        if not is_there(package):
            raise BenchError(f"{package} is missing: ./run add navigation gmapping turtlebot3")
    with Launch(log, ["real_time_factor:=1.0", *arguments], file) as launch:
        observer = launch.observer("navigating.drive", *drive.split())
        observer.answer()
        begin = time.monotonic() + SETTLE
        observer.tell(f"{begin} {begin + seconds}")
        spent = spent_within(Monitor(launch.roles()), begin, seconds)
        driven = observer.answer()
    return {
        "real_time_factor": rate_of(driven["ticks"]),
        "clock_lateness": lateness_figures(driven["ticks"]),
        "scans_hz": driven["scans"] / seconds,
        "maps": driven["maps"],
        "spent": spent,
    }


def is_there(package):
    """Whether rospack finds a package."""
    if shutil.which("rospack") is None:
        return False
    return subprocess.run(["rospack", "find", package], capture_output=True).returncode == 0


def rows(figures):
    """Pace, lateness, messages and processors of each world."""
    for name, found in figures.items():
        late = found["clock_lateness"]
        factor = found["real_time_factor"]
        yield Row(f"real-time factor, {name}", f"{factor:.4f}", factor)
        yield Row(
            "  received",
            f"{found['scans_hz']:.2f} scans a second, {found['maps']} maps; /clock late p50/p99.9 "
            f"{late['late_ms_p50']:.2f} / {late['late_ms_p999']:.2f} ms",
        )
        yield Row("  processors", spent_text(found["spent"]))
        for node, share in sorted(found["spent"]["cpu"].items(), key=lambda item: -item[1]):
            if share >= NOTED:
                yield Row(f"{name}, {node}", f"{share:.2f} processors", share, "processors")
