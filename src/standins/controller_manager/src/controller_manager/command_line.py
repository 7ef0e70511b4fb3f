"""The commands of controller_manager: their options and what they print."""

import argparse
import os
import sys

import rospy

from controller_manager import controller_manager_interface as interface
from controller_manager.client import ManagerClient, ManagerError
from paddock_common import nodes, yaml_file


def parse_spawner(argv):
    """Parses the spawner's arguments.

    Args:
        argv: arguments without the program's name and without ROS remappings.
    """
    parser = argparse.ArgumentParser(
        prog="spawner", description="Load and start controllers; stop and unload them on exit."
    )
    parser.add_argument("--stopped", action="store_true", help="load, but do not start")
    parser.add_argument(
        "--wait-for", metavar="TOPIC", help='first wait for "true" on this topic (std_msgs/Bool)'
    )
    _common(parser)
    parser.add_argument(
        "--shutdown-timeout",
        metavar="T",
        type=float,
        default=2.0,
        help="wall-clock limit for stopping and unloading on exit [s] (default: 2)",
    )
    parser.add_argument(
        "controllers",
        nargs="+",
        metavar="CONTROLLER",
        help="name, or YAML file whose top-level keys are controllers",
    )
    return parser.parse_args(argv)


def parse_unspawner(argv):
    """Parses the unspawner's arguments, see parse_spawner."""
    parser = argparse.ArgumentParser(
        prog="unspawner", description="Stop controllers; start them again on exit."
    )
    _common(parser)
    parser.add_argument("controllers", nargs="+", metavar="CONTROLLER")
    return parser.parse_args(argv)


def _common(parser):
    parser.add_argument(
        "-n",
        "--namespace",
        metavar="NS",
        default="",
        help="namespace of the controller manager (default: this node's)",
    )
    parser.add_argument(
        "--timeout",
        metavar="T",
        type=float,
        default=30.0,
        help="wall-clock limit for the services to be available [s] (default: 30)",
    )


def expand(names):
    """Replaces YAML files among controller names by the controllers in them.

    Args:
        names: controller names and paths of YAML files.

    Returns:
        (controllers, parameters): names in order, each once; dict of name -> parameters in
        the files, to be put on the parameter server.

    Raises:
        ValueError: the content of a file is not a mapping.
    """
    controllers, parameters = [], {}
    for name in names:
        if not os.path.isfile(name):
            names = [name]
        else:
            try:
                content = yaml_file.read(name)
            except ValueError as error:
                raise ValueError(f"file {error}") from None
            if not isinstance(content, dict) or not content:
                raise ValueError(
                    f"file {name}: expected a mapping of controller names to their "
                    f"parameters, found {type(content).__name__}"
                )
            parameters.update(content)
            names = list(content)
        controllers.extend(c for c in names if c not in controllers)
    return controllers, parameters


TIMEOUT = 30.0  # [s], wall clock; launch files start it with the simulator


def _for_each(function):
    return lambda names: all([function(name) for name in names])


def _list(_):
    interface.list_controllers()
    return True


def _list_types(_):
    interface.list_controller_types()
    return True


def _in_order(*functions):
    """One function for all names after the other, as upstream also if one fails."""
    return lambda names: all([_for_each(function)(names) for function in functions])


# name: (function, needs controller names, help)
COMMANDS = {
    "list": (_list, False, "list loaded controllers"),
    "list-types": (_list_types, False, "list the types that can be loaded"),
    "reload-libraries": (
        lambda names: interface.reload_libraries(True, restore="--restore" in names),
        False,
        "reload the types [--restore: and the controllers]",
    ),
    "load": (_in_order(interface.load_controller), True, "load controllers"),
    "unload": (_in_order(interface.unload_controller), True, "unload controllers"),
    "start": (_in_order(interface.start_controller), True, "start loaded controllers"),
    "stop": (_in_order(interface.stop_controller), True, "stop controllers"),
    "spawn": (
        _in_order(interface.load_controller, interface.start_controller),
        True,
        "load and start controllers",
    ),
    "kill": (
        _in_order(interface.stop_controller, interface.unload_controller),
        True,
        "stop and unload controllers",
    ),
}
SHORT = {"lc": "list", "lt": "list-types", "sp": "spawn", "kl": "kill"}


def usage():
    rows = [
        f"  {name + (' <name> ...' if entry[1] else ''):<28} {entry[2]}"
        for name, entry in COMMANDS.items()
    ]
    return "\n".join(["usage: controller_manager <command>", *rows])


def main():
    """Runs one command; returns 0 when it succeeded, 1 when not, 2 for a wrong command line."""
    argv = rospy.myargv()[1:]
    if not argv or argv[0] in ("-h", "--help"):
        print(usage())
        return 0 if argv else 2
    function, needs_names, _ = COMMANDS.get(SHORT.get(argv[0], argv[0]), (None, False, ""))
    if function is None:
        print(f"controller_manager: no command '{argv[0]}'\n{usage()}", file=sys.stderr)
        return 2
    if needs_names and not argv[1:]:
        print(f"controller_manager {argv[0]}: names of controllers are missing", file=sys.stderr)
        return 2
    nodes.init_node("controller_manager_command", anonymous=True, disable_rosout=True)
    manager = ManagerClient()
    try:
        manager.wait(TIMEOUT, ["list_controllers"])
        return 0 if function(argv[1:]) else 1
    except rospy.ROSInterruptException:
        return 1
    except ManagerError as error:
        print(f"controller_manager: {error}", file=sys.stderr)
        return 1
