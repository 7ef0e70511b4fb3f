"""<transmission> elements of a URDF: the hardware interfaces of each joint."""

INTERFACES = {
    "EffortJointInterface": "effort",
    "VelocityJointInterface": "velocity",
    "PositionJointInterface": "position",
}


def parse_transmissions(robot, joint_names, warn):
    """Read every <transmission> child of <robot>.

    Args:
        robot: root element.
        joint_names: joints that exist.
        warn: called with one sentence per ignored element.

    Returns:
        Dict of joint name -> tuple of 'effort', 'velocity', 'position'.
    """
    offered = {}
    for element in robot.findall("transmission"):
        what = f"transmission '{element.get('name') or element.findtext('type') or ''}'"
        joints = element.findall("joint")
        if not joints:
            warn(f"{what} has no <joint>; it is left out")
        fallback = [i for a in element.findall("actuator") for i in _interfaces(a)]
        for joint in joints:
            name = joint.get("name")
            if name not in joint_names:
                warn(f"{what} names joint '{name}', which does not exist; it is left out")
                continue
            found = _interfaces(joint) or fallback
            if not found:
                warn(f"{what} gives joint '{name}' no <hardwareInterface>; it is left out")
            for interface in found:
                kind = INTERFACES.get(interface.replace("::", "/").rsplit("/", 1)[-1])
                if kind is None:
                    warn(
                        f"{what} gives joint '{name}' the hardware interface '{interface}', "
                        f"known are {', '.join(INTERFACES)}; it is left out"
                    )
                elif kind not in offered.get(name, ()):
                    offered[name] = offered.get(name, ()) + (kind,)
    return offered


def _interfaces(element):
    texts = [e.text.strip() for e in element.findall("hardwareInterface") if e.text]
    return [text for text in texts if text]
