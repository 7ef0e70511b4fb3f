"""spawn_model: its options, the model's text, the service's call."""

import argparse
import os
import re
import sys
import threading
from xml.sax.saxutils import escape

import rospy
from bullet_sim.errors import SimError
from bullet_sim.pose import quaternion_from_rpy
from bullet_sim.xml_reader import Document, decoded, parse
from gazebo_msgs.srv import DeleteModel, GetWorldProperties, SetModelConfiguration, SpawnModel
from geometry_msgs.msg import Point, Pose, Quaternion
from std_srvs.srv import Empty

from paddock_common import nodes, waiting


def parse_options(argv, default_robot_namespace="/"):
    """Parses spawn_model's arguments.

    Args:
        argv: arguments without the program's name and without ROS remappings.
        default_robot_namespace: value of -robot_namespace when it is missing.

    Returns:
        argparse.Namespace; joints is a list of (name, position [rad or m]).
    """
    parser = argparse.ArgumentParser(
        prog="spawn_model", description="Spawn a model into the simulator."
    )
    _declare(parser, default_robot_namespace)
    options = parser.parse_args(argv)
    try:
        options.joints = [(name, float(position)) for name, position in options.joints]
    except ValueError as error:
        parser.exit(1, f"spawn_model: -J wants a joint name and a number: {error}\n")
    options.timeout = options.timeout if options.timeout > 0.0 else None
    options.gazebo_namespace = options.gazebo_namespace.rstrip("/")
    return options


def _declare(parser, default_robot_namespace):
    """Declares upstream's options."""
    kind, source = (parser.add_mutually_exclusive_group(required=True) for _ in range(2))
    kind.add_argument("-urdf", action="store_true", help="the model is URDF")
    kind.add_argument("-sdf", action="store_true", help="the model is SDF")
    source.add_argument("-file", metavar="FILE", help="read the model from a file")
    source.add_argument("-param", metavar="NAME", help="read the model from a ROS parameter")
    source.add_argument("-database", metavar="MODEL", help="include model://MODEL")
    source.add_argument("-stdin", action="store_true", help="read the model from standard input")
    parser.add_argument("-model", required=True, metavar="NAME", help="name of the new model")
    robots = "namespace of the model's plug-ins (default: this node's)"
    for flag, metavar, default, text in (
        ("-gazebo_namespace", "NS", "/gazebo", "namespace of the simulator (default: /gazebo)"),
        ("-robot_namespace", "NS", default_robot_namespace, robots),
        ("-reference_frame", "FRAME", "", "model or link of the pose; empty or world: the world"),
        ("-wait", "MODEL", None, "first wait until this model exists"),
    ):
        parser.add_argument(flag, metavar=metavar, default=default, help=text)
    for name in ("x", "y", "z", "Roll", "Pitch", "Yaw"):
        text = f"{name.lower()} [{'m' if len(name) == 1 else 'rad'}]"
        parser.add_argument(f"-{name[0]}", type=float, default=0.0, help=text)
    joints = {"dest": "joints", "nargs": 2, "metavar": ("JOINT", "POSITION")}
    text = "start a joint at a position"
    parser.add_argument("-J", **joints, action="append", default=[], help=text)
    text = "wall-clock limit for services and for -wait [s] (default: 0, none)"
    parser.add_argument("-timeout", type=float, default=0.0, metavar="T", help=text)
    for flag, name, text in (
        ("-package_to_model", None, "replace package:// by model:// in mesh file names"),
        ("-unpause", None, "unpause physics afterwards"),
        ("-b", "bond", "stay, and delete the model on exit"),
    ):
        parser.add_argument(flag, dest=name, action="store_true", help=text)


DATABASE_TEMPLATE = (
    '<sdf version="1.4"><world name="default"><include><uri>model://%s</uri>'
    "</include></world></sdf>"
)
_MESH = re.compile(r"<mesh\b[^>]*\bfilename\s*=\s*[\"']package://")


class ModelTextError(ValueError):
    """The model's text cannot be used."""


def from_database(model):
    """Returns SDF text that includes a model by its name."""
    return DATABASE_TEMPLATE % escape(model)


def checked(text, source, package_to_model=False):
    """Checks that the simulator can read a text as XML.

    Args:
        text: URDF or SDF, str or bytes.
        source: where it came from, for the error text.
        package_to_model: replace package:// by model:// in mesh file names.

    Returns:
        The text (str) as the service wants it.

    Raises:
        ModelTextError: the text is empty or is not XML.
    """
    if not text.strip():
        raise ModelTextError(f"{source} is empty, expected URDF or SDF")
    text = decoded(text, Document(source))
    try:
        parse(text, source)
    except SimError as error:
        raise ModelTextError(str(error)) from None
    if package_to_model:
        text = _MESH.sub(lambda match: match.group().replace("package://", "model://", 1), text)
    return text


ANSWER_LIMIT = 1.0  # wall time that a stop leaves a call of the simulator to be answered [s]


class SpawnError(Exception):
    """The model could not be spawned; the text is the reason."""


