"""gzserver, gazebo and their debugging forms: start the bridge with Gazebo's command line."""

import os
import sys

import roslib.packages
import rospy

from gazebo_ros import server_options

BRIDGE = ("bullet_bridge", "bridge")


def command(argv, gui, program):
    """Command line of the bridge.

    Args:
        argv: the program's arguments with ROS remappings, without its name.
        gui: whether the viewer is to open.
        program: name for help and messages.

    Returns:
        (arguments after the executable's name, sentences about options without effect).
    """
    own = rospy.myargv([program] + list(argv))[1:]
    remappings = [word for word in argv if word not in own]
    options, notes = server_options.parse(own, program)
    return server_options.parameters(options, gui) + remappings, notes


def main(program, gui=False):
    """Replaces this process by the bridge; returns 1 when the bridge is missing."""
    arguments, notes = command(sys.argv[1:], gui, program)
    for sentence in notes:
        print(f"{program}: {sentence}", file=sys.stderr)
    found = roslib.packages.find_node(*BRIDGE)
    if not found:
        print("{}: package {} has no executable {}".format(program, *BRIDGE), file=sys.stderr)
        return 1
    sys.stdout.flush()
    os.execv(found[0], [found[0]] + arguments)
    return 1  # not reached
