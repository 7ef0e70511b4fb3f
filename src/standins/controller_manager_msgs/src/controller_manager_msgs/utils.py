"""Finding controller managers, and filtering lists of their controllers."""

import rospy
import rosservice

from controller_manager_msgs.srv import ListControllers

# Services of a controller manager and their types.
cm_services = {
    name: "controller_manager_msgs/" + "".join(word.capitalize() for word in name.split("_"))
    for name in (
        "list_controllers",
        "list_controller_types",
        "load_controller",
        "unload_controller",
        "switch_controller",
        "reload_controller_libraries",
    )
}


def get_controller_managers(namespace="/", initial_guess=None):
    """Returns the namespaces of the running controller managers, sorted.

    Args:
        namespace: where to look for them.
        initial_guess: result of an earlier call; of what is in it only one service is looked for.
    """
    known = initial_guess or []
    return sorted(
        candidate
        for candidate in _with_list_service(namespace)
        if candidate in known or is_controller_manager(candidate)
    )


def is_controller_manager(namespace):
    """Whether a namespace has all services of a controller manager, of the right types."""
    prefix = namespace.rstrip("/") + "/"
    return all(
        rosservice.get_service_type(prefix + name) == kind for name, kind in cm_services.items()
    )


def _with_list_service(namespace):
    """Namespaces that have a service list_controllers."""
    ending = "/list_controllers"
    try:
        names = rosservice.get_service_list(namespace=namespace)
    except rosservice.ROSServiceIOException:
        return []
    return [name[: -len(ending)] or "/" for name in names if name.endswith(ending)]


class ControllerManagerLister:
    """Called without arguments it returns get_controller_managers() of a namespace.

    Later calls are faster than the first.
    """

    def __init__(self, namespace="/"):
        self._namespace, self._known = namespace, []

    def __call__(self):
        self._known = get_controller_managers(self._namespace, self._known)
        return self._known


class ControllerLister:
    """Called without arguments it returns the controllers that a manager has loaded.

    They are a list of controller_manager_msgs/ControllerState, empty if the manager does not
    respond.

    Args:
        namespace: of the manager's services.
    """

    def __init__(self, namespace="/controller_manager"):
        self._name = namespace + "/list_controllers"
        self._connect()

    def _connect(self):
        self._service = rospy.ServiceProxy(self._name, ListControllers, persistent=True)

    def __call__(self):
        for _ in range(2):
            try:
                return self._service().controller
            except (rospy.ServiceException, rospy.ROSException, OSError):
                self._connect()  # the manager may have started again
        return []


def filter_by_name(ctrl_list, ctrl_name, match_substring=False):
    """Controllers of a name, or with a part of it."""
    return _by_attribute(ctrl_list, "name", ctrl_name, match_substring)


def filter_by_type(ctrl_list, ctrl_type, match_substring=False):
    """Controllers of a type, or with a part of it."""
    return _by_attribute(ctrl_list, "type", ctrl_type, match_substring)


def filter_by_state(ctrl_list, ctrl_state, match_substring=False):
    """Controllers in a state, or with a part of it."""
    return _by_attribute(ctrl_list, "state", ctrl_state, match_substring)


def filter_by_hardware_interface(ctrl_list, hardware_interface, match_substring=False):
    """Controllers that claim resources of an interface, or of one with that part in its name."""
    return [
        controller
        for controller in ctrl_list
        if any(
            _matches(hardware_interface, claimed.hardware_interface, match_substring)
            for claimed in controller.claimed_resources
        )
    ]


def filter_by_resources(ctrl_list, resources, hardware_interface=None, match_any=False):
    """Controllers that claim resources, such as joints, of one interface.

    Args:
        hardware_interface: the interface; None: any.
        match_any: one of the resources is enough.
    """
    enough = any if match_any else all
    return [
        controller
        for controller in ctrl_list
        if any(
            enough(resource in claimed.resources for resource in resources)
            for claimed in controller.claimed_resources
            if hardware_interface in (None, claimed.hardware_interface)
        )
    ]


def _by_attribute(controllers, name, value, match_substring):
    return [
        controller
        for controller in controllers
        if _matches(value, getattr(controller, name), match_substring)
    ]


def _matches(requested, value, match_substring):
    return requested in value if match_substring else requested == value


def get_rosparam_controller_names(namespace="/"):
    """Sorted names in a namespace of the parameter server that have a `type`, as controllers do."""
    prefix = namespace.rstrip("/") + "/"
    names = []
    for parameter in rospy.get_param_names():
        if parameter.startswith(prefix):
            parts = parameter[len(prefix) :].split("/")
            if len(parts) == 2 and parts[1] == "type":
                names.append(parts[0])
    return sorted(names)
