"""A robot's controllers and what each of them has in ROS."""

import math
import threading

import rospy
from bullet_sim.errors import ControllerError, SimError

from bullet_bridge.control.actions import Gripper, Trajectories
from bullet_bridge.control.reconfigure import Tunings, set_hardware
from bullet_bridge.control.services import ControllerServices
from bullet_bridge.control.topics import (
    Commands,
    Drive,
    FourWheelDrive,
    JointStates,
    PidCommands,
    Sensors,
)
from bullet_bridge.loop.jobs import Ended
from bullet_bridge.loop.received import Arrivals
from bullet_bridge.transport.publishing import all_or_none

_BASES = {"diff": Drive, "ackermann": Drive, "four_wheel": FourWheelDrive}
_ACTIONS = {"trajectory": Trajectories, "gripper": Gripper}


def topics_of(robot, spec):
    """The Topics of a ControllerSpec."""
    kind = spec.kind
    if kind.interface == "state":
        return JointStates(robot, spec)
    if kind.reports_sensors:
        return Sensors(robot, spec)
    if kind.drive:
        return _BASES[kind.drive](robot, spec)
    if kind.action:
        return _ACTIONS[kind.action](robot, spec)
    return (PidCommands if kind.goal else Commands)(robot, spec)


class RobotControl:
    """Controllers of one model.

    Args:
        jobs: JobQueue of the simulation thread.
        world, model: of the core.
        namespace: e.g. '/racecar'.
        arrivals: Arrivals, which count the commands.

    Attributes:
        closed: the model is deleted; no controller can be loaded.
    """

    def __init__(self, jobs, world, model, namespace, arrivals=None):
        self._jobs = jobs
        self.world, self.model, self.manager = world, model, model.manager
        self.namespace = "/" + namespace.strip("/") if namespace.strip("/") else ""
        self.arrivals = arrivals or Arrivals()
        self._commands, self._lock = {}, threading.Lock()
        self._topics, self._tunings, self._logged = {}, Tunings(jobs), set()
        self._publishing = {}  # of the topics: those of running controllers that publish ...
        self._schedules = []  # ... and their schedules
        self.closed = False
        try:
            set_hardware(model, self.namespace, self._tunings)
            self._services = ControllerServices(
                self.namespace, self.manager, self._run_job, self._load, self._unload
            )
        except BaseException:
            self._close_topics()
            raise

    def pid_namespace(self, spec, number):
        """Namespace of the parameters of a controller's PID, that of its joint `number`."""
        if spec.kind.action:
            return f"{self.namespace}/{spec.name}/gains/{spec.joints[number]}"
        of_joint = f"/{spec.joints[number]}" if spec.kind.group else ""
        return f"{self.namespace}/{spec.name}{of_joint}/pid"

    # simulation thread ------------------------------------------------------------------------
    def apply_commands(self):
        """Pass the latest commands to the controllers."""
        if not self._commands:
            return
        with self._lock:
            commands, self._commands = self._commands, {}
        for name, values in commands.items():
            try:
                self.manager.command(name, values)
            except SimError as error:
                rospy.logerr_throttle(1.0, f"{self.namespace}: {error}")

    def refresh(self):
        """Update which controllers run and publish, after jobs."""
        before, self._publishing = (
            self._publishing,
            {
                name: topics
                for name, topics in self._topics.items()
                if topics.is_periodic() and self.manager.is_running(name)
            },
        )
        for name, topics in self._publishing.items():
            if name not in before:
                topics.restart(self.world.step_count)
        self._schedules = [s for topics in self._publishing.values() for s in topics.schedules]

    def next_due(self, check=True):
        """First physics step after which a message is due, or infinity.

        Args:
            check: check for subscribers; False: as at the last check.
        """
        step = self.world.step_count
        return min([s.next_due_subscribed(step, check) for s in self._schedules], default=math.inf)

    def publish(self, step, time):
        """Publish what is due."""
        for topics in self._publishing.values():
            topics.publish(step, time)

    def restart(self):
        """Drop commands and restart the schedules after a reset."""
        with self._lock:
            self._commands = {}
        for topics in self._topics.values():
            topics.restart(self.world.step_count)

    # other threads ----------------------------------------------------------------------------
    def buffer_command(self, name, values):
        """Store a command for the next step; the latest replaces earlier ones."""
        with self._lock:
            self._commands[name] = values

    def waiting_commands(self):
        """The commands that wait for the next step, by controller."""
        with self._lock:
            return dict(self._commands)

    def _load(self, name):
        config = rospy.get_param(f"{self.namespace}/{name}", None)
        if config is None:
            rospy.logerr(
                "%s: controller '%s' has no parameters: %s/%s is not on the parameter server",
                self.namespace,
                name,
                self.namespace,
                name,
            )
            return False
        spec = self._run_job(lambda: self._check_rate(self.manager.load(name, config)))
        if spec is None:
            return False
        for note in spec.notes:
            self._log_once(rospy.loginfo, note.partition(": ")[2] or note, note)
        for warning in spec.warnings:
            self._log_once(rospy.logwarn, warning, warning)
        try:
            with all_or_none():
                topics = topics_of(self, spec)
            if not self._run_job(lambda: self._register(name, topics)):
                topics.close()
                self._unload(name)
                return False
            for number, gains in enumerate(spec.gains):
                self._tunings.add(
                    name,
                    self.pid_namespace(spec, number),
                    gains,
                    lambda new, n=number: self._set_gains(name, n, new),
                )
        except (rospy.ROSException, rospy.ServiceException, OSError, ValueError) as error:
            rospy.logerr(
                "%s: topics of controller '%s' cannot be made: %s", self.namespace, name, error
            )
            self._unload(name)
            return False
        if self.closed:
            self._close_topics()
            return False
        return True

    def _register(self, name, topics):
        """Add the topics of a loaded controller (simulation thread)."""
        if self.closed:
            raise ControllerError(f"controller '{name}' is not loaded, its model is deleted")
        self._topics[name] = topics
        return True

    def _set_gains(self, name, number, gains):
        self.manager.get(name).pids[number].gains = gains

    def _check_rate(self, spec):
        """Refuse and unload a controller whose publish_rate is above one per physics step."""
        if (
            spec.kind.interface == "state" or spec.kind.drive or spec.kind.reports_sensors
        ) and spec.publish_rate * self.world.time_step > 1.0001:
            self.manager.unload(spec.name)
            raise ControllerError(
                f"controller '{spec.name}' publish_rate is "
                f"{spec.publish_rate}, must be at most "
                f"{1 / self.world.time_step:g} Hz, one per physics step"
            )
        return spec

    def _log_once(self, log, key, text):
        if key not in self._logged:
            self._logged.add(key)
            log("%s: %s", self.namespace, text)

    def _unload(self, name):
        def work():
            self.manager.unload(name)
            with self._lock:
                self._commands.pop(name, None)
            return self._topics.pop(name, None), self._tunings.take(name)

        done = self._run_job(work)
        if done is None:
            return False
        topics, tunings = done
        for part in [topics] * (topics is not None) + tunings:
            part.close()
        return True

    def call(self, work):
        """Result of a job of the simulation thread; what it raises is raised here."""
        return self._jobs.call(work)

    def _run_job(self, work):
        """Result of a job, or None with the reason in the log."""
        try:
            return self._jobs.call(work)
        except Ended:
            return None  # at the end of the simulation no reason is logged
        except (SimError, TimeoutError) as error:
            rospy.logerr("%s: %s", self.namespace, error)
            return None

    def close(self):
        """Shut down the services and unregister the topics."""
        self.closed = True
        self._services.close()
        self._close_topics()

    def _close_topics(self):
        """Close topics and tunings, each once."""
        with self._lock:
            topics, self._topics = self._topics, {}
        for part in [*topics.values(), *self._tunings.take_all()]:
            part.close()
