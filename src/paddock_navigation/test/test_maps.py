"""Maps of worlds, worlds of maps, and files that are no maps."""

import math
import sys

import numpy as np
import pytest
import yaml
from paddock_navigation.grid import FREE, OCCUPIED, UNKNOWN, Grid, MapError, load

from paddock_navigation import cli, walls

ROOM = """<sdf version="1.6"><world name="room"><include><uri>model://ground_plane</uri></include>
{}</world></sdf>"""
BOX = """<model name="{0}"><static>true</static><pose>{1} {2} 0.5 0 0 {3}</pose><link name="l">
<collision name="c"><geometry><box><size>{4} {5} 1</size></box></geometry></collision></link>
</model>"""
WALLS = [
    ("n", 0, 2, 0, 4, 0.2),
    ("s", 0, -2, 0, 4, 0.2),
    ("e", 2, 0, 0, 0.2, 4),
    ("w", -2, 0, 0, 0.2, 4),
]


@pytest.fixture
def room(tmp_path):
    """Path of a world: a closed room of 3.8 m with a box that is turned, another one outside."""
    things = [*WALLS, ("box", 0.8, 0.5, 0.6, 0.5, 0.3), ("outside", 5, 0, 0, 1, 1)]
    path = tmp_path / "room.world"
    path.write_text(ROOM.format("".join(BOX.format(*thing) for thing in things)))
    return path


def at(grid, x, y):
    """The cell at a place."""
    column, row = ((np.array([x, y]) - grid.origin) / grid.resolution).astype(int)
    return grid.cells[row, column]


def test_a_room_seen_from_within(room, tmp_path):
    settings = cli.Settings(0.2, 0.05)
    said = cli.make_map([str(room)], settings, str(tmp_path / "map"))
    assert said.startswith(f"{tmp_path}/map.yaml: ")
    grid = load(str(tmp_path / "map.yaml"))
    places = {
        (0, 0): FREE,
        (-1.85, -1.85): FREE,
        (1.5, 0.5): FREE,
        (0.8, 0.5): UNKNOWN,
        (2.5, 0): UNKNOWN,
    }
    for place, cell in places.items():
        assert at(grid, *place) == cell, place
    y = np.arange(-1.85, 1.85, 0.02)
    for x in (-1.92, 1.92):  # the surfaces have no gaps
        assert all(at(grid, x, each) == OCCUPIED for each in y)
    area = (grid.cells == FREE).sum() * grid.resolution**2
    assert math.isclose(area, 3.8**2 - 0.5 * 0.3, rel_tol=0.05)


def test_above_all_is_free_and_outside_is_another_start(room, tmp_path):
    cli.make_map([str(room)], cli.Settings(1.2, 0.1, size=8.0), str(tmp_path / "map"))
    assert not (load(str(tmp_path / "map.yaml")).cells == OCCUPIED).any()
    cli.make_map([str(room)], cli.Settings(0.2, 0.1, (3.0, 0.0), 10.0), str(tmp_path / "map"))
    grid = load(str(tmp_path / "map.yaml"))
    assert (at(grid, 0, 0), at(grid, 3, 0), at(grid, 4.55, 0)) == (UNKNOWN, FREE, OCCUPIED)


def test_a_start_within_something_is_refused(room, tmp_path):
    with pytest.raises(MapError, match=r"the start \(2.0, 0.0\) at the height of 0.2 m is no free"):
        cli.make_map([str(room)], cli.Settings(0.2, 0.05, (2.0, 0.0)), str(tmp_path / "map"))


def test_robots_of_a_launch_file_are_left_out(tmp_path):
    words = ["cybertruck", "truck.launch", "trailer:=true"]
    cli.make_map(words, cli.Settings(0.3, 0.1), str(tmp_path / "map"))
    grid = load(str(tmp_path / "map.yaml"))
    assert at(grid, 0, 0) == at(grid, -1, 0) == FREE and (grid.cells == OCCUPIED).sum() > 500


def test_a_map_becomes_a_world_with_the_same_map(room, tmp_path):
    base = str(tmp_path / "map")
    cli.make_map([str(room)], cli.Settings(0.2, 0.05), base)
    said = cli.make_world(f"{base}.yaml", 0.5, base)
    assert said.startswith(f"{base}.world: walls of ")
    cli.make_map([f"{base}.world"], cli.Settings(0.2, 0.05), str(tmp_path / "again"))
    first, second = (load(str(tmp_path / f"{name}.yaml")) for name in ("map", "again"))
    for x in np.arange(-1.8, 1.8, 0.07):
        for y in np.arange(-1.8, 1.8, 0.07):
            if at(first, x, y) != UNKNOWN:
                near = [
                    at(second, x + a, y + b) for a in (-0.05, 0, 0.05) for b in (-0.05, 0, 0.05)
                ]
                assert at(first, x, y) in near, (x, y)


