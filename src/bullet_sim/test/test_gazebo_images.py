"""The drawn images of Gazebo's standard materials."""

import os

import cv2
import numpy as np
import pytest
from bullet_sim.description.model import Geometry, Shape, VisualLink
from bullet_sim.description.world import Scene
from bullet_sim.formats.images import cache
from bullet_sim.formats.images.drawings import png
from bullet_sim.formats.materials import _PICTURED, MEDIA, standard
from bullet_sim.meshes.prepare import write_box
from bullet_sim.render.gl.renderer import GlRenderer
from bullet_sim.render.request import CameraRequest, Quality
from bullet_sim.snapshot import BodySource, Snapshot
from PIL import Image

# Name -> least standard deviation of its channels [0..255].
CONTRASTS = {
    "WoodFloor": 10,
    "CeilingTiled": 12,
    "PaintedWall": 30,
    "WoodPallet": 20,
    "Wood": 12,
    "Bricks": 24,
    "Road": 10,
    "Residential": 5,
    "Pedestrian": 15,
    "Motorway": 20,
    "Trunk": 8,
    "Primary": 10,
    "Secondary": 8,
    "Steps": 45,
    "BuildingFrame": 100,
    "Runway": 50,
    "Grass": 8,
    "CoM": 127,
}


@pytest.fixture(name="folder", autouse=True)
def _folder(tmp_path, monkeypatch):
    """The folder that caches are in."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache"


def pixels(name):
    """RGB of a material's image, and its alpha if it has one."""
    image = cv2.imread(standard(f"Gazebo/{name}").texture, cv2.IMREAD_UNCHANGED)
    assert image is not None
    return image[..., [2, 1, 0, *range(3, image.shape[2])]].astype(float)


@pytest.mark.parametrize("name", _PICTURED)
def test_mean_and_contrast(name, folder):
    material = standard(f"Gazebo/{name}")
    assert material.tint is None and material.texture.startswith(str(folder))
    colors = pixels(name)[..., :3].reshape(-1, 3)
    assert np.abs(colors.mean(axis=0) - np.multiply(_PICTURED[name][5], 255.0)).max() < 2.0
    assert colors.std(axis=0).min() > CONTRASTS[name]
    with open(material.texture, "rb") as file:
        assert file.read() == png(name, _PICTURED[name][5])  # the same bytes again


def test_drawn_once_and_as_whole_files(folder):
    path = standard("Gazebo/CoM").texture
    before = os.stat(path)
    assert standard("CoM").texture == path
    after = os.stat(path)
    assert (before.st_ino, before.st_mtime_ns) == (after.st_ino, after.st_mtime_ns)
    assert os.listdir(os.path.dirname(path)) == [os.path.basename(path)]
    assert cache.folder() == str(folder / "paddock" / "textures")


def test_another_mean_is_another_file():
    assert cache.image_of("CoM", (0.5, 0.5, 0.5)) != cache.image_of("CoM", (0.4, 0.4, 0.4))


def test_without_a_cache_it_has_the_mean_color(folder):
    folder.write_text("no folder")
    material = standard("Gazebo/Bricks")
    assert material.texture == "" and material.tint == _PICTURED["Bricks"][5]
    shape = material.on(Shape(Geometry("box", (1, 1, 1))))
    assert shape.color == pytest.approx((*_PICTURED["Bricks"][5], 1.0))


def test_the_installed_image_comes_first(tmp_path, folder):
    media = tmp_path / "media"
    media.mkdir()
    (media / "bricks.png").write_bytes(b"")

    def resolve(uri):
        assert uri == MEDIA
        return str(media)

    assert standard("Gazebo/Bricks", resolve).texture == str(media / "bricks.png")
    assert not folder.exists()
    assert standard("Gazebo/Wood", resolve).texture.startswith(str(folder))


def changes(values, limit):
    """First index and length of each stretch above a limit."""
    edges = np.diff(np.concatenate([[0], (values > limit).astype(int), [0]]))
    return list(zip(np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)))


def test_bricks_have_courses_and_bond():
    picture = pixels("Bricks")
    blue = picture[..., 2] - picture[..., 0]  # mortar is blue
    rows = blue.mean(axis=1)
    beds = [(first + end) / 2 for first, end in changes(rows, rows.mean() + 0.5 * rows.std())]
    assert len([at for at in beds if at > 20]) == 15
    assert np.diff(beds) == pytest.approx(65.5, abs=6)
    heads = []
    for top, bottom in ((145, 180), (211, 246)):  # two courses
        columns = np.median(blue[top:bottom], axis=0)
        heads.append([(a + b) / 2 for a, b in changes(columns, 0.0) if b - a > 4])
        assert np.diff(heads[-1]) == pytest.approx(197.0, abs=5)
    assert abs(heads[0][0] - 39) < 4 and abs(heads[1][0] - 127) < 4


