"""Controllers: the table of their types, their configuration and their implementations."""

from bullet_sim.controllers.base import MAX_COMMAND, check_command
from bullet_sim.controllers.drive import Ackermann, DiffDrive
from bullet_sim.controllers.four_wheel import FourWheel
from bullet_sim.controllers.gripper import GripperControl
from bullet_sim.controllers.joint import Controller, Forward, PidByEffort, PidByVelocity
from bullet_sim.controllers.kinds import KINDS, ControllerSpec, Kind
from bullet_sim.controllers.parse import parse_controller
from bullet_sim.controllers.trajectory import TrajectoryControl

__all__ = [
    "KINDS",
    "MAX_COMMAND",
    "ControllerSpec",
    "Kind",
    "check_command",
    "make_controller",
    "parse_controller",
]

_DRIVES = {"diff": DiffDrive, "ackermann": Ackermann, "four_wheel": FourWheel}
_ACTIONS = {"trajectory": TrajectoryControl, "gripper": GripperControl}


def make_controller(spec, hardware):
    """The Controller of a ControllerSpec."""
    if spec.kind.interface == "state" or spec.kind.reports_sensors:
        return Controller(spec, hardware)
    if spec.kind.drive:
        return _DRIVES[spec.kind.drive](spec, hardware)
    if spec.kind.action:
        return _ACTIONS[spec.kind.action](spec, hardware)
    if not spec.kind.goal:
        return Forward(spec, hardware)
    return (PidByEffort if spec.kind.interface == "effort" else PidByVelocity)(spec, hardware)