def test_the_command_takes_numbers(room, tmp_path, monkeypatch, capsys):
    out = ["--resolution", "0.1", "--size", "8", "--out", str(tmp_path / "map.yaml")]
    for word, more, said in (
        (room, ["--height", "0.2", "--start", "3", "0"], "cells of 0.1 m"),
        (tmp_path / "map.yaml", ["--height", "0.5"], "0.5 m high"),
    ):
        monkeypatch.setattr(sys, "argv", ["map", str(word), *more, *out])
        assert cli.main() == 0
        assert said in capsys.readouterr().out
    monkeypatch.setattr(sys, "argv", ["map", str(tmp_path / "none.yaml"), "--height", "1", *out])
    assert cli.main() == 1
    assert "none.yaml" in capsys.readouterr().err


def test_rectangles_cover_each_cell_once():
    occupied = np.random.default_rng(3).random((30, 40)) < 0.6
    count = np.zeros(occupied.shape, int)
    for top, left, bottom, right in walls.rectangles(occupied):
        count[top:bottom, left:right] += 1
    assert (count == occupied).all()
    assert walls.rectangles(np.ones((4, 5), bool)) == [(0, 0, 4, 5)]
    assert walls.rectangles(np.zeros((4, 5), bool)) == []


def test_where_the_walls_of_a_turned_map_are():
    text = walls.world(Grid(np.array([[0, 100, 100]], np.int8), 0.5, (1.0, -2.0), 0.3), 0.8)
    assert "<pose>1 -2 0 0 0 0.3</pose>" in text
    assert "<pose>1 0.25 0.4 0 0 0</pose><geometry><box><size>1 0.5 0.8</size>" in text


def test_a_grid_survives_its_files(tmp_path):
    cells = np.array([[0, 100, -1], [100, 0, 0]], np.int8)
    Grid(cells, 0.1, (1.0, 2.0), 0.5).save(str(tmp_path / "map"))
    again = load(str(tmp_path / "map.yaml"))
    assert (again.cells == cells).all()
    assert (again.resolution, again.origin, again.yaw) == (0.1, (1.0, 2.0), 0.5)
    assert (tmp_path / "map.pgm").read_bytes() == b"P5\n3 2\n255\n" + bytes(
        [0, 254, 254, 254, 0, 205]
    )


@pytest.mark.parametrize(
    "changes, message",
    [
        ({"resolution": 0}, "resolution is 0.0, must be above 0"),
        ({"resolution": "fine"}, "resolution is 'fine', must be a number"),
        ({"origin": [0, 0]}, r"origin is \[0, 0\], must be \[x, y, yaw\]"),
        ({"origin": [0, 0, float("nan")]}, "origin is"),
        ({"image": "none.pgm"}, "image is 'none.pgm', which is no image"),
        ({"free_thresh": None}, "free_thresh is None, must be a number"),
    ],
)
def test_maps_that_are_none(tmp_path, changes, message):
    Grid(np.zeros((2, 2), np.int8), 0.1, (0.0, 0.0)).save(str(tmp_path / "map"))
    path = tmp_path / "map.yaml"
    path.write_text(yaml.safe_dump({**yaml.safe_load(path.read_text()), **changes}))
    with pytest.raises(MapError, match=message):
        load(str(path))


@pytest.mark.parametrize("text", ["- a list", "a: [", "", "\x00"])
def test_files_that_are_no_maps(tmp_path, text):
    path = tmp_path / "map.yaml"
    path.write_text(text)
    with pytest.raises(MapError, match=str(path)):
        load(str(path))


def test_negated_and_coloured_images(tmp_path):
    import cv2

    cv2.imwrite(str(tmp_path / "map.png"), np.array([[[255] * 3, [0] * 3, [150] * 3]], np.uint8))
    path = tmp_path / "map.yaml"
    path.write_text("image: map.png\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 1\n")
    assert load(str(path)).cells.tolist() == [[OCCUPIED, FREE, UNKNOWN]]
