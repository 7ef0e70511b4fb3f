"""URDF texts for tests: links with their inertia and shape, joints, robots."""

CONTROL = '<gazebo><plugin name="c" filename="libgazebo_ros_control.so"/></gazebo>'


def inertial(mass=1.0, inertia=0.1, center="0 0 0"):
    """An <inertial>; inertia: one number, or (ixx, iyy, izz)."""
    xx, yy, zz = inertia if isinstance(inertia, tuple) else (inertia,) * 3
    return (
        f'<inertial><origin xyz="{center}"/><mass value="{mass}"/><inertia ixx="{xx}" iyy="{yy}" '
        f'izz="{zz}" ixy="0" ixz="0" iyz="0"/></inertial>'
    )


def link(name, mass=1.0, inertia=0.1, shape="", rpy="0 0 0", center="0 0 0"):
    """A link with the <geometry> of a collision."""
    collision = f'<collision><origin rpy="{rpy}"/><geometry>{shape}</geometry></collision>'
    own = inertial(mass, inertia, center)
    return f'<link name="{name}">{own}{collision if shape else ""}</link>'


def joint(name, kind, parent, child, at="0 0 0", axis="0 1 0", more=""):
    return (
        f'<joint name="{name}" type="{kind}"><origin xyz="{at}"/><parent link="{parent}"/>'
        f'<child link="{child}"/><axis xyz="{axis}"/>{more}</joint>'
    )


def tags(name, **values):
    """A <gazebo> element of a link."""
    inner = "".join(f"<{key}>{value}</{key}>" for key, value in values.items())
    return f'<gazebo reference="{name}">{inner}</gazebo>'


def robot(*parts, name="bot"):
    return f'<robot name="{name}">{"".join(parts)}</robot>'
