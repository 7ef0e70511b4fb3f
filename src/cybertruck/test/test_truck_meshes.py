"""The generator makes the committed meshes; their faces are closed and point outwards."""

import pathlib
import re

import numpy as np
import pytest

from cybertruck.meshes import MESHES
from paddock_common import meshes

PACKAGE = pathlib.Path(__file__).resolve().parents[1]


def test_committed_meshes_are_reproduced(tmp_path):
    MESHES.write(str(tmp_path))
    committed = PACKAGE / "meshes"
    assert sorted(path.name for path in committed.iterdir()) == sorted(
        path.name for path in tmp_path.iterdir()
    )
    for path in tmp_path.iterdir():
        assert path.read_bytes() == (committed / path.name).read_bytes(), path.name
        assert path.stat().st_size < 100_000


@pytest.mark.parametrize("name", sorted(MESHES.makers))
def test_solids_are_closed(name):
    """The area vectors of a closed surface add up to nothing; its volume is positive."""
    for solid in MESHES.makers[name]().solids:
        triangles = [t for face in solid for t in meshes.fan(face)]
        vectors = np.array([meshes.area_vector(t) for t in triangles])
        assert np.abs(vectors.sum(axis=0)).max() < 1e-9 * len(triangles)
        assert meshes.volume(solid) > 0.0


@pytest.mark.parametrize("name", sorted(MESHES.makers))
def test_obj_has_real_normals(name):
    lines = [line.split() for line in MESHES.obj(name).splitlines()]
    points = np.array([list(map(float, line[1:])) for line in lines if line[0] == "v"])
    normals = np.array([list(map(float, line[1:])) for line in lines if line[0] == "vn"])
    faces = np.array(
        [
            [list(map(int, corner.split("//"))) for corner in line[1:]]
            for line in lines
            if line[0] == "f"
        ]
    )
    a, b, c = (points[faces[:, k, 0] - 1] for k in range(3))
    across = np.cross(b - a, c - a)
    area = np.linalg.norm(across, axis=1)
    stated = normals[faces[:, 0, 1] - 1]
    assert np.linalg.norm(stated, axis=1) == pytest.approx(1.0, abs=2e-4)
    # Corners are rounded to 0.01 mm: no more than a fifth of a thin strip's height.
    assert np.einsum("ij,ij->i", across / area[:, None], stated).min() > 0.9
    assert np.median(np.einsum("ij,ij->i", across / area[:, None], stated)) > 0.9999


def test_sizes():
    truck = [MESHES.makers[name]().bounds() for name in ("shell", "sides", "light_bar", "tail_bar")]
    low = np.min([bounds[0] for bounds in truck], axis=0)
    high = np.max([bounds[1] for bounds in truck], axis=0)
    assert high[0] - low[0] == pytest.approx(0.9652, abs=0.01)  # 38 in
    assert high[1] - low[1] == pytest.approx(0.508, abs=0.001)  # 20 in
    assert 0.05 < low[2] < 0.1016 and high[2] < 0.4
    low, high = MESHES.makers["tyre"]().bounds()
    assert high == pytest.approx((0.1016, 0.0381, 0.1016), abs=2e-4)
    assert low == pytest.approx(-high)
    for name in ("trailer_box", "trailer_trim", "trailer_lights"):
        low, high = MESHES.makers[name]().bounds()
        assert low[2] > 0.1 and high[2] < 0.65 and high[1] < 0.26 and high[0] < 0.70, name


def test_the_shell_is_folded_from_planes():
    """Roof and upper sides before and behind the ridge are flat: few directions, much area."""
    triangles = MESHES.makers["shell"]().triangles()
    vectors = np.array([meshes.area_vector(t) / 2.0 for t in triangles])
    areas = np.linalg.norm(vectors, axis=1)
    directions = {}
    for vector, area in zip(vectors, areas):
        key = tuple(np.round(vector / area, 2))
        directions[key] = directions.get(key, 0.0) + area
    largest = sorted(directions.values(), reverse=True)[:12]
    assert sum(largest) > 0.9 * areas.sum()


def test_colors_are_those_of_the_description():
    text = (PACKAGE / "urdf" / "materials.xacro").read_text()
    names = {
        "shell": "steel",
        "sides": "steel",
        "trailer_box": "box",
        "trailer_trim": "trim",
        "trailer_lights": "tail_bar",
    }
    for name, color in MESHES.colors.items():
        match = re.search(f'name="{names.get(name, name)}"><color rgba="([^"]*)"', text)
        assert tuple(map(float, match.group(1).split()))[:3] == color, name
    assert set(MESHES.colors) == set(MESHES.makers)
