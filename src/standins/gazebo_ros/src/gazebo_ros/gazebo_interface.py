"""Functions of upstream's module of this name, for nodes that spawn models themselves."""

from gazebo_msgs.srv import SetModelConfiguration, SpawnModel

from gazebo_ros.spawn_model import Simulator, SpawnError


def spawn_sdf_model_client(
    model_name, model_xml, robot_namespace, initial_pose, reference_frame, gazebo_namespace
):
    """Spawns an SDF model.

    Args:
        model_xml: SDF text.
        robot_namespace: for plugins that name none.
        initial_pose: geometry_msgs/Pose in the reference frame.
        reference_frame: model or link; empty or world: the world.
        gazebo_namespace: of the simulator, e.g. /gazebo.

    Returns:
        Whether it was spawned; the reason is in the log.
    """
    values = model_name, model_xml, robot_namespace, initial_pose, reference_frame
    return _call(gazebo_namespace, "spawn_sdf_model", SpawnModel, "Spawn", *values)


def spawn_urdf_model_client(
    model_name, model_xml, robot_namespace, initial_pose, reference_frame, gazebo_namespace
):
    """Spawns a URDF model; arguments and result as for spawn_sdf_model_client."""
    values = model_name, model_xml, robot_namespace, initial_pose, reference_frame
    return _call(gazebo_namespace, "spawn_urdf_model", SpawnModel, "Spawn", *values)


def set_model_configuration_client(
    model_name, model_param_name, joint_names, joint_positions, gazebo_namespace
):
    """Puts joints of a model at positions [rad, m].

    Returns:
        Whether they were set; the reason is in the log.
    """
    values = model_name, model_param_name, joint_names, joint_positions
    name, label = "set_model_configuration", "Set model configuration"
    return _call(gazebo_namespace, name, SetModelConfiguration, label, *values)


def _call(namespace, service, service_type, label, *values):
    fields = dict(zip(service_type._request_class.__slots__, values))
    try:
        Simulator(namespace.rstrip("/"), None).call(service, service_type, label, **fields)
    except SpawnError:
        return False
    return True
