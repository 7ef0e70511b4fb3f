"""dynamic_reconfigure of gains of PIDs."""

from __future__ import annotations

import functools
import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, cast

import rosgraph
import rospy
from bullet_sim.controllers import steer_bot
from bullet_sim.controllers.interfaces import GAINS, Registered, register
from bullet_sim.controllers.pid import PidGains, parse_pid
from bullet_sim.controllers.settings import as_number
from bullet_sim.description.model import STEER_BOT_SIM_TYPE
from bullet_sim.errors import SimError
from bullet_sim.formats.transmissions import parse_transmissions
from bullet_sim.xml_reader import parse
from control_toolbox.cfg import ParametersConfig

from bullet_bridge.transport.parameters import nearest
from bullet_bridge.transport.pid_gains import on_change, values_of
from bullet_bridge.transport.reconfigure import ValuesServer

if TYPE_CHECKING:
    from bullet_sim.controllers.hardware import Hardware
    from bullet_sim.controllers.manager import Manager
    from bullet_sim.description.model import ModelDescription
    from bullet_sim.description.transmissions import Transmissions
    from bullet_sim.models.model import Model

    from bullet_bridge.loop.jobs import JobQueue


def pid_server(namespace: str, gains: PidGains, apply: Callable[[PidGains], Any]) -> ValuesServer:
    """Start the server of one PID; apply: see on_change."""
    changed = on_change(namespace, gains, apply)
    return ValuesServer(ParametersConfig, values_of(gains), changed, namespace)


PID_GAINS = "gazebo_ros_control/pid_gains"


class PidServers:
    """The dynamic_reconfigure servers of a robot's PIDs, by their owners."""

    def __init__(self, jobs: JobQueue) -> None:
        self._jobs, self._lock = jobs, threading.Lock()
        self._servers: dict[str, list[ValuesServer]] = {}

    def add(
        self, owner: str, namespace: str, gains: PidGains, apply: Callable[[PidGains], Any]
    ) -> None:
        """Start a server.

        Args:
            owner: name of what the PID belongs to.
            namespace: of the parameters.
            apply: function of PidGains, run in the simulation thread.
        """
        server = pid_server(namespace, gains, lambda new: self._jobs.call(lambda: apply(new)))
        with self._lock:
            self._servers.setdefault(owner, []).append(server)

    def take(self, *owners: str) -> list[ValuesServer]:
        """Servers of owners, by default of all, which the caller closes."""
        with self._lock:
            names = owners or tuple(self._servers)
            return [server for name in names for server in self._servers.pop(name, ())]


def set_hardware(model: Model, namespace: str, pid_servers: PidServers) -> Callable[[], None]:
    """Read the parameters of the hardware layer that a model's <robotSimType> names.

    Args:
        namespace: of the model's controllers.

    Returns:
        Function that puts the hardware layer into force, for the simulation thread.
    """
    hardware, description = cast("Manager", model.manager).hardware, model.description
    transmissions = _transmissions(description, namespace)
    limits = rospy.get_param(f"{namespace}/joint_limits", None)
    registered = register(transmissions, description, model.joints.limits, limits)
    hardware.set_registered(registered)
    if description.robot_sim_type != STEER_BOT_SIM_TYPE:
        where = f"{namespace}/{PID_GAINS}"
        entries = rospy.get_param(where, None) or {}
        _log(registered, where, entries)
        if not registered.refusal:
            _set_joint_gains(hardware, where, entries, pid_servers)
        return hardware.restart
    where = f"{namespace}/{steer_bot.NAMESPACE}"
    try:
        config = steer_bot.parse_steer_bot(
            rospy.get_param(where, None), where, model.joints.names, description
        )
    except SimError as error:
        rospy.logerr("%s; the joints are those of the URDF", error)
        return hardware.restart
    joints = steer_bot.SteerBotJoints(model.joints, config)
    return functools.partial(hardware.put_before, joints, Registered(config.interfaces()))


def _transmissions(description: ModelDescription, namespace: str) -> Transmissions:
    """The transmissions of the URDF in the parameter that <robotParam> names.

    As upstream it is looked for from the namespace upwards. Those of the model's own file count
    where there is none, for which upstream waits, and where it has no joint of theirs.
    """
    own = description.transmissions
    if not description.robot_param:
        return own
    try:
        name = description.robot_param
        found = parse_transmissions(parse(nearest(namespace, name), f"parameter {name}"))
    except (OSError, rosgraph.MasterException, TypeError, ValueError):
        return own
    return found if found.joints & own.joints or not own.joints else own


def _log(registered: Registered, where: str, entries: Any) -> None:
    """Say what gazebo_ros_control says of transmissions and joints when it starts.

    That a joint has no gains is a line of an error there, and as usual: its command is followed
    exactly.

    Args:
        where: name of the parameter that the gains are in.
        entries: its value.
    """
    for level, text in registered.messages:
        if level != GAINS:
            log = {"error": rospy.logerr, "warn": rospy.logwarn, "fatal": rospy.logfatal}[level]
            log("%s", text)
        elif not _has_p(entries, text):
            rospy.logerr("No p gain specified for pid.  Namespace: %s/%s", where, text)
    if registered.refusal:
        rospy.logfatal("Could not initialize robot simulation interface")


def _has_p(entries: Any, joint: str) -> bool:
    gains = entries.get(joint) if isinstance(entries, dict) else None
    return isinstance(gains, dict) and as_number(gains.get("p")) is not None


def _set_joint_gains(hardware: Hardware, where: str, entries: Any, pid_servers: PidServers) -> None:
    """Set the gains of joints that follow their commands by a PID."""
    if not isinstance(entries, dict):
        rospy.logerr("%s is %r, must be a mapping from joints to gains", where, entries)
        return
    for joint, values in entries.items():
        warnings: list[str] = []
        try:
            gains = parse_pid(values, f"{where}/{joint}", warnings)
            hardware.set_gains(joint, gains)
            pid_servers.add(
                PID_GAINS,
                f"{where}/{joint}",
                gains,
                functools.partial(hardware.set_gains, joint),
            )
        except (SimError, TimeoutError) as error:
            warnings.append(f"{error}; the gains are not used")
        for text in warnings:
            rospy.logwarn("%s", text)
