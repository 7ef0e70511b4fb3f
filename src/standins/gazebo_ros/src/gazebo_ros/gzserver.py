"""gzserver and gzclient: Gazebo's options for the simulator's node."""

import argparse
import json
import os
import subprocess
import sys
import time

import rosgraph
import roslib.packages
import rospy

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
    for flags in (("--verbose",), ("-q", "--quiet"), ("--minimal_comms",)):
        parser.add_argument(*flags, action="store_true", help="accepted")
    text = "accepted; the solver is Paddock's"
    parser.add_argument("-e", "--physics", default="ode", metavar="ENGINE", help=text)
    plugins = {"action": "append", "default": [], "metavar": "FILE"}
    text = "plugins for ROS are built in, others are skipped"
    parser.add_argument("-s", "--server-plugin", **plugins, help=text)
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


def parameters(options):
    """Private parameters for the bridge, as command line arguments.

    Args:
        options: of parse().
    """
    arguments = [
        f"_world_file:={json.dumps(options.world)}",
        f"_paused:={str(options.pause).lower()}",
    ]
    if options.seed is not None:
        arguments.append(f"_seed:={options.seed}")
    return arguments


BRIDGE, PAGE, CLIENT = (
    ("bullet_bridge", "bridge"),
    ("bullet_web", "web"),
    ("gazebo_ros", "gzclient"),
)
OWN = ("__name:=", "__log:=")  # remappings that are of one node alone


def command(argv, program):
    """Command line of the bridge.

    Args:
        argv: the program's arguments with ROS remappings, without its name.
        program: name for help and messages.

    Returns:
        (arguments after the executable's name, messages about options without effect).
    """
    program_arguments = rospy.myargv([program] + list(argv))[1:]
    remappings = [argument for argument in argv if argument not in program_arguments]
    options, notes = parse(program_arguments, program)
    return parameters(options) + remappings, notes


def main(program, gui=False):
    """Replaces this process by the bridge.

    Args:
        gui: whether gzclient is started, too.

    Returns:
        1 when the bridge is missing.
    """
    arguments, notes = command(sys.argv[1:], program)
    for note in notes:
        print(f"{program}: {note}", file=sys.stderr)
    if gui:
        start_client(sys.argv[1:])
    return become(program, BRIDGE, arguments)


def start_client(argv):
    """Starts gzclient as a child of this process, with which it ends.

    Args:
        argv: arguments of this program, of which the client gets the remappings.
    """
    remappings = [word for word in argv if ":=" in word and not word.startswith(OWN)]
    for executable in roslib.packages.find_node(*CLIENT)[:1]:
        subprocess.Popen(
            ["setpriv", "--pdeathsig", "TERM", executable, *remappings], stdin=subprocess.DEVNULL
        )


def become(program, node, arguments):
    """Replaces this process by a node.

    Args:
        program: name for messages.
        node: package and executable.

    Returns:
        1: the node is missing.
    """
    executables = roslib.packages.find_node(*node)
    if not executables:
        print("{}: package {} has no executable {}".format(program, *node), file=sys.stderr)
        return 1
    sys.stdout.flush()
    os.execv(executables[0], [executables[0], *arguments])
    return 1  # not reached


SERVICE = "/gazebo/scene"
TIMEOUT = 60.0  # [s] wall clock
PERIOD = 0.2  # [s] between two looks for the simulator


def wait_for_simulator(timeout=TIMEOUT):
    """Waits until the master knows the simulator, so that the page does not delay its start.

    Returns:
        Whether it does.
    """
    master = rosgraph.Master("/gzclient")
    end = time.monotonic() + timeout
    while time.monotonic() < end:
        try:
            master.lookupService(SERVICE)
            return True
        except (OSError, rosgraph.MasterException):
            time.sleep(PERIOD)
    return False


def view():
    """Replaces this process by the node of the page, which opens it in a browser window.

    Returns:
        1 when that is missing.
    """
    arguments = sys.argv[1:]
    if not any(word.startswith("__name:=") for word in arguments):
        arguments = [*arguments, "__name:=gazebo_gui"]
    wait_for_simulator()
    return become("gzclient", PAGE, ["_open:=true", *arguments])
