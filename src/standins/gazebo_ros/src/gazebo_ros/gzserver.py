"""gzserver and gzclient: Gazebo's options for the simulator's node."""

import argparse
import json
import os
import sys

import roslib.packages
import rospy
from std_srvs.srv import Trigger

from paddock_common import nodes, waiting

EMPTY_WORLD = "worlds/empty.world"
ROS_PLUGINS = ("libgazebo_ros_api_plugin.so", "libgazebo_ros_paths_plugin.so")
VALUES_WITHOUT_EFFECT = (
    ("-g", "--gui-plugin"),
    ("-o", "--profile"),
    ("-p", "--play"),
    ("--iters",),
    ("--record_path",),
    ("--record_encoding",),
    ("--record_period",),
    ("--record_filter",),
)
FLAGS_WITHOUT_EFFECT = (("-r", "--record"), ("--record_resources",), ("--lockstep",))


def parse(argv, program="gzserver"):
    """Parses Gazebo Classic's arguments.

    Args:
        argv: arguments without the program's name and without ROS remappings.

    Returns:
        (argparse.Namespace, list of messages about options without effect).
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
        help="plugins for ROS are built in, others are skipped",
    )
    for flags in VALUES_WITHOUT_EFFECT:
        parser.add_argument(*flags, metavar="X", help="without effect")
    for flags in FLAGS_WITHOUT_EFFECT:
        parser.add_argument(*flags, action="store_true", help="without effect")
    parser.add_argument("-v", "--version", action="version", version="Gazebo stand-in on PyBullet")
    options, unknown = parser.parse_known_args(argv)
    return options, _without_effect(options) + [
        f"argument '{argument}' is not known and has no effect" for argument in unknown
    ]


def _without_effect(options):
    notes = [
        f"server plugin '{name}' cannot be loaded here and is skipped"
        for name in options.server_plugin
        if name.rsplit("/", 1)[-1] not in ROS_PLUGINS
    ]
    for *_, flag in VALUES_WITHOUT_EFFECT + FLAGS_WITHOUT_EFFECT:
        if getattr(options, flag.lstrip("-").replace("-", "_")):
            notes.append(f"{flag} has no effect here")
    return notes


def parameters(options, gui):
    """Private parameters for the bridge, as command line arguments.

    Args:
        options: of parse().
        gui: whether the viewer is to open.
    """
    arguments = [
        f"_world_file:={json.dumps(options.world)}",
        f"_paused:={str(options.pause).lower()}",
        f"_gui:={str(gui).lower()}",
        f"_headless:={str(not gui).lower()}",
    ]
    if options.seed is not None:
        arguments.append(f"_seed:={options.seed}")
    return arguments


BRIDGE = ("bullet_bridge", "bridge")


def command(argv, gui, program):
    """Command line of the bridge.

    Args:
        argv: the program's arguments with ROS remappings, without its name.
        gui: whether the viewer is to open.
        program: name for help and messages.

    Returns:
        (arguments after the executable's name, messages about options without effect).
    """
    program_arguments = rospy.myargv([program] + list(argv))[1:]
    remappings = [argument for argument in argv if argument not in program_arguments]
    options, notes = parse(program_arguments, program)
    return parameters(options, gui) + remappings, notes


def main(program, gui=False):
    """Replaces this process by the bridge; returns 1 when the bridge is missing."""
    arguments, notes = command(sys.argv[1:], gui, program)
    for note in notes:
        print(f"{program}: {note}", file=sys.stderr)
    executables = roslib.packages.find_node(*BRIDGE)
    if not executables:
        print("{}: package {} has no executable {}".format(program, *BRIDGE), file=sys.stderr)
        return 1
    sys.stdout.flush()
    os.execv(executables[0], [executables[0]] + arguments)
    return 1  # not reached


SERVICE = "/gazebo/open_viewer"
TIMEOUT = 60.0  # [s] wall clock


def open_viewer(service=SERVICE, timeout=TIMEOUT):
    """Opens the viewer.

    Returns:
        '' or why there is none.

    Raises:
        rospy.ROSInterruptException: the node was shut down meanwhile.
    """
    try:
        waiting.wait_for_service(service, timeout)
        response = rospy.ServiceProxy(service, Trigger)()
    except (waiting.WaitTimeout, rospy.ServiceException) as error:
        return str(error)
    return "" if response.success else response.message


def view():
    """Runs the node; returns 0 also without a viewer: the simulation does not need one."""
    nodes.init_interruptible("gazebo_gui", anonymous=True)
    if not any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM")):
        print("gzclient: no display (DISPLAY is not set), so no viewer", file=sys.stderr)
        return 0
    try:
        problem = open_viewer()
    except rospy.ROSInterruptException:
        return 0
    if problem:
        rospy.logwarn("no viewer: %s", problem)
        return 0
    rospy.spin()
    return 0
