"""bench/pictures_beside_gazebo.py: features beside what is recorded of Gazebo, pairs, bad input."""

import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from sensor_msgs.msg import Image, PointCloud2

BENCH = Path(__file__).resolve().parents[2] / "bench"
sys.path.insert(0, str(BENCH))

import pictures_beside_gazebo as command  # noqa: E402
from pictures import features, likeness, record  # noqa: E402


@pytest.fixture(name="seen", scope="module")
def _seen(tmp_path_factory):
    folder = tmp_path_factory.mktemp("features")
    features.write(folder)
    return features.render(folder)


@pytest.mark.parametrize("name", features.PLACES)
def test_each_feature_looks_as_in_gazebo(seen, name):
    pair = likeness.recorded_pair(likeness.recorded()[name], seen[name])
    assert command.is_alike(pair), command.figures_text(pair)
    if name in ("depth", "kinect"):
        assert pair.depth[0] > 0.99 and pair.depth[1] < 0.01


BROKEN = {
    "solids": ("<diffuse>0.8 0.8 0.8 1</diffuse>", "<diffuse>0.6 0.6 0.6 1</diffuse>"),
    "lamp": ("<constant>0.4</constant>", "<constant>0.6</constant>"),
    "barrel": ("<k1>-0.3</k1>", "<k1>0</k1>"),
    "barrel_border": ("<borderCrop>false</borderCrop>", ""),
    "pincushion": ("<k1>0.25</k1>", "<k1>0</k1>"),
    "tangential": ("<p1>0.03</p1>", "<p1>0</p1>"),
    "noise": ("<mean>0.02</mean>", "<mean>0.1</mean>"),
    "clipped": ("<near>0.6</near>", "<near>0.1</near>"),
    "depth": ("<pose>3 0.8 0.5 0 0 0.5</pose>", "<pose>3.01 0.8 0.5 0 0 0.5</pose>"),
    "kinect": ("<pointCloudCutoffMax>6.0<", "<pointCloudCutoffMax>4.0<"),
    "polylines": ("<point>1.5 1.3</point>", "<point>1.5 2.3</point>"),
    "intrinsics": ("<s>40</s>", "<s>0</s>"),
    "headlight": ("<pose>0 0 1 0 -1.4 0</pose>", "<pose>0 0 1 0 -1.4 0.3</pose>"),
    "road_element": ("<width>2</width>", "<width>3</width>"),
    "wide": ("<type>equidistant</type>", "<type>stereographic</type>"),
}


@pytest.fixture(name="broken", scope="module")
def _broken(tmp_path_factory):
    """What is seen of a world in which a value of each of these features is another."""
    folder = tmp_path_factory.mktemp("broken")
    path = Path(features.write(folder))
    text = path.read_text()
    for before, after in BROKEN.values():
        assert before in text
        text = text.replace(before, after)
    path.write_text(text)
    return features.render(folder)


@pytest.mark.parametrize("name", BROKEN)
def test_another_value_makes_its_pair_differ(broken, name):
    pair = likeness.recorded_pair(likeness.recorded()[name], broken[name])
    assert not command.is_alike(pair), command.figures_text(pair)


def test_fewer_images_of_a_pass_make_the_panels_differ(monkeypatch, tmp_path):
    monkeypatch.setattr("bullet_sim.formats.ogre.MAX_LAYERS", 0)
    features.write(tmp_path)
    pair = likeness.recorded_pair(
        likeness.recorded()["panels"], features.render(tmp_path)["panels"]
    )
    assert pair.cells[1] < 0.9, command.figures_text(pair)


def save(path, image):
    cv2.imwrite(str(path), cv2.cvtColor(image, cv2.COLOR_RGB2BGR))


