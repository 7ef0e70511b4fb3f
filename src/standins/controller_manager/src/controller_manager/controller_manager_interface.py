"""Functions that call the controller manager of the node's namespace, and print what came of it.

They wait until the service is available, and return whether the call succeeded.
"""

import rospy

from controller_manager.client import ManagerClient


def _manager(service):
    """A ManagerClient whose service of that name is available."""
    rospy.wait_for_service(f"controller_manager/{service}")
    return ManagerClient()


def _report(success, done, failed):
    print(done if success else failed)
    return success


def list_controller_types():
    """Prints the types of controllers."""
    for name in _manager("list_controller_types").call("list_controller_types").types:
        print(name)


def list_controllers():
    """Prints a line about each loaded controller."""
    controllers = _manager("list_controllers").list()
    for controller in controllers:
        print(format_controller(controller))
    if not controllers:
        print("No controllers are loaded in mechanism control")


def format_controller(controller):
    """Returns one line about a ControllerState."""
    interfaces = dict.fromkeys(c.hardware_interface for c in controller.claimed_resources)
    return f"'{controller.name}' - '{'+'.join(interfaces)}' ( {controller.state} )"


def reload_libraries(force_kill, restore=False):
    """Loads the types of controllers again.

    Args:
        force_kill: also if controllers are loaded, which are stopped and unloaded.
        restore: load those and start those that ran afterwards.
    """
    manager = _manager("reload_controller_libraries")
    print(f"Restore: {restore}")
    before = manager.list() if restore else []
    success = _report(
        manager.call("reload_controller_libraries", force_kill).ok,
        "Successfully reloaded libraries",
        "Failed to reload libraries. Do you still have controllers loaded?",
    )
    if restore:
        for controller in before:
            manager.load(controller.name)
        running = [controller.name for controller in before if controller.state == "running"]
        manager.switch(start=running, strict=False)
        print("Controllers restored to original state")
    return success


def load_controller(name):
    """Loads a controller."""
    success = _manager("load_controller").load(name)
    return _report(success, f"Loaded '{name}'", f"Error when loading '{name}'")


def unload_controller(name):
    """Unloads a stopped controller."""
    success = _manager("unload_controller").unload(name)
    return _report(success, f"Unloaded '{name}' successfully", f"Error when unloading '{name}'")


def start_controller(name):
    """Starts a loaded controller."""
    return start_stop_controllers(start_controllers=[name])


def start_controllers(names):
    """Starts loaded controllers, all or none."""
    return start_stop_controllers(start_controllers=names)


def stop_controller(name):
    """Stops a running controller."""
    return start_stop_controllers(stop_controllers=[name])


def stop_controllers(names):
    """Stops running controllers, all or none."""
    return start_stop_controllers(stop_controllers=names)


def start_stop_controllers(start_controllers=None, stop_controllers=None):
    """Starts and stops controllers in one step, all or none."""
    start_controllers, stop_controllers = start_controllers or [], stop_controllers or []
    if not _manager("switch_controller").switch(start_controllers, stop_controllers):
        print(f"Error when starting {start_controllers} and stopping {stop_controllers}")
        return False
    if start_controllers:
        print(f"Started {start_controllers} successfully")
    if stop_controllers:
        print(f"Stopped {stop_controllers} successfully")
    return True
