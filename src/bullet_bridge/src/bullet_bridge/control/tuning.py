"""Gains and hardware of a robot from the parameter server, and servers that tune PIDs."""

import threading

import rospy
from bullet_sim.controllers import steer_bot
from bullet_sim.controllers.pid import parse_pid
from bullet_sim.description.model import STEER_BOT_SIM_TYPE
from bullet_sim.errors import SimError

from bullet_bridge.control.pid_tuning import PidTuning

PID_GAINS = "gazebo_ros_control/pid_gains"


class Tunings:
    """The dynamic_reconfigure servers of a robot's PIDs, by their owners.

    Args:
        jobs: JobQueue of the simulation thread.
    """

    def __init__(self, jobs):
        self._jobs, self._lock, self._servers = jobs, threading.Lock(), {}

    def add(self, owner, namespace, gains, apply):
        """Start a server.

        Args:
            owner: name of what the PID belongs to.
            namespace: of the parameters.
            gains: PidGains.
            apply: function of PidGains, run in the simulation thread.
        """
        server = PidTuning(namespace, gains, lambda new: self._jobs.call(lambda: apply(new)))
        with self._lock:
            self._servers.setdefault(owner, []).append(server)

    def take(self, owner):
        """Servers of an owner, which the caller closes."""
        with self._lock:
            return self._servers.pop(owner, [])

    def take_all(self):
        """All servers, which the caller closes."""
        with self._lock:
            servers, self._servers = self._servers, {}
        return [server for of_owner in servers.values() for server in of_owner]


def set_hardware(model, namespace, tunings):
    """Set up the hardware layer that a model's <robotSimType> names.

    Args:
        model: of the core, with a manager.
        namespace: of its controllers.
        tunings: Tunings.
    """
    if model.description.robot_sim_type != STEER_BOT_SIM_TYPE:
        _set_joint_gains(model.manager.hardware, f"{namespace}/{PID_GAINS}", tunings)
        return
    where = f"{namespace}/{steer_bot.NAMESPACE}"
    try:
        config = steer_bot.parse_steer_bot(
            rospy.get_param(where, None), where, model.joints.names, model.description
        )
    except SimError as error:
        rospy.logerr("%s; the joints are those of the URDF", error)
        return
    model.manager.hardware.put_before(
        steer_bot.SteerBotJoints(model.joints, config), config.interfaces()
    )


def _set_joint_gains(hardware, where, tunings):
    """Read the gains of joints that follow their commands by a PID."""
    entries = rospy.get_param(where, None) or {}
    if not isinstance(entries, dict):
        rospy.logerr("%s is %r, must be a mapping from joints to gains", where, entries)
        return
    for joint, values in entries.items():
        warnings = []
        try:
            gains = parse_pid(values, f"{where}/{joint}", warnings)
            hardware.set_gains(joint, gains)
            tunings.add(
                PID_GAINS,
                f"{where}/{joint}",
                gains,
                lambda new, j=joint: hardware.set_gains(j, new),
            )
        except (SimError, TimeoutError) as error:
            warnings.append(f"{error}; the gains are not used")
        for text in warnings:
            rospy.logwarn("%s", text)
