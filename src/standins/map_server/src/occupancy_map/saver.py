"""The node map_saver."""

import argparse
import sys

import rospy
from nav_msgs.msg import OccupancyGrid

from occupancy_map.files import save
from occupancy_map.server import from_message
from paddock_common import nodes


def parse(arguments):
    """Reads the command line; exits when it is wrong."""
    parser = argparse.ArgumentParser(
        prog="map_saver", description="Waits for one map and writes it."
    )
    parser.add_argument("--occ", type=int, default=65, help="cells from here on are black, 1..100")
    parser.add_argument("--free", type=int, default=25, help="cells up to here are white, 0..100")
    parser.add_argument("-f", dest="name", default="map", help="name of the files, no suffix")
    options = parser.parse_args(arguments)
    if not 1 <= options.occ <= 100:
        parser.error(f"--occ is {options.occ}, must be 1..100")
    if not 0 <= options.free < options.occ:
        parser.error(f"--free is {options.free}, must be 0 or more and below --occ")
    return options


def main():
    """Runs the node; returns 1 when the files cannot be written."""
    options = parse(rospy.myargv(sys.argv)[1:])
    nodes.init_interruptible("map_saver")
    rospy.loginfo("map_saver: waiting for %s", rospy.resolve_name("map"))
    try:
        message = rospy.wait_for_message("map", OccupancyGrid)
        image, path = save(options.name, from_message(message), options.occ, options.free)
    except rospy.ROSInterruptException:
        return 0
    except (OSError, ValueError) as error:
        rospy.logfatal("map_saver: %s", error)
        return 1
    rospy.loginfo("map_saver: wrote %s and %s", image, path)
    return 0
