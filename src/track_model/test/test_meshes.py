"""The generator makes the committed meshes; their sizes are the car's."""

import re

import numpy as np
import pytest

from track_model.meshes import MESHES


def test_committed_meshes_are_reproduced(package, tmp_path):
    MESHES.write(str(tmp_path))
    committed = package / "meshes"
    assert sorted(path.name for path in committed.iterdir()) == sorted(
        path.name for path in tmp_path.iterdir()
    )
    for path in tmp_path.iterdir():
        assert path.read_bytes() == (committed / path.name).read_bytes(), path.name
        assert path.stat().st_size < 200_000


@pytest.mark.parametrize("name", sorted(MESHES.makers))
def test_faces_point_outwards_and_indices_exist(name):
    lines = [line.split() for line in MESHES.obj(name).splitlines()]
    vertices = np.array([list(map(float, line[1:])) for line in lines if line[0] == "v"])
    normals = np.array([list(map(float, line[1:])) for line in lines if line[0] == "vn"])
    faces = np.array(
        [
            [list(map(int, corner.split("//"))) for corner in line[1:]]
            for line in lines
            if line[0] == "f"
        ]
    )
    assert faces.shape[1:] == (3, 2) and faces.min() == 1
    assert faces[:, :, 0].max() == len(vertices) and faces[:, :, 1].max() <= len(normals)
    assert np.linalg.norm(normals, axis=1) == pytest.approx(1.0, abs=2e-3)
    a, b, c = (vertices[faces[:, k, 0] - 1] for k in range(3))
    assert np.einsum("ij,ij->", a, np.cross(b, c)) > 0.0  # six times the volume


def test_sizes():
    low, high = MESHES.makers["tyre"]().bounds()
    assert (low, high) == (
        pytest.approx((-0.03, -0.0125, -0.03), abs=3e-4),
        pytest.approx((0.03, 0.0125, 0.03), abs=3e-4),
    )
    # In the chassis frame the ground is at -0.016 or lower.
    for name in ("body", "trim", "stripe", "glass", "headlights", "taillights"):
        low, high = MESHES.makers[name]().bounds()
        assert low[2] > -0.005 and high[2] < 0.13, name
        assert low[0] > -0.16 and high[0] < 0.18 and max(-low[1], high[1]) < 0.1, name


def test_colors_are_those_of_the_description(package):
    text = (package / "urdf" / "materials.xacro").read_text()
    names = {"body": "paint", "headlights": "headlight", "taillights": "taillight"}
    for name, color in MESHES.colors.items():
        match = re.search(f'name="{names.get(name, name)}"><color rgba="([^"]*)"', text)
        assert tuple(map(float, match.group(1).split()))[:3] == color, name
