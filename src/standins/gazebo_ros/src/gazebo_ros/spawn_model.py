"""The spawn_model node: read a model, wait for the simulator, spawn."""

import sys

import rospy
from gazebo_msgs.srv import DeleteModel, GetWorldProperties, SetModelConfiguration, SpawnModel
from geometry_msgs.msg import Point, Pose, Quaternion
from std_srvs.srv import Empty

from gazebo_ros import model_text, options
from paddock_common import nodes, waiting


class SpawnError(Exception):
    """The model could not be spawned; the text says why."""


def read_model(opts):
    """Returns the model's text from the source in the options.

    Raises:
        SpawnError: the file or parameter cannot be read.
        model_text.ModelTextError: the text is not a model.
    """
    if opts.file:
        try:
            with open(opts.file, "rb") as stream:
                text = stream.read()
        except OSError as error:
            raise SpawnError(f"cannot read file {opts.file}: {error.strerror}") from None
        source = "file " + opts.file
    elif opts.param:
        source = "parameter " + rospy.resolve_name(opts.param)
        try:
            text = str(rospy.get_param(opts.param))
        except KeyError:
            raise SpawnError(f"{source} is not set") from None
    elif opts.database:
        source, text = "model " + opts.database, model_text.from_database(opts.database)
    else:
        source, text = "standard input", sys.stdin.read()
    return model_text.checked(text, source, opts.package_to_model)


class Simulator:
    """The simulator's services, called with a time-out.

    Args:
        namespace: e.g. /gazebo.
        timeout: wall-clock limit for each service to appear [s].
    """

    def __init__(self, namespace, timeout):
        self._namespace = namespace
        self._timeout = timeout

    def call(self, service, kind, **fields):
        """Waits for a service and calls it; a refusal is an error.

        Raises:
            SpawnError: the service did not come, failed or refused.
        """
        name = f"{self._namespace}/{service}"
        try:
            waiting.wait_for_service(name, self._timeout)
            response = rospy.ServiceProxy(name, kind)(**fields)
        except waiting.WaitTimeout as error:
            raise SpawnError(f"{error}. Is the simulator running?") from None
        except rospy.ServiceException as error:
            raise SpawnError(f"{name} failed: {error}") from None
        if not getattr(response, "success", True):
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


def spawn(opts):
    """Spawns the model as the options say.

    Raises:
        SpawnError, model_text.ModelTextError: spawning failed.
    """
    text = read_model(opts)
    simulator = Simulator(opts.gazebo_namespace, opts.timeout)
    if opts.wait:
        rospy.loginfo("Waiting for model %s", opts.wait)
        simulator.wait_for_model(opts.wait)
    pose = Pose(
        Point(opts.x, opts.y, opts.z),
        Quaternion(*model_text.quaternion_from_rpy(opts.R, opts.P, opts.Y)),
    )
    service = "spawn_urdf_model" if opts.urdf else "spawn_sdf_model"
    response = simulator.call(
        service,
        SpawnModel,
        model_name=opts.model,
        model_xml=text,
        robot_namespace=opts.robot_namespace,
        initial_pose=pose,
        reference_frame=opts.reference_frame,
    )
    rospy.loginfo("Spawned %s. %s", opts.model, response.status_message)
    if opts.joints:
        names, positions = zip(*opts.joints)
        simulator.call(
            "set_model_configuration",
            SetModelConfiguration,
            model_name=opts.model,
            urdf_param_name="",
            joint_names=names,
            joint_positions=positions,
        )
    if opts.unpause:
        simulator.call("unpause_physics", Empty)


def _delete(opts):
    try:
        rospy.ServiceProxy(opts.gazebo_namespace + "/delete_model", DeleteModel)(opts.model)
    except rospy.ServiceException as error:
        rospy.logwarn("Could not delete %s: %s", opts.model, error)


def main():
    """Runs the node; returns its exit code: 0 spawned or interrupted, 1 not spawned."""
    opts = options.parse(rospy.myargv()[1:], rospy.get_namespace())
    nodes.init_interruptible("spawn_model", anonymous=True)
    try:
        spawn(opts)
    except (SpawnError, model_text.ModelTextError) as error:
        rospy.logfatal("spawn_model %s: %s", opts.model, error)
        return 1
    except rospy.ROSInterruptException:
        return 0  # as upstream: interrupted while it waited
    if opts.bond:
        rospy.on_shutdown(lambda: _delete(opts))
        rospy.spin()
    return 0
