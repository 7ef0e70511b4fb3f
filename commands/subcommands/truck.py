"""Starts the Cyber Truck in a yard, or backs its trailer.

Without --back: a yard, the truck with lidar and trailer, controllers and the drive node, without a
screen. trailer:=false leaves the trailer out, rviz:=true opens rviz. Options of roslaunch, such as
--screen, are handed on.

With --back the truck backs its trailer along a SHAPE on a ROS master of its own, without a screen,
and ends; out/ then holds back_SHAPE.png (path, outlines every meter, errors), .csv, .html (the
drive in 3-D, for any browser) and .json. Exits 0 only if the trailer arrived. Launch arguments go
to cybertruck/launch/back_demo.launch: size, speed, real_time_factor, odom_source, gui.
DEMO_DEADLINE=SECONDS changes the overall limit (300).
"""

import glob
import os

from commands import environment, launching, locks, processes
from commands.errors import CommandError, say
from commands.launching import LaunchFile
from commands.parsing import one_of
from commands.paths import OUT, read

LAUNCH = LaunchFile("cybertruck", "truck.launch")
BACK = LaunchFile("cybertruck", "back_demo.launch", fixed=("shape", "out_dir"), options=False)
USAGE = "[--back SHAPE] [ARG:=VALUE ...]"
SHAPES = ("line", "arc", "s", "lane-change", "park")


def add_arguments(parser):
    """Declares --back."""
    parser.add_argument(
        "--back", metavar="SHAPE", type=one_of("shape", SHAPES), help=", ".join(SHAPES)
    )


def run(options, rest):
    """Becomes roslaunch, or backs the trailer."""
    if options.back:
        return back_up(options.back, BACK.check(rest))
    arguments = LAUNCH.check(rest)
    environ = environment.ready()
    launching.refuse_second_world(environ)
    return launching.become(LAUNCH, arguments, environ)


def back_up(shape, arguments):
    """Backs the trailer along a shape and prints the figures.

    Raises:
        CommandError: It did not arrive.
    """
    deadline = launching.deadline_from("DEMO_DEADLINE", 300)
    environ = environment.ready()
    locks.take_results(os.path.join(OUT, f"back_{shape}"))
    os.makedirs(OUT, exist_ok=True)
    for path in glob.glob(os.path.join(OUT, f"back_{shape}.*")):
        os.remove(path)
    where = launching.where_to_look(environ)
    given = [f"shape:={shape}", f"out_dir:={OUT}"]
    try:
        status = launching.start(BACK, environ, [*given, *arguments], deadline)
    except processes.DeadlineExceeded:
        raise CommandError(f"backing did not end within {deadline} s", where) from None
    result = os.path.join(OUT, f"back_{shape}.json")
    if status != 0 or not launching.is_ok(result):
        raise CommandError("backing did not arrive", where)
    say(read(result), end="")
    say(f"plots and figures: out/back_{shape}.png, .csv, .json")
