"""World files as the bridge loads them, and what is said about what was read."""

import logging
import os

import rospy
from bullet_sim.description.warnings import grouped
from bullet_sim.description.world import empty_world
from bullet_sim.files import MAX_TEXT, read_file
from bullet_sim.formats.sdf.world import parse_world

from bullet_bridge.resolve import GAZEBO_WORLDS

_details = logging.getLogger("bullet_bridge.reading")  # goes to the node's log file alone


def log_warnings(warnings, model=""):
    """Log one line a cause; the single sentences go to the node's log file.

    Args:
        warnings: ReadWarnings.
        model: name of the model that they are about, for lines that do not name it.
    """
    lines = grouped(warnings)
    for line in lines:
        rospy.logwarn("%s", _with_name(line, model))
    if len(lines) < len(warnings):
        for warning in warnings:
            _details.info("%s", _with_name(warning, model))


def _with_name(line, model):
    return f"model '{model}': {line}" if model and f"'{model}'" not in line else line


def load_world(world, path, resolve):
    """Load a world file; one that cannot be had is an error in the log, and the empty world loads.

    Args:
        world: of the core.
        path: of the file, as Gazebo takes it (see Resolver.world); empty: nothing is loaded.
        resolve: Resolver; looks beside the world's file from now on.

    Returns:
        The WorldDescription, or None for no path.
    """
    if not path:
        return None
    described = _described(path, resolve)
    log_warnings(world.load(described))
    return described


def _described(path, resolve):
    try:
        found = resolve.world(path)
        text = read_file(found, "world file", MAX_TEXT)
        resolve.set_world(found)
        return parse_world(text, resolve, found)
    except ValueError as error:
        problem = error
    name, ending = os.path.splitext(os.path.basename(path))
    if name in GAZEBO_WORLDS and ending == ".world" and not os.path.isabs(path):
        rospy.logwarn(
            "world '%s' is one of Gazebo's own, which is not part of this stand-in; the empty "
            "world takes its place",
            path,
        )
    else:
        rospy.logerr("%s; the empty world takes its place", problem)
    return empty_world()
