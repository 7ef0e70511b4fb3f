"""bench/pictures_beside_gazebo.py: features beside what is recorded of Gazebo, pairs, bad input."""

import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

BENCH = Path(__file__).resolve().parents[2] / "bench"
sys.path.insert(0, str(BENCH))

import pictures_beside_gazebo as command  # noqa: E402
from pictures import features, likeness  # noqa: E402


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
