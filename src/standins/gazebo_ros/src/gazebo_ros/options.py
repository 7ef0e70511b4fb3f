"""Command line of spawn_model: the flags of Gazebo Classic's script, plus -timeout."""

import argparse


def parse(argv, default_robot_namespace="/"):
    """Parses spawn_model's arguments.

    Args:
        argv: arguments without the program's name and without ROS remappings.
        default_robot_namespace: value of -robot_namespace when it is not given.

    Returns:
        argparse.Namespace; joints is a list of (name, position [rad or m]).
    """
    parser = argparse.ArgumentParser(
        prog="spawn_model", description="Spawn a model into the simulator."
    )
    _add_model(parser)
    _add_names(parser, default_robot_namespace)
    _add_pose(parser)
    _add_behaviour(parser)
    options = parser.parse_args(argv)
    try:
        options.joints = [(name, float(position)) for name, position in options.joints]
    except ValueError as error:
        parser.error(f"-J wants a joint name and a number: {error}")
    options.gazebo_namespace = options.gazebo_namespace.rstrip("/")
    return options


def _add_model(parser):
    """Which model, and where its text is."""
    kind = parser.add_mutually_exclusive_group(required=True)
    kind.add_argument("-urdf", action="store_true", help="the model is URDF")
    kind.add_argument("-sdf", action="store_true", help="the model is SDF")
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument("-file", metavar="FILE", help="read the model from a file")
    source.add_argument("-param", metavar="NAME", help="read the model from a ROS parameter")
    source.add_argument("-database", metavar="MODEL", help="include model://MODEL")
    source.add_argument("-stdin", action="store_true", help="read the model from standard input")
    parser.add_argument("-model", required=True, metavar="NAME", help="name of the new model")
    parser.add_argument(
        "-package_to_model",
        action="store_true",
        help="turn package:// into model:// in mesh file names",
    )


def _add_names(parser, default_robot_namespace):
    """Namespaces of the simulator and of the model."""
    parser.add_argument(
        "-gazebo_namespace",
        default="/gazebo",
        metavar="NS",
        help="namespace of the simulator (default: /gazebo)",
    )
    parser.add_argument(
        "-robot_namespace",
        default=default_robot_namespace,
        metavar="NS",
        help="namespace of the model's plug-ins (default: this node's)",
    )


def _add_pose(parser):
    """Where the model is spawned, and where its joints are."""
    parser.add_argument(
        "-reference_frame",
        default="",
        metavar="FRAME",
        help="model or link the pose is given in; empty or world: the world",
    )
    for flag, text in (
        ("-x", "x [m]"),
        ("-y", "y [m]"),
        ("-z", "z [m]"),
        ("-R", "roll [rad]"),
        ("-P", "pitch [rad]"),
        ("-Y", "yaw [rad]"),
    ):
        parser.add_argument(flag, type=float, default=0.0, help=text)
    parser.add_argument(
        "-J",
        dest="joints",
        nargs=2,
        action="append",
        default=[],
        metavar=("JOINT", "POSITION"),
        help="start a joint at a position",
    )


def _add_behaviour(parser):
    """What happens before and after."""
    parser.add_argument("-unpause", action="store_true", help="unpause physics afterwards")
    parser.add_argument("-wait", metavar="MODEL", help="first wait until this model exists")
    parser.add_argument(
        "-b", dest="bond", action="store_true", help="stay, and delete the model on exit"
    )
    parser.add_argument(
        "-timeout",
        type=float,
        default=60.0,
        metavar="T",
        help="wall-clock limit for services and for -wait [s] (default: 60)",
    )
