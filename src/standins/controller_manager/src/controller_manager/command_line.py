"""The commands of controller_manager: their options and what they print."""

import argparse
import os
import sys

import rospy

from controller_manager import controller_manager_interface as interface
from controller_manager.client import ManagerError
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
        "--no-timeout", action="store_true", help="wait without a limit, as --timeout 0"
    )
    parser.add_argument("--shutdown-timeout", metavar="T", help="deprecated, without effect")
    parser.add_argument(
        "controllers",
        nargs="+",
        metavar="CONTROLLER",
        help="name, or YAML file whose top-level keys are controllers",
    )
    options = parser.parse_args(argv)
    return _with_limit(options, options.no_timeout)


def parse_unspawner(argv):
    """Parses the unspawner's arguments, see parse_spawner."""
    parser = argparse.ArgumentParser(
        prog="unspawner", description="Stop controllers; start them again on exit.", add_help=False
    )
    _common(parser, limit=0.0)
    parser.add_argument("controllers", nargs="+", metavar="CONTROLLER")
    if not argv or argv[0] in ("-h", "--help"):  # as upstream's
        parser.print_help()
        sys.exit(1)
    return _with_limit(parser.parse_args(argv))


def _with_limit(options, without=False):
    """The options with None for a time-out without limit."""
    if without or options.timeout <= 0.0:
        options.timeout = None
    return options


def _common(parser, limit=30.0):
    text = "namespace of the controller manager (default: this node's)"
    parser.add_argument("-n", "--namespace", metavar="NS", default="", help=text)
    text = f"wall-clock limit for the services [s]; 0: none (default: {limit:g})"
    parser.add_argument("--timeout", metavar="T", type=float, default=limit, help=text)


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


def _of_names(*functions):
    """Calls one function with all names after the other, as upstream also if one fails."""

    def call(names):
        for function in functions:
            for name in names:
                function(name)

    return call


# name, with what follows it: (function of the words behind it, help)
COMMANDS = {
    "list": (lambda _: interface.list_controllers(), "list loaded controllers"),
    "list-types": (lambda _: interface.list_controller_types(), "list the types"),
    "reload-libraries": (
        lambda words: interface.reload_libraries(True, restore="--restore" in words),
        "reload the types [--restore: and the controllers]",
    ),
    "load <name> ...": (_of_names(interface.load_controller), "load controllers"),
    "unload <name> ...": (_of_names(interface.unload_controller), "unload controllers"),
    "start <name> ...": (_of_names(interface.start_controller), "start loaded controllers"),
    "stop <name> ...": (_of_names(interface.stop_controller), "stop controllers"),
    "spawn <name> ...": (
        _of_names(interface.load_controller, interface.start_controller),
        "load and start controllers",
    ),
    "kill <name> ...": (
        _of_names(interface.stop_controller, interface.unload_controller),
        "stop and unload controllers",
    ),
}
SHORT = {"lc": "list", "lt": "list-types", "sp": "spawn", "kl": "kill"}


def usage():
    rows = [f"  {name:<28} {text}" for name, (_, text) in COMMANDS.items()]
    return "\n".join(["usage: controller_manager <command>", *rows])


def main():
    """Runs one command; returns 0, as upstream's also when the manager refuses; for another, -h
    among them, the usage, on stdout as well, and 1."""
    argv = rospy.myargv()[1:]
    if not argv:
        print(usage())
        return 0
    functions = {name.split()[0]: function for name, (function, _) in COMMANDS.items()}
    function = functions.get(SHORT.get(argv[0], argv[0]))
    if function is None:
        print(usage())
        return 1
    nodes.init_node("controller_manager_command", anonymous=True, disable_rosout=True)
    try:
        function(argv[1:])
        return 0
    except rospy.ROSInterruptException:
        return 0
    except ManagerError as error:
        print(f"controller_manager: {error}", file=sys.stderr)
        return 1