@pytest.mark.parametrize(
    "name, lines, color",
    [
        ("Road", ((15, 5), (491, 5), (504, 5), (1004, 5)), (204, 188, 127)),
        ("Primary", ((15, 5), (491, 5), (504, 5), (1004, 5)), (204, 188, 127)),
        ("Trunk", ((3, 9), (283, 9), (296, 9), (577, 8)), (171, 148, 76)),
        ("Secondary", ((273, 8), (287, 7)), (171, 148, 76)),
        ("Motorway", ((44, 12), (498, 11), (515, 12), (969, 12)), (168, 140, 74)),
    ],
)
def test_yellow_lines(name, lines, color):
    middle = np.median(pixels(name), axis=0)
    found = changes(middle[:, 0] - middle[:, 2], 30)
    if name == "Secondary":  # begins with the edge of one
        assert found.pop(0) == (0, 3)
    assert [(first, end - first) for first, end in found] == list(lines)
    for first, end in found:
        assert middle[first:end].mean(axis=0) == pytest.approx(color, abs=14)


@pytest.mark.parametrize(
    "name, columns, width, rows, color",
    [
        ("Motorway", (182, 349, 657, 824), 10, ((186, 139), (696, 139)), (252, 252, 252)),
        ("Trunk", (144, 438), 7, ((24, 72), (175, 72), (326, 72), (480, 68)), (173, 169, 151)),
    ],
)
def test_dashes(name, columns, width, rows, color):
    picture = pixels(name)
    for column in columns:
        dashed = picture[:, column : column + width]
        beside = picture[:, column - width - 4 : column - 4].mean()
        found = changes(dashed.mean(axis=(1, 2)), (beside + np.mean(color)) / 2)
        assert [(first, end - first) for first, end in found] == list(rows)
        for first, end in found:
            assert dashed[first:end].mean(axis=(0, 1)) == pytest.approx(color, abs=4)


@pytest.mark.parametrize(
    "name, x, y, color",
    [
        ("PaintedWall", 100, 2, (254, 254, 253)),
        ("PaintedWall", 300, 340, (240, 221, 93)),
        ("PaintedWall", 300, 400, (201, 111, 15)),
        ("PaintedWall", 300, 500, (104, 54, 1)),
        ("CoM", 25, 25, (255, 255, 255)),
        ("CoM", 75, 25, (0, 0, 0)),
        ("CoM", 75, 75, (255, 255, 255)),
        ("BuildingFrame", 50, 50, (255, 255, 255, 0)),
        ("BuildingFrame", 5, 50, (0, 0, 0, 255)),
        ("Runway", 200, 13, (255, 255, 255)),
        ("Runway", 200, 52, (77, 77, 77)),
        ("Runway", 330, 52, (255, 255, 255)),
        ("Runway", 1344, 52, (255, 255, 0)),
        ("WoodFloor", 250, 192, (37, 0, 0)),
        ("Pedestrian", 43, 200, (100, 98, 85)),
    ],
)
def test_a_point(name, x, y, color):
    assert pixels(name)[y, x] == pytest.approx(color, abs=25 if name == "Pedestrian" else 4)


def test_grass_is_repeated_fifty_times():
    finish = standard("Gazebo/Grass").finish
    assert finish.mapping.transform == (50.0, 0.0, -24.5, 0.0, 50.0, -24.5)
    assert standard("Gazebo/Bricks").finish.mapping.transform == ()


def test_a_brick_wall_in_a_camera():
    renderer = GlRenderer(Quality("false", "false"))
    try:
        wall = standard("Gazebo/Bricks").on(Shape(Geometry("box", (0.1, 1.0, 1.0))))
        link = VisualLink(shapes=(wall,))
        renderer.sync_sources([BodySource(1, True, (link,))], Scene())
        pose = ((-1.0, 0.0, 0.0), (0.0, 0.0, 0.0))
        request = CameraRequest("eye", None, 0, pose, 256, 256, 0.8, 0.1, 10.0)
        picture = renderer.draw(Snapshot(0.0, 0, ()), request).astype(int)
    finally:
        renderer.close()
    excess = picture[..., 0] - picture[..., 2]
    assert (excess > 12).mean() > 0.5  # bricks, in the light of the surroundings alone
    assert 0.1 < (excess < -8).mean() < 0.4  # mortar


def test_a_png_is_copied_for_pybullet(tmp_path):
    path = standard("Gazebo/Grass").texture
    write_box((1, 1, 1), path, str(tmp_path))
    with open(path, "rb") as drawn, open(tmp_path / "part_0.png", "rb") as copied:
        assert drawn.read() == copied.read()
    Image.new("L", (4096, 1024)).save(tmp_path / "large.png")
    write_box((1, 1, 1), str(tmp_path / "large.png"), str(tmp_path))
    assert cv2.imread(str(tmp_path / "part_0.png")).shape == (512, 2048, 3)
