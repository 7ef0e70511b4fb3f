"""Which hardware interfaces the joints of a robot have, as gazebo_ros_control registers them.

What becomes of a robot's transmissions, and what is said of them, is that of
DefaultRobotHWSim::initSim (default_robot_hw_sim.cpp of gazebo_ros_pkgs, noetic).
"""

from __future__ import annotations

from collections.abc import Container, Mapping
from dataclasses import dataclass, field
from typing import Any

from bullet_sim.controllers.limits import CommandLimits, command_limits
from bullet_sim.description.model import Joint, ModelDescription
from bullet_sim.description.transmissions import Transmission, Transmissions

INTERFACES = {
    "velocity": "hardware_interface::VelocityJointInterface",
    "position": "hardware_interface::PositionJointInterface",
    "effort": "hardware_interface::EffortJointInterface",
    "state": "hardware_interface::JointStateInterface",
    "imu": "hardware_interface::ImuSensorInterface",
    "force_torque": "hardware_interface::ForceTorqueSensorInterface",
}
_PREFIX = "hardware_interface/"
_KINDS = {  # as a file writes them
    f"{prefix}{kind.capitalize()}JointInterface": kind
    for prefix in ("", _PREFIX)
    for kind in ("effort", "velocity", "position")
}
_ONE = "Currently the default robot hardware simulation"
GAINS = "gains"  # instead of a level: here it looks for the gains of the joint that is named


@dataclass
class Registered:
    """The interfaces of a robot's joints.

    Attributes:
        interfaces: of each joint: velocity, position, effort; None: every joint has all of them.
        limits: of what is commanded; of other joints those of their description count.
        messages: (level, text) that gazebo_ros_control logs, in order: error, warn or fatal, or
            GAINS and a joint's name.
        refusal: why the robot has no controllers, "" if it may have.
    """

    interfaces: Mapping[str, tuple[str, ...]] | None = field(default_factory=dict)
    limits: dict[str, CommandLimits] = field(default_factory=dict)
    messages: list[tuple[str, str]] = field(default_factory=list)
    refusal: str = ""

    def lacks(self, joint: str, interface: str) -> str:
        """Why a controller cannot command a joint by an interface, "" if it can."""
        if self.interfaces is None or interface in self.interfaces.get(joint, ()):
            return ""
        offered = " and ".join(self.interfaces.get(joint, ()))
        has = f"its <transmission> offers {offered}" if offered else "no <transmission> names it"
        errors = [] if offered else [text for level, text in self.messages if level == "error"]
        reasons = f" ({' '.join(errors[:3])})" if errors else ""
        return f"Could not find resource '{joint}' in '{INTERFACES[interface]}': {has}{reasons}"


def register(
    transmissions: Transmissions,
    description: ModelDescription,
    joints: Mapping[str, Joint],
    parameters: Any = None,
) -> Registered:
    """Register the interfaces of a robot's joints.

    Args:
        description: of the robot.
        joints: of it that move, by name.
        parameters: joint_limits of the robot's namespace: joint -> mapping, see command_limits().
    """
    fixed = (joint.name for joint in description.joints.values() if joint.kind == "fixed")
    still = description.kept if description.is_urdf else set(fixed)
    parameters = parameters if isinstance(parameters, dict) else {}
    made = Registered(messages=[("error", text) for text in transmissions.errors])
    interfaces: dict[str, tuple[str, ...]] = {}
    for transmission in transmissions.taken:
        made.refusal = _register(made, interfaces, transmission, joints, still, parameters)
        if made.refusal:
            # joints that it has come to are held by their motors, which nothing moves any more
            motors = [name for name, kinds in interfaces.items() if "effort" not in kinds]
            interfaces = dict.fromkeys(motors, ("velocity",))
            break
    made.interfaces = interfaces
    return made


def _register(
    made: Registered,
    interfaces: dict[str, tuple[str, ...]],
    transmission: Transmission,
    joints: Mapping[str, Joint],
    still: Container[str],
    parameters: Mapping[str, Any],
) -> str:
    """Register a transmission; returns why that fails, or ""."""
    if len(transmission.joints) > 1:
        made.messages.append((
            "warn",
            f"Transmission {transmission.name} has more than one joint. {_ONE}  interface only "
            "supports one.",
        ))  # fmt: skip
        return ""
    ((name, written),) = transmission.joints
    if len(written) > 1:
        made.messages.append((
            "warn",
            f"Joint {name} of transmission {transmission.name} specifies multiple hardware "
            f"interfaces. {_ONE} interface only supports one. Using the first entry",
        ))  # fmt: skip
    if name in interfaces:
        text = f"Replacing previously registered handle '{name}' in '{INTERFACES['state']}'."
        made.messages.append(("warn", text))
    kind = _KINDS.get(written[0])
    if kind is None:
        text = f"No matching hardware interface found for '{written[0]}' while loading interfaces "
        return _fail(made, "fatal", f"{text}for {name}")
    if not written[0].startswith(_PREFIX):
        made.messages.append((
            "warn",
            f"Deprecated syntax, please prepend '{_PREFIX}' to '{written[0]}' within the "
            f"<hardwareInterface> tag in joint '{name}'.",
        ))  # fmt: skip
    if name not in joints and name not in still:
        text = f'This robot has a joint named "{name}" which is not in the gazebo model.'
        return _fail(made, "error", text)
    if name in joints:
        own = parameters.get(name)
        limits = command_limits(joints[name], own if isinstance(own, dict) else None)
        refusal = limits.refusal(name, kind)
        if refusal:
            return _fail(made, "error", refusal)
        made.limits[name] = limits
        interfaces[name] = tuple(dict.fromkeys((*interfaces.get(name, ()), kind)))
        if kind != "effort":
            made.messages.append((GAINS, name))
    return ""


def _fail(made: Registered, level: str, text: str) -> str:
    """Note what makes gazebo_ros_control give up; returns it."""
    made.messages.append((level, text))
    return text
