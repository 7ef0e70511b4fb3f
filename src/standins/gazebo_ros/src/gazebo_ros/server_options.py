"""Command line of gzserver and gazebo, turned into parameters of the bridge."""

import argparse
import json

EMPTY_WORLD = "worlds/empty.world"
ROS_PLUGINS = ("libgazebo_ros_api_plugin.so", "libgazebo_ros_paths_plugin.so")


def parse(argv, program="gzserver"):
    """Parses Gazebo Classic's arguments.

    Args:
        argv: arguments without the program's name and without ROS remappings.
        program: name for the help text.

    Returns:
        (argparse.Namespace, list of sentences about options without effect).
    """
    parser = argparse.ArgumentParser(prog=program, description="Start the simulator with a world.")
    parser.add_argument(
        "world", nargs="?", default=EMPTY_WORLD, help=f"SDF world file (default: {EMPTY_WORLD})"
    )
    parser.add_argument("-u", "--pause", action="store_true", help="start paused")
    parser.add_argument("--seed", type=int, default=None, help="of all sensor noise")
    parser.add_argument("--verbose", action="store_true", help="accepted")
    parser.add_argument("-q", "--quiet", action="store_true", help="accepted")
    parser.add_argument("--minimal_comms", action="store_true", help="accepted")
    parser.add_argument(
        "-e",
        "--physics",
        default="ode",
        metavar="ENGINE",
        help="accepted; the engine is always Bullet",
    )
    parser.add_argument(
        "-s",
        "--server-plugin",
        action="append",
        default=[],
        metavar="FILE",
        help="plugins for ROS are built in, others are left out",
    )
    for flags in (
        ("-g", "--gui-plugin"),
        ("-o", "--profile"),
        ("-p", "--play"),
        ("--iters",),
        ("--record_path",),
        ("--record_encoding",),
        ("--record_period",),
        ("--record_filter",),
    ):
        parser.add_argument(*flags, metavar="X", help="without effect")
    for flags in (("-r", "--record"), ("--record_resources",), ("--lockstep",)):
        parser.add_argument(*flags, action="store_true", help="without effect")
    parser.add_argument("-v", "--version", action="version", version="Gazebo stand-in on PyBullet")
    options, unknown = parser.parse_known_args(argv)
    return options, _without_effect(options) + [
        f"argument '{word}' is not known and has no effect" for word in unknown
    ]


def _without_effect(options):
    notes = [
        f"server plugin '{name}' cannot be loaded here and is left out"
        for name in options.server_plugin
        if name.rsplit("/", 1)[-1] not in ROS_PLUGINS
    ]
    for name in (
        "gui_plugin",
        "profile",
        "play",
        "iters",
        "record_path",
        "record_encoding",
        "record_period",
        "record_filter",
        "record",
        "record_resources",
        "lockstep",
    ):
        if getattr(options, name):
            notes.append(f"--{name} has no effect here")
    return notes


def parameters(options, gui):
    """Private parameters for the bridge, as command line arguments.

    Args:
        options: as parse gives them.
        gui: whether the viewer is to open.
    """
    words = [
        f"_world_file:={json.dumps(options.world)}",
        f"_paused:={str(options.pause).lower()}",
        f"_gui:={str(gui).lower()}",
        f"_headless:={str(not gui).lower()}",
    ]
    if options.seed is not None:
        words.append(f"_seed:={options.seed}")
    return words
