"""Parts of worlds of the core, without ROS: a plain ground, a car, hills of triangles."""

import numpy as np

GROUND = (
    "<sdf version='1.6'><model name='ground'><static>true</static><link name='link'>"
    "<collision name='plane'><geometry><plane><normal>0 0 1</normal></plane></geometry>"
    "</collision></link></model></sdf>"
)
LINK = (
    '<link name="{name}"><inertial><mass value="{mass}"/><inertia ixx="{i}" iyy="{i}" '
    'izz="{i}" ixy="0" ixz="0" iyz="0"/></inertial><collision>{origin}<geometry>{shape}'
    "</geometry></collision></link>"
)
INERTIAL = (  # SDF of a mass [kg] and a moment of inertia about all axes [kg m^2]
    "<inertial><mass>{0}</mass><inertia><ixx>{1}</ixx><iyy>{1}</iyy><izz>{1}</izz><ixy>0</ixy>"
    "<ixz>0</ixz><iyz>0</iyz></inertia></inertial>"
)
WHEEL = (
    '<joint name="{name}_joint" type="continuous"><parent link="body"/><child link="{name}"/>'
    '<origin xyz="{x} {y} 0"/><axis xyz="0 1 0"/></joint>'
)


def car():
    """URDF of a small car."""
    parts = [
        LINK.format(name="body", mass=2.0, i=0.01, origin="", shape='<box size="0.3 0.14 0.03"/>')
    ]
    for k, (x, y) in enumerate(((0.1, 0.09), (0.1, -0.09), (-0.1, 0.09), (-0.1, -0.09))):
        parts.append(
            LINK.format(
                name=f"wheel{k}",
                mass=0.05,
                i=1e-4,
                origin='<origin rpy="1.5708 0 0"/>',
                shape='<cylinder radius="0.03" length="0.025"/>',
            )
        )
        parts.append(WHEEL.format(name=f"wheel{k}", x=x, y=y))
    return f'<robot name="car">{"".join(parts)}</robot>'


def hills(path, cells, height=1.0):
    """Write an OBJ of 2 cells^2 triangles, 40 m square, and return its path.

    Args:
        height: of the hills above and below 1 m [m].
    """
    at = np.linspace(-20.0, 20.0, cells + 1)
    x, y = np.meshgrid(at, at)
    z = 1.0 + height * np.sin(x) * np.cos(1.3 * y)
    lines = [f"v {a:.4f} {b:.4f} {c:.4f}" for a, b, c in np.dstack((x, y, z)).reshape(-1, 3)]
    row = cells + 1
    for i in range(cells):
        for j in range(cells):
            first = i * row + j + 1
            lines += [
                f"f {first} {first + 1} {first + row + 1}",
                f"f {first} {first + row + 1} {first + row}",
            ]
    path.write_text("\n".join(lines) + "\n")
    return path
