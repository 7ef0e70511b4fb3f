"""A robot's controllers and what each of them has in ROS."""

from __future__ import annotations

import functools
import threading
import traceback
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar, cast

import rospy
from bullet_sim.controllers import CONTROLLERS
from bullet_sim.controllers.pid import PidConfig
from bullet_sim.errors import ControllerError, SimError
from std_msgs.msg import Bool

from bullet_bridge.control import actions  # noqa: F401  enters its topics
from bullet_bridge.control.reconfigure import PidServers, set_hardware
from bullet_bridge.control.services import ControllerServices
from bullet_bridge.control.topics import ROS_SIDE, Topics
from bullet_bridge.loop.jobs import JobQueue, QueueClosed
from bullet_bridge.loop.received import ReceivedCounts
from bullet_bridge.transport.publishing import all_or_none
from bullet_bridge.transport.reconfigure import ValuesServer
from bullet_sim import robots as control

if TYPE_CHECKING:
    from bullet_sim.controllers import Controller
    from bullet_sim.models.model import Model
    from bullet_sim.world import World

T = TypeVar("T")


class RobotControl(control.Robot):
    """Controllers of one model.

    Args:
        namespace: e.g. '/racecar'.
        run: function that has the simulation thread run another.

    Attributes:
        closed: the model is deleted; no controller can be loaded.
        refused: name of a controller that could not be loaded -> why.

    Raises:
        ControllerError: gazebo_ros_control cannot be initialized with its transmissions.
    """

    def __init__(
        self,
        jobs: JobQueue,
        world: World,
        model: Model,
        namespace: str,
        received: ReceivedCounts | None = None,
        run: Callable[[Callable[[], None]], None] = lambda work: work(),
    ) -> None:
        self._jobs = jobs
        super().__init__(world, model, namespace)
        self._label = self.namespace or "/"
        self.received = received or ReceivedCounts()
        self._lock = threading.Lock()
        self._emergency: Any = None  # its subscriber
        self._pid_servers = PidServers(jobs)
        self._logged: set[str] = set()
        self.closed = False
        self.refused: dict[str, str] = {}
        self.manager.on_failure = self._failed
        try:
            run(set_hardware(model, self.namespace, self._pid_servers))
            if self.manager.hardware.registered.refusal:
                raise ControllerError(self.manager.hardware.registered.refusal)
            self._subscribe_to_emergency_stop(model.description.emergency_stop)
            self._services = ControllerServices(
                self.namespace, self.manager, self._run_job, self._load, self._unload
            )
        except BaseException:
            self._close_topics()
            raise
        rospy.loginfo("Loaded gazebo_ros_control.")

    # simulation thread ------------------------------------------------------------------------
    def refuse(self, error: SimError) -> None:
        """Log a command that is not valid."""
        rospy.logerr_throttle(1.0, f"{self._label}: {error}")

    def _failed(self, name: str, error: Exception) -> None:
        """A controller has raised an exception and is stopped."""
        rospy.logerr(
            "%s: controller '%s' is stopped, since it has raised an exception:\n%s",
            self._label,
            name,
            "".join(traceback.format_exception(type(error), error, error.__traceback__)).rstrip(),
        )
        self.refresh()

    # other threads ----------------------------------------------------------------------------
    def _subscribe_to_emergency_stop(self, topic: str) -> None:
        """std_msgs/Bool of <eStopTopic>: true stops the joints, false lets them go on."""
        if not topic:
            return

        def store(message: Any) -> None:
            self.emergency_stop = bool(message.data)

        name = topic if topic.startswith("/") else f"{self.namespace}/{topic}"
        self._emergency = self.received.subscribe(name, Bool, store)

    def _load(self, name: str) -> bool:
        config = rospy.get_param(f"{self.namespace}/{name}", None)
        controller = self._run_job(
            lambda: self._load_checked(name, config),
            lambda error: self._log_refused(name, config, error),
        )
        if controller is None:
            return False
        self.refused.pop(name, None)
        for note in controller.config.notes:
            self._log_once(rospy.loginfo, note.partition(": ")[2] or note, note)
        for warning in controller.config.warnings:
            self._log_once(rospy.logwarn, warning, warning)
        try:
            with all_or_none():
                topics = ROS_SIDE.of(controller)(self, controller)
            if not self._run_job(lambda: self._register(name, topics)):
                topics.close()
                self._unload(name)
                return False
            self._tune(controller)
        except (rospy.ROSException, rospy.ServiceException, OSError, ValueError) as error:
            self.refused[name] = f"topics of controller '{name}' cannot be made: {error}"
            rospy.logerr(f"{self._label}: {self.refused[name]}")
            self._unload(name)
            return False
        if self.closed:
            self._close_topics()
            return False
        return True

    def _log_refused(self, name: str, values: Any, error: Exception) -> None:
        """Log, in ros_control's words, that a controller could not be loaded."""
        kind = values.get("type") if isinstance(values, dict) else None
        if name in (controller.config.name for controller in self.manager.controllers()):
            rospy.logerr("%s", error)
        elif not isinstance(kind, str):
            rospy.logerr(
                "Could not load controller '%s' because the type was not specified. Did you load "
                "the controller configuration on the parameter server (namespace: '%s')?",
                name,
                f"{self.namespace}/{name}",
            )
        elif kind not in CONTROLLERS.names():
            rospy.logerr(
                "Could not load controller '%s' because controller type '%s' does not exist.",
                name,
                kind,
            )
            rospy.logerr(
                "Use 'rosservice call controller_manager/list_controller_types' to get the "
                "available types"
            )
        else:
            rospy.logerr("%s: %s", self._label, error)
            rospy.logerr("Initializing controller '%s' failed", name)

    def _register(self, name: str, topics: Topics) -> bool:
        """Add the topics of a loaded controller (simulation thread)."""
        if self.closed:
            raise ControllerError(f"controller '{name}' is not loaded, its model is deleted")
        self._topics[name] = topics
        return True

    def _tune(self, controller: Any) -> None:
        """Make a controller's gains adjustable by dynamic_reconfigure."""
        config = controller.config
        if isinstance(config, PidConfig):
            for pid, gains, path in zip(controller.pids, config.gains, config.gain_names):
                namespace = f"{self.namespace}/{config.name}/{path}"
                self._pid_servers.add(
                    config.name, namespace, gains, functools.partial(setattr, pid, "gains")
                )

    def _load_checked(self, name: str, values: Any) -> Controller:
        """Load a controller, or note why it is refused (simulation thread)."""
        try:
            return self._load_values(name, values)
        except ControllerError as error:
            if name not in (controller.config.name for controller in self.manager.controllers()):
                self.refused[name] = str(error)
            raise

    def _load_values(self, name: str, values: Any) -> Controller:
        """Load a controller."""
        if values is None:
            raise ControllerError(
                f"controller '{name}' has no parameters: {self.namespace}/{name} is not on the "
                "parameter server"
            )
        self.manager.load(name, values)
        return cast("Controller", self.manager.get(name))

    def _log_once(self, log: Callable[..., None], key: str, text: str) -> None:
        if key not in self._logged:
            self._logged.add(key)
            log("%s: %s", self._label, text)

    def _unload(self, name: str) -> bool:
        def work() -> tuple[Topics | None, list[ValuesServer]]:
            self.manager.unload(name)
            self.commands.pop(name, None)
            return self._topics.pop(name, None), self._pid_servers.take(name)

        done = self._run_job(work)
        if done is None:
            return False
        topics, pid_servers = done
        if topics is not None:
            topics.close()
        for server in pid_servers:
            server.close()
        return True

    def call(self, work: Callable[[], T]) -> T:
        """Result of a job of the simulation thread; what it raises is raised here."""
        return self._jobs.call(work)

    def _run_job(
        self,
        work: Callable[[], T],
        on_error: Callable[[Exception], None] = lambda error: rospy.logerr("%s", error),
    ) -> T | None:
        """Result of a job, or None with the reason in the log."""
        try:
            return self._jobs.call(work)
        except QueueClosed:
            return None  # while the simulation shuts down no reason is logged
        except (SimError, TimeoutError) as error:
            on_error(error)
            return None

    def close(self) -> None:
        """Shut down the services and unregister the topics."""
        self.closed = True
        self._services.close()
        self._close_topics()

    def _close_topics(self) -> None:
        """Close topics and PID servers, each once."""
        with self._lock:
            topics, self._topics = self._topics, {}
            emergency, self._emergency = self._emergency, None
        if emergency is not None:
            emergency.unregister()
        for of_controller in topics.values():
            of_controller.close()
        for server in self._pid_servers.take():
            server.close()
