"""controller_group: starts the controllers of one group and stops those of the others.

The parameter controller_groups in the node's namespace is a mapping from groups to lists of
controllers.
"""

import argparse
import sys

import rospy

from controller_manager import controller_manager_interface as interface
from controller_manager.client import ManagerClient, ManagerError
from paddock_common import nodes

TIMEOUT = 5.0  # [s] wall time for the manager's services to be available


def read_groups():
    """Returns the groups, a dict of lists of names.

    Raises:
        ValueError: the parameter is not a mapping to lists of names.
    """
    groups = rospy.get_param("controller_groups", {})
    if not isinstance(groups, dict):
        raise ValueError(f"controller_groups is {groups!r}, must be a mapping of groups to names")
    for group, names in groups.items():
        if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
            raise ValueError(
                f"controller_groups has group '{group}' {names!r}, must be a list of names"
            )
    return groups


def print_groups(groups):
    """Prints all groups with their controllers."""
    print(f"Number of groups: {len(groups)}")
    for group, names in sorted(groups.items()):
        print("\n".join([f"  {group}", *(f"      {name}" for name in names)]))
    return True


def spawn(names):
    """Loads and starts controllers, one after the other; returns whether all started."""
    for name in names:
        interface.load_controller(name)
    return all([interface.start_controller(name) for name in names])


def switch(names, others):
    """Starts controllers and stops others in one step; loads what is not loaded.

    Args:
        others: names of the controllers of the other groups.
    """
    manager = ManagerClient()
    manager.wait(TIMEOUT, ["list_controllers", "load_controller", "switch_controller"])
    states = {controller.name: controller.state for controller in manager.list()}
    for state in states.values():
        if state not in ("running", "stopped"):
            print(f"Unknown controller state {state}", file=sys.stderr)
    for name in names:
        if name not in states and not interface.load_controller(name):
            print("Cancel group switching")
            return False
    start = [name for name in names if states.get(name) != "running"]
    stop = [name for name in others if states.get(name) == "running"]
    return interface.start_stop_controllers(start, stop)


def main():
    """Runs one command; returns 1 for an error, 0 as upstream's also if a controller refuses or
    the group has none."""
    parser = argparse.ArgumentParser(
        prog="controller_group", description="Start the controllers of a group."
    )
    commands = parser.add_subparsers(dest="command")
    commands.add_parser("list", help="list the groups and their controllers")
    for name, text in (
        ("spawn", "load and start the controllers of a group"),
        ("switch", "start those of a group and stop those of the others"),
    ):
        commands.add_parser(name, help=text).add_argument("group")
    options = parser.parse_args(rospy.myargv()[1:])
    if options.command is None:
        print("controller_group: a command is missing: list, spawn or switch", file=sys.stderr)
        return 1
    nodes.init_node("controller_group", anonymous=True, disable_rosout=True)
    try:
        run(options, read_groups())
        return 0
    except (ManagerError, ValueError, rospy.ROSException) as error:
        print(f"controller_group: {error}", file=sys.stderr)
        return 1


def run(options, groups):
    """Runs a command; returns whether it succeeded."""
    if options.command == "list":
        return print_groups(groups)
    names = list(dict.fromkeys(groups.get(options.group, ())))
    if not names:
        known = ", ".join(sorted(groups)) or "(none)"
        text = f"There is no controller defined in group {options.group}; groups are {known}"
        print(text, file=sys.stderr)
        return False
    if options.command == "spawn":
        return spawn(names)
    others = dict.fromkeys(name for listed in groups.values() for name in listed)
    return switch(names, [name for name in others if name not in names])