def read_model(opts):
    """Returns the model's text from the source in the options.

    Raises:
        SpawnError: the file or parameter cannot be read.
        model_text.ModelTextError: the text is not a model.
    """
    if opts.file:
        rospy.loginfo("Loading model XML from file %s", opts.file)
        if not os.path.exists(opts.file):
            raise SpawnError(f"Error: specified file {opts.file} does not exist")
        if not os.path.isfile(opts.file):
            raise SpawnError(f"Error: specified file {opts.file} is not a file")
        try:
            with open(opts.file, "rb") as stream:
                text = stream.read()
        except OSError as error:
            raise SpawnError(f"Error reading file {opts.file}: {error.strerror}") from None
        source = "file " + opts.file
    elif opts.param:
        rospy.loginfo("Loading model XML from ros parameter %s", opts.param)
        source = "parameter " + rospy.resolve_name(opts.param)
        try:
            text = str(rospy.get_param(opts.param))
        except KeyError:
            raise SpawnError(f"{source} is not set") from None
    elif opts.database:
        rospy.loginfo("Loading model XML from Gazebo Model Database")
        source, text = "model " + opts.database, from_database(opts.database)
    else:
        rospy.loginfo("Loading model XML from stdin")
        source, text = "standard input", sys.stdin.read()
    return checked(text, source, opts.package_to_model)


class Simulator:
    """The simulator's services, called with a time-out.

    Args:
        namespace: e.g. /gazebo.
        timeout: wall-clock limit for each service to appear [s]; None: there is none.
    """

    def __init__(self, namespace, timeout):
        self._namespace = namespace
        self._timeout = timeout

    def call(self, service, service_type, label="", failure="", **fields):
        """Waits for a service and calls it; a refusal is an error.

        Args:
            label: of the line that tells the answer; empty: there is none.
            failure: upstream's line about a call that fails, before ours.

        Raises:
            SpawnError: the service was not available, failed or refused.
        """
        name = f"{self._namespace}/{service}"
        try:
            rospy.loginfo("Waiting for service %s", name)
            waiting.wait_for_service(name, self._timeout)
            rospy.loginfo("Calling service %s", name)
            response = rospy.ServiceProxy(name, service_type)(**fields)
        except waiting.WaitTimeout as error:
            raise SpawnError(f"{error}. Is the simulator running?") from None
        except rospy.ServiceException as error:
            print(f"Service call failed: {error}")
            if failure:
                rospy.logerr("%s", failure)
            raise SpawnError(f"{name} failed: {error}") from None
        if label:
            rospy.loginfo("%s status: %s", label, response.status_message)
        if not getattr(response, "success", True):
            if failure:
                rospy.logerr("%s", failure)
            raise SpawnError(f"{name} refused: {response.status_message}")
        return response

    def wait_for_model(self, model):
        """Polls the world's list of models until one exists."""
        self.call("get_world_properties", GetWorldProperties)
        proxy = rospy.ServiceProxy(self._namespace + "/get_world_properties", GetWorldProperties)

        def _exists():
            try:
                return model in proxy().model_names
            except rospy.ServiceException:
                return False

        try:
            waiting.wait_until(_exists, self._timeout, f"model {model} (-wait)")
        except waiting.WaitTimeout as error:
            raise SpawnError(str(error)) from None


def spawn(opts, spawned):
    """Spawns the model by the options.

    Args:
        spawned: Event that is set once the model is there.

    Raises:
        SpawnError, model_text.ModelTextError: spawning failed.
    """
    simulator = Simulator(opts.gazebo_namespace, opts.timeout)
    if opts.wait:
        rospy.loginfo("Waiting for model %s before proceeding.", opts.wait)
        simulator.wait_for_model(opts.wait)
    text = read_model(opts)
    pose = Pose(
        Point(opts.x, opts.y, opts.z),
        Quaternion(*quaternion_from_rpy(opts.R, opts.P, opts.Y)),
    )
    service = "spawn_urdf_model" if opts.urdf else "spawn_sdf_model"
    simulator.call(
        service,
        SpawnModel,
        "Spawn",
        "Spawn service failed. Exiting.",
        model_name=opts.model,
        model_xml=text,
        robot_namespace=opts.robot_namespace,
        initial_pose=pose,
        reference_frame=opts.reference_frame,
    )
    spawned.set()
    if opts.joints:
        names, positions = zip(*opts.joints)
        simulator.call(
            "set_model_configuration",
            SetModelConfiguration,
            "Set model configuration",
            "SetModelConfiguration service failed. Exiting.",
            model_name=opts.model,
            urdf_param_name="",
            joint_names=names,
            joint_positions=positions,
        )
    if opts.unpause:
        rospy.loginfo("Unpausing physics")
        simulator.call("unpause_physics", Empty)


def _delete(opts, spawned):
    if not spawned.wait(ANSWER_LIMIT):
        return
    rospy.loginfo("Deleting model %s", opts.model)
    try:
        rospy.ServiceProxy(opts.gazebo_namespace + "/delete_model", DeleteModel)(opts.model)
    except rospy.ServiceException as error:
        rospy.logerr("Delete model service call failed: %s", error)


def main():
    """Runs the node; returns its exit code: 0 spawned or interrupted, 1 not spawned."""
    opts = parse_options(rospy.myargv()[1:], rospy.get_namespace())
    nodes.init_interruptible("spawn_model", anonymous=True)
    spawned = threading.Event()
    if opts.bond:
        rospy.on_shutdown(lambda: _delete(opts, spawned))
    try:
        spawn(opts, spawned)
    except (SpawnError, ModelTextError) as error:
        rospy.logfatal("spawn_model %s: %s", opts.model, error)
        return 1
    except rospy.ROSInterruptException:
        return 0  # as upstream: interrupted while it waited
    if opts.bond:
        rospy.loginfo("Waiting for shutdown to delete model %s", opts.model)
        rospy.spin()
    return 0
