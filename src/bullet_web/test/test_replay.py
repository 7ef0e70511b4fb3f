"""Recordings as HTML files: complete, small, without anything from outside."""

import base64
import io
import re

import numpy as np
import pytest
from bullet_sim.pose import Pose
from bullet_sim.sensors.scenes import WorldViews
from bullet_sim.world import World
from bullet_web.replay import Recording, TooLarge, shrunk
from bullet_web.scene import Asset, SceneMaker, image_asset
from PIL import Image
from replay_rig import ARM, data_of, numbers

from bullet_web import files, replay


@pytest.fixture
def recording():
    world = World()
    try:
        world.spawn_urdf("</script><b>arm", ARM, Pose((0.0, 0.0, 1.0)), str)
        views, maker = WorldViews(world), SceneMaker()
        made = Recording("A <title>")
        made.set_scene(maker.make(views.scene()), maker.assets)
        for _ in range(10):
            world.step(20)
            view = views.view()
            made.add(view["time"], view["bodies"])
        yield made
    finally:
        world.close()


def test_a_page_has_scene_frames_and_scripts_and_loads_nothing(recording, page_files, tmp_path):
    size = recording.write(tmp_path / "replay.html", page_files)
    page = (tmp_path / "replay.html").read_text()
    assert size == len(page.encode()) < replay.LIMIT
    assert list(tmp_path.iterdir()) == [tmp_path / "replay.html"]
    assert "default-src 'none'" in page
    assert not re.search(r"<(script|link|img|iframe)[^>]* (src|href)=\"(?!data:)[^\"]", page)
    for name in ("THREE", "class World", "class Replay", 'class="is-replay"', "#world {"):
        assert name in page
    assert page.count("<script>") == page.count("</script>") == 1 + len(replay.SCRIPTS)
    data = data_of(page)
    (part,) = data["parts"]
    times = numbers(part["times"], "<f8")
    assert times == pytest.approx(np.arange(1, 11) * 0.02)
    ((key, width),) = part["bodies"]
    rows = numbers(part["rows"], "<f4").reshape(10, width)
    assert width == 8  # position, quaternion, one joint
    assert rows[0, 2] < 1.0 and (np.diff(rows[:, 2]) < 0.0).all()  # it falls
    assert data["title"] == "A <title>"
    assert part["scene"]["bodies"][0]["name"] == "</script><b>arm"
    assert set(data["assets"]) == {
        each["mesh"] for link in part["scene"]["bodies"][0]["links"] for each in link["instances"]
    }


def test_time_that_goes_back_begins_another_part(recording, page_files):
    recording.add(0.02, [])
    recording.add(0.04, [])
    recording.add(0.04, [])  # paused: nothing new
    data = data_of(recording.html(page_files))
    assert [len(numbers(part["times"], "<f8")) for part in data["parts"]] == [10, 2]
    assert [bool(part["scene"]) for part in data["parts"]] == [True, False]


def test_a_world_that_is_reset_again_and_again_has_a_bounded_page(recording, page_files):
    for index in range(5000):
        recording.add(0.5 + 0.5 * (index % 2), [])
    data = data_of(recording.html(page_files))
    assert len(data["parts"]) <= replay.MAX_PARTS
    assert numbers(data["parts"][0]["times"], "<f8")[0] == pytest.approx(0.02)
    assert [bool(part["scene"]) for part in data["parts"]].count(True) == 1


def test_a_page_that_cannot_be_written_leaves_nothing(recording, page_files, tmp_path):
    (tmp_path / "replay.html").mkdir()
    with pytest.raises(OSError, match="replay.html"):
        recording.write(tmp_path / "replay.html", page_files)
    assert [path.name for path in tmp_path.iterdir()] == ["replay.html"]


def test_curves_are_kept_and_thinned(recording, page_files, monkeypatch):
    monkeypatch.setattr(replay, "MAX_SAMPLES", 8)
    for index in range(30):
        recording.add_value("to the center line", "m", 0.01 * index, 0.1)
    curve = data_of(recording.html(page_files))["curves"]["to the center line"]
    assert curve["unit"] == "m" and 4 <= len(curve["points"]) <= 8
    recording.add_value("to the center line", "m", 0.0, 0.2)  # reset
    curve = data_of(recording.html(page_files))["curves"]["to the center line"]
    assert curve["points"] == [[0.0, 0.2]]


def test_many_frames_are_thinned_to_the_ends_of_the_drive(recording, monkeypatch):
    monkeypatch.setattr(replay, "MAX_FRAMES", 16)
    for index in range(100):
        recording.add(1.0 + index, [])
    part = recording._parts[0]
    assert recording.frames <= 16
    assert part.times[0] == pytest.approx(0.02) and part.times[-1] == 100.0


def test_images_give_way_first_and_then_frames(recording, page_files, monkeypatch):
    noise = np.random.default_rng(1).integers(0, 255, (1024, 1024, 3), np.uint8)
    asset = image_asset((1024, 1024), 3, noise.tobytes())
    scene = recording._parts[0].scene
    scene["bodies"][0]["links"][0]["instances"][0]["image"] = asset.name
    recording._assets[asset.name] = asset
    full = len(recording.html(page_files))
    monkeypatch.setattr(replay, "LIMIT", full - 100_000)
    page = recording.html(page_files)
    kept = data_of(page)["assets"][asset.name]
    image = Image.open(io.BytesIO(base64.b64decode(kept.partition(",")[2])))
    assert max(image.size) < 1024 and recording.frames == 10
    monkeypatch.setattr(replay, "LIMIT", 100_000)
    with pytest.raises(TooLarge, match="MB with its meshes alone, at most 0.1 MB fit"):
        recording.html(page_files)


def test_nothing_recorded_is_an_error_and_writes_nothing(page_files, tmp_path):
    with pytest.raises(ValueError, match="nothing was recorded"):
        Recording().write(tmp_path / "replay.html", page_files)
    assert list(tmp_path.iterdir()) == []


def test_meshes_are_not_shrunk():
    mesh = Asset("m", "application/octet-stream", b"1234")
    assert shrunk(mesh, 256) is mesh


def test_missing_libraries_are_named(monkeypatch, tmp_path):
    monkeypatch.setattr(files, "folder", lambda: tmp_path)
    with pytest.raises(OSError, match="index.html cannot be read"):
        files.read(files.LIVE)
    path = files.THREE / "absent.js"
    monkeypatch.setattr(files, "LIBRARIES", {"three.min.js": path})
    with pytest.raises(OSError, match="libjs-three brings it"):
        files.read(())
