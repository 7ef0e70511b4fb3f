"""Geometry, image, SDF, cache and command line."""

import os
import pathlib
import subprocess
import sys
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from track_model.files import cache, writer
from track_model.files import writer as files

from track_model import curves, geometry, source, spec, track, track_file

cv2 = pytest.importorskip("cv2")
PACKAGE = pathlib.Path(__file__).resolve().parents[1]
COMMON = PACKAGE.parent / "paddock_common" / "src"
SMALL = "points: [[0, 0], [2, 0], [2, 1.6], [0, 1.6]]\nwidth: 0.5\n"


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    old = os.environ.get("XDG_CACHE_HOME")
    os.environ["XDG_CACHE_HOME"] = str(tmp_path_factory.mktemp("made"))
    try:
        yield track.load_track("default")
    finally:
        os.environ.pop("XDG_CACHE_HOME")
        if old is not None:
            os.environ["XDG_CACHE_HOME"] = old


@pytest.fixture
def small(tmp_path):
    path = tmp_path / "small.yaml"
    path.write_text(SMALL)
    return str(path)


def run(*arguments):
    """Run make_track as roslaunch does; returns (exit code, stdout, stderr)."""
    result = subprocess.run(
        [sys.executable, str(PACKAGE / "scripts" / "make_track"), *arguments],
        env={**os.environ, "PYTHONPATH": f"{PACKAGE}/src:{COMMON}"},
        capture_output=True,
        text=True,
        timeout=90,
        check=False,
    )
    return result.returncode, result.stdout, result.stderr


def test_spline_of_a_circle_is_a_circle():
    """A closed cubic spline errs by the fourth power of the knot spacing (here 0.26 rad)."""
    angles = 2.0 * np.pi * np.arange(24) / 24
    knots = 2.0 * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    curve = curves.resample(curves.spline(knots, True)[0])
    assert np.linalg.norm(curve, axis=1) == pytest.approx(2.0, abs=1e-4)  # [m]
    assert curves.length(curve) == pytest.approx(4.0 * np.pi, abs=1e-2)
    assert curves.radii(curve) == pytest.approx(2.0, rel=0.02)
    inner = curve + 0.5 * curves.left_normals(curve)
    assert np.linalg.norm(inner, axis=1) == pytest.approx(1.5, abs=1e-3)


def test_start_pose_is_the_origin(made):
    assert made.centreline[0] == pytest.approx((0, 0), abs=1e-9)
    assert curves.tangents(made.centreline)[0] == pytest.approx((1, 0), abs=1e-9)


