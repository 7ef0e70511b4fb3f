"""Command lines of spawner and unspawner, and the controller names in them."""

import argparse
import os

from paddock_common import yaml_file


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
        help="wall-clock limit for the services to come [s] (default: 30)",
    )


def expand(names):
    """Replaces YAML files among controller names by the controllers in them.

    Args:
        names: controller names and paths of YAML files.

    Returns:
        (controllers, parameters): names in order, each once; dict of name -> parameters found in
        the files, to be put on the parameter server.

    Raises:
        ValueError: a file holds something else than a mapping.
    """
    controllers, parameters = [], {}
    for name in names:
        if not os.path.isfile(name):
            found = [name]
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
            found = list(content)
        controllers.extend(c for c in found if c not in controllers)
    return controllers, parameters
