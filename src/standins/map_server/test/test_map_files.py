"""Map files: what is read and written, and what is said about wrong ones."""

import cv2
import numpy as np
import pytest
from occupancy_map.files import Map, from_image, load, save

GOOD = {
    "image": "room.pgm",
    "resolution": "0.05",
    "origin": "[-1.5, 2, 0.1]",
    "negate": "0",
    "occupied_thresh": "0.65",
    "free_thresh": "0.196",
}


@pytest.fixture(name="room")
def _room(tmp_path):
    cv2.imwrite(str(tmp_path / "room.pgm"), np.array([[0, 205, 254], [254, 254, 0]], np.uint8))
    return tmp_path


def write(folder, **changes):
    lines = {**GOOD, **changes}
    path = folder / "room.yaml"
    path.write_text("".join(f"{key}: {value}\n" for key, value in lines.items() if value))
    return str(path)


def test_a_map_file(room):
    grid = load(write(room))
    assert grid.cells.tolist() == [[0, 0, 100], [100, -1, 0]]
    assert grid.resolution == 0.05 and grid.origin == (-1.5, 2.0, 0.1)


@pytest.mark.parametrize("suffix", ["png", "bmp", "pgm"])
def test_pictures_of_any_kind(room, suffix):
    pixels = np.array([[0, 205, 254]], np.uint8)
    if suffix == "png":
        pixels = np.repeat(pixels[:, :, None], 3, axis=2)
    cv2.imwrite(str(room / f"other.{suffix}"), pixels)
    assert load(write(room, image=f"other.{suffix}")).cells.tolist() == [[100, -1, 0]]


def test_a_picture_of_16_bits(room):
    cv2.imwrite(str(room / "deep.png"), np.array([[0, 52685, 65535]], np.uint16))
    assert load(write(room, image="deep.png")).cells.tolist() == [[100, -1, 0]]


def test_negate_may_be_a_truth_value_and_windows_may_have_written_the_file(room):
    path = write(room, negate="true")
    text = open(path, encoding="utf-8").read()
    with open(path, "wb") as stream:
        stream.write(b"\xef\xbb\xbf" + text.replace("\n", "\r\n").encode())
    assert load(path).cells.tolist() == [[100, 100, 0], [0, 100, 100]]


@pytest.mark.parametrize(
    "changes, words",
    [
        ({"resolution": ""}, "it has no resolution"),
        ({"resolution": "0"}, "resolution is 0 m, must be above 0"),
        ({"resolution": "fine"}, "resolution is 'fine', must be a number"),
        ({"origin": "[0, 0]"}, r"origin is \[0, 0\], must be \[x, y, yaw\]"),
        ({"mode": "gray"}, "mode is 'gray', must be one of trinary, scale, raw"),
        ({"image": "none.pgm"}, "none.pgm does not exist"),
        ({"image": "room.yaml"}, "room.yaml is not an image"),
        ({"free_thresh": ".nan"}, "free_thresh is nan, must be finite"),
    ],
)
def test_wrong_values_are_named(room, changes, words):
    with pytest.raises(ValueError, match=words) as error:
        load(write(room, **changes))
    assert "room.yaml" in str(error.value)


def test_wrong_files_are_named(room):
    with pytest.raises(ValueError, match="nothing.yaml cannot be read"):
        load(str(room / "nothing.yaml"))
    (room / "bad.yaml").write_text("image: [")
    with pytest.raises(ValueError, match="bad.yaml is no YAML"):
        load(str(room / "bad.yaml"))
    (room / "list.yaml").write_text("- 1")
    with pytest.raises(ValueError, match="list.yaml must be a map"):
        load(str(room / "list.yaml"))


def test_what_was_saved_is_loaded_again(tmp_path):
    cells = np.random.default_rng(1).choice(np.array([-1, 0, 100], np.int8), size=(20, 30))
    image, path = save(str(tmp_path / "m"), Map(cells, 0.025, (1.0, -2.0, 0.5)))
    grid = load(path)
    assert (grid.cells == cells).all()
    assert (grid.resolution, grid.origin) == (0.025, (1.0, -2.0, 0.5))
    assert (from_image(image, 0.1).cells == cells).all()