def test_start_distance_moves_the_start():
    here, there = (
        geometry.lane(track_file.parse(SMALL + f"start_distance: {d:g}", "a")).curve
        for d in (0.0, 1.0)
    )
    assert there[0] == pytest.approx((0, 0), abs=1e-9)
    assert curves.tangents(there)[0] == pytest.approx((1, 0), abs=1e-9)
    # The old start lies 1 m of track behind: at most 1 m away, and behind.
    distance = np.linalg.norm(there + 0.0, axis=1)
    assert curves.length(here) == pytest.approx(curves.length(there), rel=1e-4)
    assert distance[len(there) // 2] > 1.0


def test_edges(made):
    for edge in (made.inner, made.outer):
        assert np.linalg.norm(edge - made.centreline, axis=1) == pytest.approx(made.width / 2)
    assert curves.length(made.inner) < made.length < curves.length(made.outer)


def color_at(made, points):
    """Return the texture's RGB (N, 3) under points [m] by the documented orientation alone."""
    image = cv2.imread(made.texture)[:, :, ::-1].astype(float)
    xmin, xmax, ymin, ymax = made.extent
    rows, columns = image.shape[:2]
    column = ((points[:, 0] - xmin) / (xmax - xmin) * columns).astype(int)
    row = ((ymax - points[:, 1]) / (ymax - ymin) * rows).astype(int)
    return image[row, column]


def test_texture_shows_borders_and_grass_where_they_are(made):
    half, line = made.width / 2.0, made.spec.border_width / 2.0
    curve = made.centreline[5:-5]  # without the start line
    normal = curves.left_normals(made.centreline)[5:-5]
    for side in (-1.0, 1.0):
        for distance, name in (
            (half - line, "border"),
            (half + 0.05, "grass"),
            (half / 2.0, "asphalt"),
        ):
            colors = color_at(made, curve + side * distance * normal)
            error = np.abs(colors - made.spec.colors[name]).max(axis=1)
            assert np.percentile(error, 95) < 30, (side, name)


def test_dashes_are_orange_for_their_fraction(made):
    colors = color_at(made, made.centreline[5:-5])
    orange = np.abs(colors - made.spec.colors["centre_line"]).max(axis=1) < 60
    assert orange.mean() == pytest.approx(0.6, abs=0.03)


def test_mesh_and_image_agree(made):
    """u grows with x, v with y; v = 0 is the image's bottom row, as OBJ defines."""
    lines = [line.split() for line in open(made.directory + "/track.obj", encoding="utf-8")]
    vertices = [tuple(map(float, line[1:])) for line in lines if line[0] == "v"]
    uvs = [tuple(map(float, line[1:])) for line in lines if line[0] == "vt"]
    xmin, xmax, ymin, ymax = made.extent
    corners = {}
    for line in lines:
        if line[0] == "f":
            pairs = [tuple(map(int, corner.split("/")[:2])) for corner in line[1:]]
            if all(uv != 1 for _, uv in pairs):
                corners.update({vertices[v - 1][:2]: uvs[uv - 1] for v, uv in pairs})
    expected = {
        (xmin, ymin): (0, 0),
        (xmax, ymin): (1, 0),
        (xmax, ymax): (1, 1),
        (xmin, ymax): (0, 1),
    }
    assert len(corners) == 4
    for (x, y), uv in corners.items():
        key = min(expected, key=lambda corner: np.hypot(corner[0] - x, corner[1] - y))
        assert key == pytest.approx((x, y), abs=1e-4) and expected[key] == uv


def test_pixels():
    area = (0.0, 2.0, 0.0, 1.0)
    assert writer.to_pixels([(0, 1), (2, 0)], area) == pytest.approx(np.array([(0, 0), (400, 200)]))


def test_sdf(made):
    model = ET.parse(made.directory + "/track.sdf").getroot().find("model")
    assert model.get("name") == "track" and model.find("static").text == "true"
    assert len(model.findall(".//collision")) == 1 and model.find(".//plane") is not None
    assert float(model.find(".//ode/mu").text) == 1.0
    uri = model.find(".//mesh/uri").text
    assert uri == "file://" + made.directory + "/track.obj" and os.path.isfile(uri[7:])
    world = ET.parse(made.directory + "/track.world").getroot().find("world")
    assert world.find("model").get("name") == "track" and world.find("include/uri") is not None


def test_walls_keep_clear_of_the_lane(small):
    with open(small, "a", encoding="utf-8") as stream:
        stream.write("walls: {enabled: true, height: 0.2}\n")
    loaded = track.load_track(small)
    model = ET.parse(loaded.directory + "/track.sdf").getroot().find("model")
    walls = model.find("link[@name='walls']")
    assert len(walls.findall("collision")) == len(walls.findall("visual")) > 10
    for pose in walls.findall("collision/pose"):
        x, y, z = [float(word) for word in pose.text.split()][:3]
        assert z == pytest.approx(0.1)
        assert np.hypot(*(loaded.centreline - (x, y)).T).min() > loaded.width / 2 + 0.1


@pytest.mark.parametrize("gap", [0.4, 0.8, 1.5, 3.0])
def test_walls_with_a_wide_gap_leave_out_what_has_no_room(gap):
    path = source.find("hard")
    parsed = track_file.parse(
        source.read(path).decode() + f"walls: {{enabled: true, gap: {gap:g}}}", path
    )
    lane = geometry.lane(parsed)
    for x, y, _, _ in files.wall_boxes(lane, parsed):
        assert np.hypot(*(lane.curve - (x, y)).T).min() > parsed.width / 2 + gap - 0.1


def test_cache_is_used_and_repaired(small, own_cache):
    first = cache.ensure(small)
    assert os.path.dirname(first) == str(own_cache) and os.listdir(own_cache) == [
        os.path.basename(first)
    ]
    before = os.stat(first + "/track.png").st_mtime_ns
    assert cache.ensure(small) == first and os.stat(first + "/track.png").st_mtime_ns == before
    os.remove(first + "/track.obj")
    assert cache.ensure(small) == first and os.path.isfile(first + "/track.obj")
    assert os.listdir(own_cache) == [os.path.basename(first)]


def test_changed_file_gets_its_own_folder(small, own_cache):
    first = cache.ensure(small)
    with open(small, "a", encoding="utf-8") as stream:
        stream.write("seed: 1\n")
    assert cache.ensure(small) != first and len(os.listdir(own_cache)) == 2


def test_same_input_same_bytes(small, tmp_path, monkeypatch):
    images = []
    for name in ("one", "two"):
        monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / name))
        images.append(open(cache.ensure(small) + "/track.png", "rb").read())
    assert images[0] == images[1]


