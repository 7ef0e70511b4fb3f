"""Drives a lap without a display.

Leaves in out/lap/: lap.mp4 (the camera with the window's overlay), lap.png, path.png (the path over
the track), path.csv, referee.csv, replay.html (the lap in 3-D, for any browser) and result.json;
out/lap/ is emptied first, unless a track file is not valid. With --starts above 1 each start is at
a random pose around the line. Launch arguments go to lap.launch, for example real_time_factor:=2
camera_width:=320 rviz:=true, or speed:=0.8 (line and pursuit only).
With a camera policy the camera has the 160x120 pixels that it has learned from.
LAP_DEADLINE=SECONDS changes the overall limit (300 and 300 a start).
"""

import os

from commands import environment, launching
from commands.errors import UsageError
from commands.launching import LaunchFile
from commands.parsing import add_options, one_of, whole_number
from commands.paths import OUT

LAUNCH = LaunchFile("deepracer_teleop", "lap.launch", fixed=("out_dir",), options=False)
USAGE = "[--track TRACK] [--driver DRIVER] [--policy NAME] [--starts N] [ARG:=VALUE ...]"
DRIVERS = ("slider", "buttons", "line", "pursuit", "policy")
ALIASES = {"slider_driver": "slider", "follow_line": "line", "pure_pursuit": "pursuit"}


def add_arguments(parser):
    """Declares track, driver and starts."""
    drivers = (
        "slider (the real window's slider under cruise control; the default), line (camera "
        "alone), pursuit (odometry and center line), policy (a trained one, see --policy), buttons "
        "(roams with the window's buttons for 40 s)"
    )
    tracks = "default, easy, medium, hard, or a file (YAML, .npy or .csv route)"
    policy = "of the driver policy: the name of a training (./run train), or an .onnx file"
    driver, starts = one_of("driver", DRIVERS, ALIASES), whole_number("starts")
    add_options(
        parser,
        ("--track", "TRACK", launching.resolve_track, "default", tracks),
        ("--driver", "DRIVER", driver, "slider", drivers),
        ("--policy", "NAME", launching.resolve_policy, None, policy),
        ("--starts", "N", starts, 1, "laps, each from a standing start"),
    )


def run(options, rest):
    """Runs the lap."""
    arguments = [*policy_arguments(options), *LAUNCH.check(rest)]
    deadline = launching.deadline_from("LAP_DEADLINE", 300 + 300 * options.starts)
    environ = environment.ready()
    if options.policy:
        from commands.bootstrap import venv

        venv.prepare_extras("gym")
    given = [f"{name}:={getattr(options, name)}" for name in ("track", "driver", "starts")]
    out = os.path.join(OUT, "lap")
    launching.run("lap", LAUNCH, environ, [*given, *arguments], deadline, out, results=None)


def policy_arguments(options):
    """Returns the launch arguments of the driver policy: its file, its sensors, walls if it has
    learned between walls.

    Raises:
        UsageError: A policy without its driver, or the driver without one.
    """
    if (options.driver == "policy") != bool(options.policy):
        raise UsageError("--driver policy and --policy NAME belong together")
    if not options.policy:
        return []
    arguments = [f"policy:={options.policy}"]
    settings = launching.policy_settings(options.policy)
    observation = settings.get("observation", ())
    if settings.get("walls"):
        arguments.append("walls:=true")
    if "lidar" in observation:
        arguments.append("lidar:=true")
    if "camera" in observation:
        arguments += ["camera_width:=160", "camera_height:=120"]
    return arguments
