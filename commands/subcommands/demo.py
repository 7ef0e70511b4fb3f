"""Drives through the real window without a display.

Starts world, control and window, drives with the window's own buttons, check box and slider, and
leaves in out/: an image of the window, one of the camera, the track from above with the driven
path, the path as CSV, and result.json. Exits 0 only if the car moved as commanded. Uses a ROS
master of its own on a free port. DEMO_DEADLINE=SECONDS changes the overall limit (300).
"""

from commands import environment, launching
from commands.launching import LaunchFile
from commands.paths import OUT

LAUNCH = LaunchFile("deepracer_teleop", "demo.launch", fixed=("out_dir",), options=False)
USAGE = "[ARG:=VALUE ...]"
RESULTS = ("window.png", "camera.png", "birdseye.png", "path.csv", "result.json")


def run(_options, rest):
    """Runs the demo."""
    arguments = LAUNCH.check(rest)
    deadline = launching.deadline_from("DEMO_DEADLINE", 300)
    environ = environment.ready()
    launching.run("demo", LAUNCH, environ, arguments, deadline, OUT, RESULTS)