def test_public_pairs_and_their_page(tmp_path, capsys):
    one = np.zeros((48, 64, 3), np.uint8)
    one[10:30, 10:30] = (200, 20, 20)
    save(tmp_path / "car.gazebo_camera.png", one)
    save(tmp_path / "car.paddock_camera.ppm", one)
    save(tmp_path / "van.gazebo_camera.png", one)
    save(tmp_path / "van.paddock_camera.png", one[::-1])
    page = tmp_path / "page.html"
    sheet = tmp_path / "sheet.png"
    assert command.main([str(tmp_path), "--page", str(page), "--sheet", str(sheet)]) == 1
    out = capsys.readouterr().out
    assert "alike  car camera: similarity 1.000" in out and "differ van camera" in out
    assert "Public packages: 1 of 2 alike" in out
    assert f"World of features: {len(features.PLACES)} of {len(features.PLACES)} alike" in out
    assert page.read_text().count("data:image/png") == 4 + len(features.PLACES)
    assert cv2.imread(str(sheet)).shape == (274, 2 * 656, 3)


@pytest.mark.parametrize(
    "arguments, words",
    [
        (["{folder}/none"], "none' is no folder"),
        (["{folder}"], "has no pair"),
        (["--gazebo", "{folder}/none.npz"], "none.npz' is no recording"),
        (["--update"], "--update needs --gazebo"),
        (["--sheet", "{folder}/sheet.png"], "--sheet needs images of Gazebo"),
        (["--world", "{folder}/w", "--only", "road,nowhere"], "'nowhere', the places are solids"),
    ],
)
def test_bad_input_is_named(tmp_path, capsys, arguments, words):
    assert command.main([word.format(folder=tmp_path) for word in arguments]) == 2
    assert words in capsys.readouterr().err


def test_images_that_cannot_be_compared_are_named(tmp_path, capsys):
    image = np.zeros((48, 64, 3), np.uint8)
    save(tmp_path / "car.gazebo_camera.png", image)
    save(tmp_path / "car.paddock_camera.png", image[:32])
    assert command.main([str(tmp_path)]) == 2
    assert "have sizes (48, 64, 3), (32, 64, 3)" in capsys.readouterr().err
    (tmp_path / "car.paddock_camera.png").write_text("no image")
    assert command.main([str(tmp_path)]) == 2
    assert "is no image that can be read" in capsys.readouterr().err


def test_the_world_is_written_with_its_files_and_some_places(tmp_path, capsys):
    arguments = ["--world", str(tmp_path), "--only", "road,depth", "--seen-as", "/elsewhere"]
    assert command.main(arguments) == 0
    text = (tmp_path / "features.world").read_text()
    assert text.count("<sensor") == 2 and "file:///elsewhere<" in text
    assert (tmp_path / "features_checker.png").is_file()
    assert "material Features/Checker" in (tmp_path / "features.material").read_text()


def test_a_recording_is_read_as_it_was_saved(tmp_path):
    recorder = record.Recorder()
    names = ["/depth/image_raw", "/depth/depth/image_raw", "/depth/points"]
    recorder._missing = set(names)
    colors = np.arange(24, dtype=np.uint8).reshape(2, 4, 3)
    depth = np.array([[1.0, np.nan], [2.0, 3.0]], np.float32)
    points = np.zeros((4, 8), np.float32)
    points[:, 2] = depth.ravel()
    messages = [
        Image(height=2, width=4, encoding="rgb8", data=colors.tobytes()),
        Image(height=2, width=2, encoding="32FC1", data=depth.tobytes()),
        PointCloud2(height=1, width=4, point_step=32, data=points.tobytes()),
    ]
    for _ in range(record.SKIPPED + 1):
        assert recorder._missing == set(names)
        for name, message in zip(names, messages):
            recorder._on_message(message, name)
    assert not recorder._missing
    np.savez_compressed(tmp_path / "g.npz", **recorder.arrays)
    found = command.read_recordings([tmp_path / "g.npz"])["depth"]
    np.testing.assert_array_equal(found.rgb, colors)
    np.testing.assert_array_equal(found.depth, depth)
    assert found.points.shape == (1, 4, 3)
