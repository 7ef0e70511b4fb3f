"""Solids have the volume of their formula; written files can be read again."""

import math

import numpy as np
import pytest
from paddock_common.meshes import Mesh, MeshSet, obj_lines

from paddock_common import meshes

SQUARE = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)]
# An L: not convex. Its corners' mean lies inside, so fans about it are valid.
ANGLE = [(0.0, 0.0), (3.0, 0.0), (3.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)]


@pytest.mark.parametrize(
    "solid, volume",
    [
        (meshes.box((0, 0, 0), (1, 2, 3)), 6.0),
        (meshes.box((1, 2, 3), (0, 0, 0)), 6.0),
        (meshes.prism(SQUARE, 0.0, 3.0), 6.0),
        (meshes.prism(ANGLE, 0.0, 1.0, fans=True), 4.0),
        (meshes.plate([(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0)], 0.1), 0.2),
        # A prism of 24 flats around, with a hole: area n/2 sin(2 pi/n) (R^2 - r^2).
        (
            meshes.lathe([(1.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0)], 24),
            12.0 * math.sin(2.0 * math.pi / 24) * 3.0,
        ),
    ],
)
def test_volumes_and_closure(solid, volume):
    mesh = Mesh(solid)
    assert abs(meshes.volume(solid)) == pytest.approx(volume)
    assert mesh.volume() == pytest.approx(volume)  # reversed to point outwards
    total = sum(meshes.area_vector(face) for face in mesh.faces)
    assert np.abs(total).max() < 1e-12


def test_an_arch_spans_its_ring():
    mesh = Mesh(meshes.arch((1.0, 2.0), 0.3, 0.4, 0.0, math.pi, 0.1, 0.2, 12))
    low, high = mesh.bounds()
    assert (low, high) == (pytest.approx((0.6, 0.1, 2.0)), pytest.approx((1.4, 0.2, 2.4)))
    assert mesh.volume() > 0.0


def test_mirrored_solids_point_outwards_too():
    mesh = Mesh().add_mirrored(meshes.box((0, 1, 0), (1, 2, 1)))
    assert mesh.volume() == pytest.approx(2.0)
    assert mesh.bounds()[0][1] == -2.0


def read(lines):
    """Returns positions (N, 3), normals (M, 3) and faces (F, 3, 2) of an OBJ's lines."""
    rows = [line.split() for line in lines]
    points, normals = (
        np.array([list(map(float, row[1:])) for row in rows if row[0] == tag])
        for tag in ("v", "vn")
    )
    faces = [[list(map(int, c.split("//"))) for c in row[1:]] for row in rows if row[0] == "f"]
    return points, normals, np.array(faces)


def test_an_obj_shares_corners_and_normals():
    points, normals, faces = read(obj_lines(Mesh(meshes.box((0, 0, 0), (1, 2, 3))).faces, 4))
    assert (len(points), len(normals), len(faces)) == (8, 6, 12)
    a, b, c = (points[faces[:, k, 0] - 1] for k in range(3))
    across = np.cross(b - a, c - a)
    expected = normals[faces[:, 0, 1] - 1]
    assert (across / np.linalg.norm(across, axis=1)[:, None]) == pytest.approx(expected)


def test_a_bent_face_has_one_normal_or_folds():
    bent = [np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0.5), (0, 1, 0)], float)]
    maker = Mesh()
    maker.solids.append(bent)
    for folded, count in ((False, 1), (True, 2)):
        mesh_set = MeshSet("p", {"m": lambda: maker}, {"m": (1, 0, 0)}, folded=folded)
        points, normals, faces = read(mesh_set.obj("m").splitlines())
        assert (len(points), len(normals), len(faces)) == (4, count, 2)


def test_files(tmp_path, capsys):
    mesh_set = MeshSet(
        "some_package", {"m": lambda: Mesh(meshes.box((0, 0, 0), (1, 1, 1)))}, {"m": (1, 0.5, 0)}
    )
    assert mesh_set.main("unused", [str(tmp_path / "out")]) == 0
    assert capsys.readouterr().out.split() == [
        str(tmp_path / "out" / name) for name in ("m.obj", "m.mtl")
    ]
    first = (tmp_path / "out" / "m.obj").read_text().splitlines()[:4]
    assert first == ["# made by some_package make_meshes", "mtllib m.mtl", "o m", "usemtl m"]
    assert "Kd 1.00 0.50 0.00" in (tmp_path / "out" / "m.mtl").read_text()
