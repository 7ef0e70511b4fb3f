"""Pixels and cells: thresholds, modes, which way is up."""

import numpy as np
import pytest
from occupancy_map.files import from_pixels, to_pixels


@pytest.mark.parametrize(
    "gray, cell",
    [
        (0, 100),
        (89, 100),  # darkness 0.651
        (90, -1),  # 0.647
        (205, -1),  # 0.1961
        (206, 0),  # 0.1922
        (255, 0),
    ],
)
def test_the_usual_thresholds(gray, cell):
    assert from_pixels([[gray]], 0.65, 0.196)[0, 0] == cell


@pytest.mark.parametrize("gray, cell", [(0, 0), (49, 0), (50, -1), (165, -1), (166, 100)])
def test_negated(gray, cell):
    assert from_pixels([[gray]], 0.65, 0.196, negate=True)[0, 0] == cell


def test_exactly_at_a_threshold_is_unknown():
    assert from_pixels([[204]], 0.65, 0.2)[0, 0] == -1  # darkness 51/255 = 0.2
    assert from_pixels([[102]], 0.6, 0.2)[0, 0] == -1  # 153/255 = 0.6


def test_scale_runs_from_1_to_99():
    cells = from_pixels([list(range(0, 256, 5))], 0.8, 0.2, mode="scale")[0]
    for gray, cell in zip(range(0, 256, 5), cells):
        dark = 255 - gray  # of 255; the thresholds are 204 and 51
        if dark > 204 or dark < 51:
            assert cell == (100 if dark > 204 else 0)
        else:
            assert cell == pytest.approx(1.0 + 98.0 * (dark - 51) / 153.0, abs=1.0)
            assert 1 <= cell <= 99


def test_scale_of_what_is_transparent_is_unknown():
    pixels = [[[128, 128, 128, 0], [128, 128, 128, 255]]]
    assert from_pixels(pixels, 0.65, 0.196, mode="scale")[0].tolist()[0] == -1
    assert from_pixels(pixels, 0.65, 0.196, mode="scale")[0].tolist()[1] > 0


def test_raw_is_the_mean_as_a_signed_byte():
    cells = from_pixels([[[0, 3, 6], [200, 200, 200]]], 0.65, 0.196, mode="raw")
    assert cells.tolist() == [[3, 200 - 256]]


def test_colours_are_averaged_and_alpha_counts_in_trinary_mode():
    assert from_pixels([[[0, 0, 255]]], 0.65, 0.196)[0, 0] == 100  # darkness 0.667
    assert from_pixels([[[0, 0, 0, 255]]], 0.65, 0.196)[0, 0] == 100  # 0.75
    assert from_pixels([[[0, 0, 0, 255]]], 0.76, 0.196)[0, 0] == -1


def test_row_0_is_the_lowest():
    assert from_pixels([[0, 0], [255, 205]], 0.65, 0.196).tolist() == [[0, -1], [100, 100]]


def test_drawing_is_the_way_back():
    rng = np.random.default_rng(3)
    cells = rng.choice(np.array([-1, 0, 100], np.int8), size=(7, 5))
    assert (from_pixels(to_pixels(cells), 0.65, 0.196) == cells).all()


@pytest.mark.parametrize(
    "cell, pixel", [(-1, 205), (0, 254), (25, 254), (26, 205), (64, 205), (65, 0), (100, 0)]
)
def test_thresholds_of_drawing(cell, pixel):
    assert to_pixels(np.array([[cell]], np.int8))[0, 0] == pixel
