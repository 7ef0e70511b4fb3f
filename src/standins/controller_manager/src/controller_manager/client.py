"""Calls of the controller manager's services, and starting and stopping controllers."""

import socket
import threading
import time

import rosgraph
import rospy
from controller_manager_msgs import srv
from paddock_common.master import find_service

from paddock_common import waiting


class Spawner:
    """Loads and starts, stops and unloads controllers.

    Threads may use it: taking down waits until bringing up, or another take_down, has finished.

    Args:
        manager: ManagerClient, or anything with its load, unload, switch and running.
        log: called with a text for each step.
        warn: called with a text for each failure.
    """

    def __init__(self, manager, log, warn):
        self._manager = manager
        self._log = log
        self.warn = warn
        self.loaded = []
        self._lock = threading.Lock()

    def bring_up(self, controllers, start):
        """Loads controllers and starts those that loaded, in one step.

        If one of them cannot start (for example its joint is claimed), none does, as upstream.

        Args:
            start: False leaves them stopped.

        Returns:
            The names of those that loaded.
        """
        with self._lock:
            for name in controllers:
                self._log(f"Loading controller: {name}")
                if self._manager.load(name):
                    self.loaded.append(name)
                else:
                    self.warn(f"Failed to load {name}")
            names = ", ".join(self.loaded)
            self._log(f"Controller Spawner: Loaded controllers: {names}")
            if start and self._manager.switch(start=self.loaded):
                self._log(f"Started controllers: {names}")
            elif start:
                self.warn(f"Failed to start controllers: {names}")
            return list(self.loaded)

    def take_down(self):
        """Stops and unloads the controllers that this spawner loaded, in reverse order.

        As upstream, where one does not run any more none is stopped, and those that run stay.
        """
        with self._lock:
            names, self.loaded = self.loaded, []
            if not names:
                return
            self._log("Shutting down spawner. Stopping and unloading controllers...")
            self._log("Stopping all controllers...")
            self._manager.switch(stop=names)
            self._log("Unloading all loaded controllers...")
            for name in reversed(names):
                self._log(f"Trying to unload {name}")
                if self._manager.unload(name):
                    self._log(f"Succeeded in unloading {name}")
                else:
                    self.warn(f"Controller '{name}' did not unload")


SERVICES = {
    "list_controllers": srv.ListControllers,
    "list_controller_types": srv.ListControllerTypes,
    "load_controller": srv.LoadController,
    "unload_controller": srv.UnloadController,
    "switch_controller": srv.SwitchController,
    "reload_controller_libraries": srv.ReloadControllerLibraries,
}


MASTER_TIMEOUT = 2.0  # [s] for a response of the master


class ManagerError(Exception):
    """The controller manager is missing or a request failed; the text is the reason."""


class ManagerClient:
    """Calls a controller manager's services.

    Args:
        namespace: namespace of the manager; relative to the node's; '': the node's.
        stop_requested: callable; whether a shutdown was requested; None: rospy.is_shutdown.
    """

    def __init__(self, namespace="", stop_requested=None):
        self._stop_requested = stop_requested
        self.prefix = prefix = namespace.rstrip("/") + "/" if namespace else ""
        self._names = {
            name: rospy.resolve_name(f"{prefix}controller_manager/{name}") for name in SERVICES
        }

    def wait(self, timeout, services=("load_controller", "switch_controller", "unload_controller")):
        """Waits until services are available.

        Args:
            timeout: wall-clock limit for all of them together [s]; None: there is none.
            services: keys of SERVICES.

        Raises:
            ManagerError: the limit passed.
        """
        deadline = None if timeout is None else time.monotonic() + timeout
        for name in services:
            try:
                left = None if deadline is None else max(0.0, deadline - time.monotonic())
                waiting.wait_for_service(self._names[name], left, self._stop_requested)
            except waiting.WaitTimeout:
                raise ManagerError(
                    f"service {self._names[name]} was not available within {timeout:g} s. Is the "
                    "simulator running, and does its robot have a controller manager "
                    "(libgazebo_ros_control.so) in this namespace?"
                ) from None

    def call(self, name, *args, **fields):
        """Calls a service of SERVICES and returns its response.

        Raises:
            ManagerError: the call failed.
        """
        try:
            return rospy.ServiceProxy(self._names[name], SERVICES[name])(*args, **fields)
        except rospy.ServiceException as error:
            raise ManagerError(f"{self._names[name]} failed: {error}") from None

    def is_there(self):
        """Whether the manager's services still respond; also usable during the node's shutdown."""
        name = self._names["switch_controller"]
        uri = find_service(rosgraph.get_master_uri(), rospy.get_name(), name, MASTER_TIMEOUT)
        try:
            if uri is not None:
                host, port = rospy.core.parse_rosrpc_uri(uri)
                socket.create_connection((host, port), 0.5).close()
        except (OSError, rospy.exceptions.ROSException):
            return False
        return uri is not None

    def load(self, controller):
        """Loads a controller; returns whether that worked."""
        return bool(self.call("load_controller", controller).ok)

    def unload(self, controller):
        """Unloads a stopped controller; returns whether that worked."""
        return bool(self.call("unload_controller", controller).ok)

    def switch(self, start=(), stop=(), strict=True):
        """Stops and starts controllers in one control step; returns whether that worked.

        Args:
            strict: one that cannot be switched refuses all; False switches the others.
        """
        request = srv.SwitchControllerRequest
        return bool(
            self.call(
                "switch_controller",
                start_controllers=list(start),
                stop_controllers=list(stop),
                strictness=request.STRICT if strict else request.BEST_EFFORT,
                start_asap=False,
                timeout=0.0,
            ).ok
        )

    def list(self):
        """Returns the loaded controllers, a list of ControllerState."""
        return self.call("list_controllers").controller

    def running(self):
        """Returns the names of the running controllers."""
        return [state.name for state in self.list() if state.state == "running"]


def run_bounded(work, timeout):
    """Runs a callable in a thread, which is abandoned after a time-out.

    A rospy service call has no time-out, and a simulator that shuts down may accept a call and
    never respond.

    Args:
        work: callable; the text of an exception is returned.
        timeout: wall-clock limit [s].

    Returns:
        None when it succeeded, else the reason as a str.
    """
    reason = [f"no response within {timeout:g} s"]

    def _run():
        try:
            work()
            reason[0] = None
        except Exception as error:  # pylint: disable=broad-except
            reason[0] = str(error)

    thread = threading.Thread(target=_run, daemon=True)
    thread.start()
    thread.join(timeout)
    return reason[0]