def test_bad_track_leaves_nothing(tmp_path, own_cache):
    path = tmp_path / "bad.yaml"
    path.write_text("points: [[0, 0], [4, 4], [4, 0], [0, 4]]")
    with pytest.raises(spec.TrackError):
        cache.ensure(str(path))
    assert os.listdir(own_cache) == []


def states(folder):
    """Path -> inode and time of change of all files below a folder."""
    return {path: (path.stat().st_ino, path.stat().st_mtime_ns) for path in folder.rglob("*")}


def test_command_line(small, own_cache, tmp_path):
    code, out, err = run("--sdf", small)
    assert (code, err) == (0, "") and ET.fromstring(out).find("model").get("name") == "track"
    made = states(own_cache)
    assert made and run("--sdf", small)[1] == out
    assert states(own_cache) == made  # cached: nothing was generated again
    code, out, err = run(small, "-o", str(tmp_path / "out dir"))
    assert (code, err) == (0, "") and len(out.split("\n")) == 7
    assert all(os.path.isfile(path) for path in out.rstrip("\n").split("\n"))
    assert sorted(os.listdir(tmp_path / "out dir")) == sorted(cache.FILES)


def test_walls_can_be_asked_for(small, own_cache):
    code, out, err = run("--sdf", "--walls", small)
    assert (code, err) == (0, "")
    made = ET.fromstring(out).find("model")
    assert len(made.findall("link[@name='walls']/collision")) > 10
    uri = made.find("link/visual/geometry/mesh/uri").text
    assert uri == ET.fromstring(run("--sdf", small)[1]).find(".//visual//uri").text
    assert track.load_track(small, walls=True).spec.walls.enabled
    assert not track.load_track(small).spec.walls.enabled
    assert track.load_track(small, walls=True).sdf() == out
    assert track.load_track(small).sdf() == run("--sdf", small)[1], "what the cache has"
    assert run("--walls", small)[0] == 2


def test_cached_answer_imports_no_numpy(small, package):
    cache.ensure(small)
    code = (
        f'import sys; from track_model.cli import main; main(["--sdf", {small!r}]); '
        'sys.exit("numpy" in sys.modules or "cv2" in sys.modules)'
    )
    result = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        timeout=90,
        env={**os.environ, "PYTHONPATH": f"{package}/src:{COMMON}"},
        check=False,
    )
    assert result.returncode == 0


@pytest.mark.parametrize(
    "content, texts",
    [
        (None, ["nowhere", "default, easy, hard, medium"]),
        ("points: [[0, 0], [1, 0]]", ["points", "2 distinct points"]),
        (SMALL + "colour: red", ["'colour'", "colours"]),
    ],
)
def test_command_line_errors_are_one_line(tmp_path, content, texts):
    path = tmp_path / "nowhere.yaml"
    if content:
        path.write_text(content)
    code, out, err = run("--sdf", str(path))
    assert (code, out) == (1, "") and err.count("\n") == 1 and err.startswith("make_track: ")
    for text in texts:
        assert text in err


def test_unwritable_cache_is_one_line(small, tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    code, out, err = run("--sdf", small)
    assert (code, out) == (1, "") and err.count("\n") == 1 and str(tmp_path / "file") in err
