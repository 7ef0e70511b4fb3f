"""Track files: values that are read, error messages."""

import pytest

from track_model import curves, geometry, source, spec, track_file

SQUARE = "points: [[0, 0], [3, 0], [3, 3], [0, 3]]\n"


@pytest.mark.parametrize("name", ["default", "easy", "medium", "hard"])
def test_tracks_of_the_package(name):
    path = source.find(name)
    track = track_file.parse(source.read(path), path)
    curve = geometry.lane(track).curve
    size = curve.max(axis=0) - curve.min(axis=0) + track.width
    assert track.name == name and track.width >= 0.7
    assert size[0] <= 10.0 and size[1] <= 8.0
    assert abs(curves.radii(curve)).min() >= (0.44 if name == "hard" else 0.8)


def test_values_are_read():
    track = track_file.parse(
        SQUARE + "width: 0.5\nwalls: {enabled: true}\ncolours: {grass: [1, 2, 3]}\n"
        "friction: 2\nstart_line: false",
        "some/where/mine.yaml",
    )
    assert (track.name, track.width, track.friction, track.start_line) == ("mine", 0.5, 2.0, False)
    assert track.walls == spec.WallSpec(True, 0.25, 0.03, 0.15)
    assert track.colors["grass"] == (1, 2, 3) and track.colors["border"] == (242, 242, 240)


def test_repeated_first_point_closes():
    assert (
        len(track_file.parse("points: [[0, 0], [3, 0], [3, 3], [0, 3], [0, 0]]", "a").points) == 4
    )


@pytest.mark.parametrize(
    "text, expected",
    [
        ("", ["content", "mapping"]),
        ("[1, 2]", ["content", "mapping"]),
        ("points: [", ["not YAML"]),
        ("width: 1.0", ["points", "missing"]),
        (SQUARE + "widht: 1", ["'widht'", "width"]),
        (SQUARE + "walls: {hight: 1}", ["walls key", "'hight'", "height"]),
        (SQUARE + "walls: 3", ["walls", "mapping"]),
        (SQUARE + "walls: {enabled: 1}", ["walls.enabled", "true or false"]),
        (SQUARE + "walls: {height: -1}", ["walls.height", "0.02 to 3"]),
        (SQUARE + "colours: {sky: [1, 2, 3]}", ["colours key", "'sky'", "grass"]),
        (SQUARE + "colours: {grass: [1, 2, 300]}", ["colours.grass", "0 to 255"]),
        (SQUARE + "width: wide", ["width", "'wide'", "a number"]),
        (SQUARE + "width: true", ["width", "True", "a number"]),
        (SQUARE + "width: .nan", ["width", "nan", "finite"]),
        (SQUARE + "width: 9", ["width", "9", "0.3 to 3"]),
        (SQUARE + "width: 0.3\nborder_width: 0.15", ["width", "borders"]),
        (SQUARE + "seed: -1", ["seed", "-1"]),
        (SQUARE + "seed: 1.5", ["seed", "1.5", "whole"]),
        (SQUARE + "width: [1, 1]", ["width", "2 numbers", "one per point (4)"]),
        (SQUARE + "width: [1, 1, 9, 1]", ["width", "9", "0.3 to 3"]),
        (SQUARE + "description: 3", ["description", "text"]),
        ("points: 3", ["points", "list"]),
        ("points: [[0, 0], [1, 0]]", ["points", "2 distinct", "at least 3"]),
        ("points: [[0, 0], [1, 0], [0, 0]]", ["points", "2 distinct", "at least 3"]),
        ("points: [[0, 0], [1, 0, 2], [1, 1]]", ["points[1]", "[1, 0, 2]", "pair"]),
        ("points: [[0, 0], [1, .inf], [1, 1]]", ["points[1]", "inf", "finite"]),
        ("points: [[0, 0], [1, a], [1, 1]]", ["points[1]", "'a'", "number"]),
        ("points: [[0, 0], [1, 999], [1, 1]]", ["points[1]", "999", "50"]),
        ("points: [[0, 0], [0, 0], [1, 1], [2, 0]]", ["points[1]", "previous point"]),
    ],
)
def test_errors_in_the_file(text, expected):
    with pytest.raises(spec.TrackError) as caught:
        track_file.parse(text, "file.yaml")
    message = str(caught.value)
    assert isinstance(caught.value, ValueError) and message.startswith("file.yaml: ")
    assert "\n" not in message
    for word in [*expected, "valid:"]:
        assert word in message


@pytest.mark.parametrize(
    "text, expected",
    [
        ("points: [[0, 0], [4, 4], [4, 0], [0, 4]]", ["crosses itself", "near"]),
        ("points: [[0, 0], [0.5, 0], [0.5, 0.5], [0, 0.5]]", ["bend of radius", "near"]),
        (
            "points: [[0,0],[4,0],[8,0],[9,1.5],[8,3],[6,3],[4.5,1],[3.5,1],[2,3],[0,3],[-1,1.5]]\n"
            "width: 1.1",
            ["overlaps itself", "1.10 m"],
        ),
        (SQUARE + "start_distance: 50", ["start_distance", "50", "length"]),
    ],
)
def test_errors_in_the_geometry(text, expected):
    with pytest.raises(spec.TrackError) as caught:
        geometry.lane(track_file.parse(text, "file.yaml"))
    for word in ["file.yaml", "valid:", *expected]:
        assert word in str(caught.value)


def test_unknown_track_names_the_known_ones():
    with pytest.raises(spec.TrackError, match="default, easy, hard, medium"):
        source.find("nurburgring")


def test_a_file_that_cannot_be_read_is_told_with_the_systems_reason():
    wanted = "/no/such.yaml: file is No such file or directory; valid: a readable track file"
    with pytest.raises(spec.TrackError, match=wanted):
        source.read("/no/such.yaml")
