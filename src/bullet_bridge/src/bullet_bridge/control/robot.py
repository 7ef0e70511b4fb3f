"""ros_control's face of one robot: its controllers' life cycles, topics and live tuning."""

import math
import threading

import rospy
from bullet_sim.controllers.pid import parse_pid
from bullet_sim.errors import ControllerError, SimError

from bullet_bridge.control.pid_tuning import PidTuning
from bullet_bridge.control.services import ControllerServices
from bullet_bridge.control.topics import topics_of
from bullet_bridge.loop.arrivals import Arrivals
from bullet_bridge.loop.jobs import Ended
from bullet_bridge.transport.publishing import all_or_none

PID_GAINS = "gazebo_ros_control/pid_gains"


class RobotControl:
    """Controllers of one model.

    Args:
        jobs: JobQueue of the simulation thread.
        world, model: of the core.
        namespace: e.g. '/racecar'.
        arrivals: Arrivals, which count the commands.

    Attributes:
        closed: the model is deleted; nothing is to be loaded any more.
    """

    def __init__(self, jobs, world, model, namespace, arrivals=None):
        self._jobs = jobs
        self.world, self.model, self.manager = world, model, model.manager
        self.namespace = "/" + namespace.strip("/") if namespace.strip("/") else ""
        self.arrivals = arrivals or Arrivals()
        self._mail, self._lock = {}, threading.Lock()
        self._topics, self._tunings, self._said = {}, {}, set()
        self._timed = {}  # of the topics: those of running controllers that publish
        self.closed = False
        try:
            self._set_joint_gains()
            self._services = ControllerServices(
                self.namespace, self.manager, self._answer, self._load, self._unload
            )
        except BaseException:
            self._withdraw()
            raise

    def _set_joint_gains(self):
        """Joints with gains on the parameter server follow their commands by PID."""
        entries = rospy.get_param(f"{self.namespace}/{PID_GAINS}", None) or {}
        if not isinstance(entries, dict):
            rospy.logerr(
                "%s/%s is %r, must be a mapping from joints to gains",
                self.namespace,
                PID_GAINS,
                entries,
            )
            return
        for joint, values in entries.items():
            where, warnings = f"{self.namespace}/{PID_GAINS}/{joint}", []
            try:
                gains = parse_pid(values, where, warnings)
                self.manager.hardware.set_gains(joint, gains)
                self._tune(
                    PID_GAINS,
                    where,
                    gains,
                    lambda gains, j=joint: self.manager.hardware.set_gains(j, gains),
                )
            except (SimError, TimeoutError) as error:
                warnings.append(f"{error}; the gains are not used")
            for text in warnings:
                rospy.logwarn("%s", text)

    def _tune(self, owner, namespace, gains, take):
        """Offer a dynamic_reconfigure server; `take` is run by the simulation."""
        tuning = PidTuning(namespace, gains, lambda new: self._jobs.call(lambda: take(new)))
        with self._lock:
            self._tunings.setdefault(owner, []).append(tuning)

    def pid_namespace(self, spec, number):
        """Where the parameters of a controller's PID are, those of its joint `number`."""
        of_joint = f"/{spec.joints[number]}" if spec.kind.group else ""
        return f"{self.namespace}/{spec.name}{of_joint}/pid"

    # simulation thread ------------------------------------------------------------------------
    def deliver(self):
        """Hand over the latest commands."""
        if not self._mail:
            return
        with self._lock:
            mail, self._mail = self._mail, {}
        for name, values in mail.items():
            try:
                self.manager.command(name, values)
            except SimError as error:
                rospy.logerr_throttle(1.0, f"{self.namespace}: {error}")

    def refresh(self):
        """Look again which controllers run, after anything may have changed."""
        before, self._timed = (
            self._timed,
            {
                name: topics
                for name, topics in self._topics.items()
                if topics.is_timed() and self.manager.is_running(name)
            },
        )
        for name, topics in self._timed.items():
            if name not in before:
                topics.restart(self.world.step_count)

    def next_due(self, look=True):
        """First physics step after which something is to be published, or infinity.

        Args:
            look: look anew who subscribes.
        """
        return min([topics.next_due(look) for topics in self._timed.values()], default=math.inf)

    def publish(self, step, time):
        """Publish what is due."""
        for topics in self._timed.values():
            topics.publish(step, time)

    def restart(self):
        """Start afresh after a reset."""
        with self._lock:
            self._mail = {}
        for topics in self._topics.values():
            topics.restart(self.world.step_count)

    # other threads ----------------------------------------------------------------------------
    def keep_mail(self, name, values):
        """Keep a command for the next step; the latest wins."""
        with self._lock:
            self._mail[name] = values

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
        spec = self._answer(lambda: self._check_rate(self.manager.load(name, config)))
        if spec is None:
            return False
        for note in spec.notes:
            self._say_once(rospy.loginfo, note.partition(": ")[2] or note, note)
        for warning in spec.warnings:
            self._say_once(rospy.logwarn, warning, warning)
        try:
            with all_or_none():
                topics = topics_of(self, spec)
            if not self._answer(lambda: self._keep(name, topics)):
                topics.close()
                self._unload(name)
                return False
            for number, gains in enumerate(spec.gains):
                self._tune(
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
            self._withdraw()
            return False
        return True

    def _keep(self, name, topics):
        """Take the topics of a controller into use (simulation thread)."""
        if self.closed:
            raise ControllerError(f"controller '{name}' is not loaded, its model is deleted")
        self._topics[name] = topics
        return True

    def _set_gains(self, name, number, gains):
        self.manager.get(name).pids[number].gains = gains

    def _check_rate(self, spec):
        """Refuse a rate that the physics cannot give; nothing is left behind then."""
        if (
            spec.kind.interface == "state" or spec.kind.drive
        ) and spec.publish_rate * self.world.time_step > 1.0001:
            self.manager.unload(spec.name)
            raise ControllerError(
                f"controller '{spec.name}' publish_rate is "
                f"{spec.publish_rate}, must be at most "
                f"{1 / self.world.time_step:g} Hz, one per physics step"
            )
        return spec

    def _say_once(self, log, key, text):
        if key not in self._said:
            self._said.add(key)
            log("%s: %s", self.namespace, text)

    def _unload(self, name):
        def work():
            self.manager.unload(name)
            with self._lock:
                self._mail.pop(name, None)
                return self._topics.pop(name, None), self._tunings.pop(name, [])

        done = self._answer(work)
        if done is None:
            return False
        topics, tunings = done
        for wire in [topics] * (topics is not None) + tunings:
            wire.close()
        return True

    def _answer(self, work):
        """Result of a job, or None with the reason in the log."""
        try:
            return self._jobs.call(work)
        except Ended:
            return None  # whoever asks at the end of all is not in need of a reason
        except (SimError, TimeoutError) as error:
            rospy.logerr("%s: %s", self.namespace, error)
            return None

    def close(self):
        """Withdraw services and topics."""
        self.closed = True
        self._services.close()
        self._withdraw()

    def _withdraw(self):
        """Withdraw topics and tunings, each once."""
        with self._lock:
            topics, tunings = self._topics, self._tunings
            self._topics, self._tunings = {}, {}
        for wire in [*topics.values(), *(t for ts in tunings.values() for t in ts)]:
            wire.close()
