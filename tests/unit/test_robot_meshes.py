"""The meshes of car and truck: closed, seen from outside, as large and as colored as described."""

import pathlib
import re

import numpy as np
import pytest

SRC = pathlib.Path(__file__).resolve().parents[2] / "src"
FILES = sorted(SRC.glob("track_model/meshes/*.obj")) + sorted(SRC.glob("cybertruck/meshes/*.obj"))
MATERIALS = {  # in urdf/materials.xacro, where the name is not the mesh's
    "body": "paint", "headlights": "headlight", "taillights": "taillight",
    "shell": "steel", "sides": "steel", "trailer_box": "box", "trailer_trim": "trim",
    "trailer_lights": "tail_bar",
}  # fmt: skip
SIZES = {  # package -> meshes together, low and high corner [m]
    ("track_model", "tyre"): ((-0.03, -0.0125, -0.03), (0.03, 0.0125, 0.03)),
    ("track_model", "body trim stripe glass headlights taillights"):
        ((-0.147, -0.0975, 0.0), (0.17, 0.0975, 0.121)),
    ("cybertruck", "shell sides light_bar tail_bar"):  # 38 by 20 in
        ((-0.238, -0.254, 0.085), (0.734, 0.254, 0.365)),
    ("cybertruck", "tyre"): ((-0.1016, -0.0381, -0.1016), (0.1016, 0.0381, 0.1016)),
    ("cybertruck", "trailer_box trailer_trim trailer_lights"):
        ((-0.35, -0.254, 0.125), (0.58, 0.254, 0.605)),
}  # fmt: skip


def read(path):
    """Returns positions (N, 3), normals (M, 3) and faces (F, 3, 2)."""
    rows = [line.split() for line in path.read_text().splitlines()]
    points, normals = (np.array([row[1:] for row in rows if row[0] == tag], float)
                       for tag in ("v", "vn"))  # fmt: skip
    faces = [[list(map(int, c.split("//"))) for c in row[1:]] for row in rows if row[0] == "f"]
    return points, normals, np.array(faces)


@pytest.mark.parametrize("path", FILES, ids=lambda path: f"{path.parts[-3]} {path.stem}")
def test_a_mesh_is_closed_and_seen_from_outside(path):
    points, normals, faces = read(path)
    a, b, c = (points[faces[:, k, 0] - 1] for k in range(3))
    across = np.cross(b - a, c - a)
    assert np.abs(across.sum(axis=0)).max() < 1e-6 and np.einsum("ij,ij->", a, across) > 0.0
    # corners are rounded to 0.01 mm: no more than a fifth of a thin strip's height
    flat = np.einsum("ij,ij->i", across, normals[faces[:, 0, 1] - 1])
    flat /= np.linalg.norm(across, axis=1)
    assert np.median(flat) > 0.999 and np.percentile(flat, 2) > 0.8
    assert path.stat().st_size < 200_000
    name = MATERIALS.get(path.stem, path.stem)
    text = (path.parents[1] / "urdf" / "materials.xacro").read_text()
    described = re.search(f'name="{name}"><color rgba="([^"]*) 1', text)[1].split()
    written = re.search("^Kd (.*)$", path.with_suffix(".mtl").read_text(), re.MULTILINE)[1].split()
    assert list(map(float, written)) == list(map(float, described))


@pytest.mark.parametrize("package, names", SIZES)
def test_sizes(package, names):
    points = np.concatenate([read(SRC / package / "meshes" / f"{name}.obj")[0]
                             for name in names.split()])  # fmt: skip
    low, high = SIZES[package, names]
    assert points.min(axis=0) == pytest.approx(low, abs=3e-3)
    assert points.max(axis=0) == pytest.approx(high, abs=3e-3)
