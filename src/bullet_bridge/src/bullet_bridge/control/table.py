"""Which topics a controller has."""

from bullet_bridge.control import topics
from bullet_bridge.control.bases import Drive, FourWheelDrive
from bullet_bridge.control.gripper import Gripper
from bullet_bridge.control.sensors import Sensors
from bullet_bridge.control.trajectory import Trajectories

_BASES = {"diff": Drive, "ackermann": Drive, "four_wheel": FourWheelDrive}
_ACTIONS = {"trajectory": Trajectories, "gripper": Gripper}


def topics_of(robot, spec):
    """The Topics of a ControllerSpec."""
    kind = spec.kind
    if kind.interface == "state":
        return topics.JointStates(robot, spec)
    if kind.reports_sensors:
        return Sensors(robot, spec)
    if kind.drive:
        return _BASES[kind.drive](robot, spec)
    if kind.action:
        return _ACTIONS[kind.action](robot, spec)
    return (topics.PidCommands if kind.goal else topics.Commands)(robot, spec)
