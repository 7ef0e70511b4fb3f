"""Writes the map of a world without SLAM, for map_server; or the world of such a map.

A lidar looks around from the start and from wherever free space goes on: what it sees is free or
occupied, the rest is unknown. Robots of a launch file are left out; the first one's pose is the
start. For example:
  ./run map cybertruck truck.launch --out out/yard.yaml
  ./run map maze.world --height 0.1 --start 1 2
  ./run map levine.yaml                       # levine.world, with walls of 0.5 m
"""

import os

from commands import environment, processes
from commands.errors import UsageError
from commands.parsing import add_options, existing_file, number
from commands.paths import VENV_PYTHON

USAGE = "FILE.world | PACKAGE FILE.launch [ARG:=VALUE ...] | FILE.yaml [OPTIONS]"
MAPS = (".yaml", ".yml")
WORLDS = (".world", ".sdf")
HEIGHTS = 0.2, 0.5  # of the lidar, of walls [m]


def add_arguments(parser):
    """Declares what is read and the options of paddock_navigation.cli."""
    parser.add_argument("words", nargs="+", metavar="FILE", help="see above")
    height = f"of the lidar ({HEIGHTS[0]}), or of the walls ({HEIGHTS[1]}) [m]"
    add_options(
        parser,
        ("--height", "M", number("height", 10_000), None, height),
        ("--resolution", "M", number("resolution", 10_000), 0.05, "side of a cell [m] (0.05)"),
        ("--start", ("X", "Y"), float, None, "of the first look [m]", 2),
        ("--size", "M", number("size", 10_000), 60.0, "largest side of a map [m] (60)"),
        ("--out", "FILE", str, None, "what to write (out/NAME.yaml or .world)"),
    )


def run(options, rest):
    """Becomes the program that writes it."""
    first = options.words[0]
    ends_with = os.path.splitext(first)[1]
    if ends_with in (*MAPS, *WORLDS):
        options.words = [existing_file(first), *options.words[1:]]
    elif not any(word.endswith(".launch") for word in options.words):
        raise UsageError(f"{first!r} is no world, map or launch file", f"usage: ./run map {USAGE}")
    name = next(word for word in options.words if "." in os.path.basename(word))
    stem = os.path.splitext(os.path.basename(name))[0]
    out = os.path.abspath(options.out or os.path.join("out", stem))
    os.makedirs(os.path.dirname(out), exist_ok=True)
    height = options.height or HEIGHTS[ends_with in MAPS]
    words = [*options.words, *rest, "--height", str(height), "--size", str(options.size)]
    words += ["--resolution", str(options.resolution), "--out", out]
    if options.start:
        words += ["--start", *map(str, options.start)]
    processes.become_module(VENV_PYTHON, ["paddock_navigation.cli", *words], environment.ready())
