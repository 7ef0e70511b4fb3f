"""The URDF that PyBullet gets."""

import xml.etree.ElementTree as ET

import numpy as np
import pytest
from bullet_sim.description.lump import lump
from bullet_sim.engine.bullet.urdf import lumped_urdf, quaternion_from_matrix
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.pose import Pose, matrix_from_quaternion

LONGEST_LINE = 1000  # PyBullet's reader damages longer ones


def prepared(content, static=False):
    """Root element and text of a prepared URDF."""
    text = lumped_urdf(lump(parse_urdf(f'<robot name="r">{content}</robot>', str)), static)
    return ET.fromstring(text), text


INERTIA = 'ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"'


def link(mass=2.0, inertia=INERTIA, extra="", name="a"):
    """A link."""
    return (
        f'<link name="{name}"><inertial><mass value="{mass}"/><inertia {inertia}/></inertial>'
        f"{extra}</link>"
    )


def test_no_line_is_longer_than_pybullets_reader_takes():
    shape = (
        '<visual><origin xyz="0.123456789 1 2" rpy="1 2 3"/><geometry><box size="1 2 3"/>'
        "</geometry></visual>"
    )
    _, text = prepared(link(extra=shape * 200))
    assert len(text) > 20 * LONGEST_LINE
    assert max(map(len, text.splitlines())) < LONGEST_LINE


@pytest.mark.parametrize(
    "tensor",
    [
        [[2.0, 0.3, -0.2], [0.3, 3.0, 0.5], [-0.2, 0.5, 4.0]],
        [[1.0, 0.0, 0.4], [0.0, 1.0, 0.0], [0.4, 0.0, 1.0]],
        [[2.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 4.0]],
    ],
)
def test_principal_axes_reproduce_the_tensor(tensor):
    keys = {
        "ixx": (0, 0),
        "ixy": (0, 1),
        "ixz": (0, 2),
        "iyy": (1, 1),
        "iyz": (1, 2),
        "izz": (2, 2),
    }
    text = " ".join(f'{key}="{tensor[i][j]}"' for key, (i, j) in keys.items())
    inertial = prepared(link(inertia=text))[0].find("link/inertial")
    values = inertial.find("inertia")
    assert all(float(values.get(key)) == 0 for key in ("ixy", "ixz", "iyz"))
    turn = Pose.from_xyz_rpy(rpy=map(float, inertial.find("origin").get("rpy").split())).matrix
    moments = np.diag([float(values.get(key)) for key in ("ixx", "iyy", "izz")])
    np.testing.assert_allclose(turn @ moments @ turn.T, tensor, atol=1e-9)


def test_quaternion_from_matrix_goes_round():
    random = np.random.default_rng(0)
    for quaternion in [*np.eye(4), *random.normal(size=(50, 4))]:
        matrix = matrix_from_quaternion(quaternion / np.linalg.norm(quaternion))
        back = matrix_from_quaternion(quaternion_from_matrix(matrix))
        np.testing.assert_allclose(back, matrix, atol=1e-12)


def test_static_model_has_no_mass():
    assert float(prepared(link(), True)[0].find("link/inertial/mass").get("value")) == 0


def test_mesh_collides_as_soup_when_static_and_as_hull_when_not(tmp_path):
    path = tmp_path / "m.obj"
    path.write_text("v 0 0 0\n")
    shape = f'<collision><geometry><mesh filename="{path}"/></geometry></collision>'
    for static in (True, False):
        collision = prepared(link(extra=shape), static)[0].find("link/collision")
        assert (collision.get("concave") == "yes") is static
        assert collision.find("geometry/mesh").get("filename") == str(path)


def wheel_on(axis):
    """A body with a cylinder (radius 0.5, length 0.2) on a continuous joint."""
    shape = '<collision><geometry><cylinder radius="0.5" length="0.2"/></geometry></collision>'
    return prepared(
        link()
        + link(name="b", extra=shape)
        + (
            '<joint name="j" type="continuous"><parent link="a"/><child link="b"/>'
            f'<axis xyz="{axis}"/></joint>'
        )
    )[0]


def test_wheels_collide_as_they_are_described_and_turn_without_friction():
    root = wheel_on("0 0 1")
    (shape,) = root.findall("link/collision/geometry/cylinder")
    assert (float(shape.get("radius")), float(shape.get("length"))) == (0.5, 0.2)
    assert float(root.find("joint/dynamics").get("friction")) == 0
