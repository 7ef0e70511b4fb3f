"""Makes a replay of a rosbag: an HTML file that opens in any browser, without a server.

It shows the track, the robot's odometry and joint states in 3-D, with a time bar. Paddock's car and
truck are known by their topics; name the description of any other robot, for example:
  ./run replay drive.bag --track hard
  ./run replay rover.bag --urdf rover.urdf.xacro --odometry /odom --world yard.world
The file has at most 10 MB; images and the number of frames give way.
"""

import os

from commands import environment, launching, processes
from commands.errors import UsageError
from commands.parsing import add_options, existing_file
from commands.paths import VENV_PYTHON

USAGE = "FILE.bag [OPTIONS]"


def add_arguments(parser):
    """Declares the options of bullet_web.bag."""
    parser.add_argument("bag", metavar="FILE.bag", help="the bag")
    tracks = "default, easy, medium, hard, or a file"
    add_options(
        parser,
        ("--out", "FILE.html", str, None, "what to write (FILE.html)"),
        ("--track", "TRACK", launching.resolve_track, "default", tracks),
        ("--world", "FILE", existing_file, None, "a world, not a track"),
        ("--urdf", "FILE", existing_file, None, "the robot: URDF, xacro"),
        ("--odometry", "TOPIC", str, None, "the topic with the robot's pose"),
    )


def run(options, _rest):
    """Becomes the program that makes it."""
    words = [existing_file(options.bag), "--track", options.track]
    for name in ("world", "urdf", "odometry"):
        if getattr(options, name):
            words += [f"--{name}", getattr(options, name)]
    out = os.path.abspath(options.out or os.path.splitext(options.bag)[0] + ".html")
    if not os.path.isdir(os.path.dirname(out)):
        raise UsageError(f"there is no folder {os.path.dirname(out)!r}")
    command = ["bullet_web.bag", *words, "--out", out]
    processes.become_module(VENV_PYTHON, command, environment.ready())
