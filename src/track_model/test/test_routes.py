"""Routes of other projects: their formats, tracks made from them, error messages."""

import io
import xml.etree.ElementTree as ET

import numpy as np
import pytest

from track_model import curves, geometry, region, source, spec, track


def wavy(count, seed, closed=True, scale=3.0):
    """Return center (N, 2) and half widths (N,) of a random smooth course [m]."""
    rng = np.random.default_rng(seed)
    at = np.linspace(0.0, 2.0 * np.pi if closed else 1.5 * np.pi, count, endpoint=not closed)
    radius = scale * np.ones(count)
    for k in range(2, 5):
        radius += scale * 0.25 / k**1.5 * rng.uniform(-1, 1) * np.sin(k * at + rng.uniform(0, 6))
    half = 0.4 + 0.1 * np.sin(3.0 * at + rng.uniform(0, 6))
    return radius[:, None] * np.stack([np.cos(at), np.sin(at)], axis=1), half


def deepracer(center, half, clockwise=False):
    """Return the N x 6 array of a counter-clockwise course, the inner edge on its left."""
    ahead = np.gradient(center, axis=0)
    left = ahead[:, ::-1] * (-1.0, 1.0) / np.linalg.norm(ahead, axis=1)[:, None]
    array = np.hstack([center, center + half[:, None] * left, center - half[:, None] * left])
    return array[::-1] if clockwise else array


def npy(array):
    stream = io.BytesIO()
    np.save(stream, array)
    return stream.getvalue()


def community(number):
    """Ten route files as they occur: repeated points, the first again, open, other widths."""
    closed = number % 3 != 2
    center, half = wavy(60 + 17 * number, number, closed)
    array = deepracer(center, half, clockwise=number % 2 == 1)
    if closed and number % 2 == 0:
        array = np.vstack([array, array[:1]])
    if number % 4 == 1:
        array = np.repeat(array, 1 + (np.arange(len(array)) % 9 == 0), axis=0)
    return array, closed


@pytest.mark.parametrize("number", range(10))
def test_community_routes_become_tracks(number, tmp_path):
    array, closed = community(number)
    path = tmp_path / "route.npy"
    path.write_bytes(npy(array))
    loaded = track.load_track(str(path))
    assert loaded.closed == closed
    assert loaded.centreline[0] == pytest.approx((0, 0), abs=1e-9)
    assert curves.tangents(loaded.centreline, closed)[0] == pytest.approx((1, 0), abs=1e-9)
    x, y, yaw = loaded.lane.origin
    rotation = np.array(((np.cos(yaw), -np.sin(yaw)), (np.sin(yaw), np.cos(yaw))))
    there = loaded.centreline @ rotation.T + (x, y)
    for points, line in (
        (array[:, :2], there),
        (
            np.vstack([array[:, 2:4], array[:, 4:6]]),
            np.vstack([loaded.inner, loaded.outer]) @ rotation.T + (x, y),
        ),
    ):
        off = np.linalg.norm(points[:, None] - line[None], axis=2).min(axis=1)
        assert off.max() < 0.03  # [m]: 2 cm samples, edges are perpendicular to the spline
    model = ET.parse(loaded.directory + "/track.sdf").getroot().find("model")
    assert model.find(".//mesh/uri").text.endswith("track.obj")


def test_sides_follow_the_driving_direction():
    center, half = wavy(80, 1)
    array = deepracer(center, half)
    array[:, 2:4] = center + 0.5 * (array[:, 2:4] - center)  # inner edge half as far away
    for content, left in ((array, True), (array[::-1], False)):
        sides = np.array(source.load("a.npy", npy(content)).sides)
        assert (sides[:, 0] < sides[:, 1]).all() == left


def test_centreline_csv():
    center, half = wavy(100, 4, scale=20.0)
    rows = ["# x_m, y_m, w_tr_right_m, w_tr_left_m"]
    rows += ["{:.6f}, {:.6f}, {:.3f}, {:.3f}".format(*point, 1.1, 0.9) for point in center]
    lane = geometry.lane(source.load("a.csv", "\n".join(rows).encode()))
    assert lane.closed
    assert lane.left == pytest.approx(0.9) and lane.right == pytest.approx(1.1)
    assert lane.length == pytest.approx(curves.length(center), rel=2e-3)


def test_header_without_hash_and_semicolons():
    text = "x;y;right;left\n0;0;1;1\n9;0;1;1\n9;9;1;1\n0;9;1;1\n"
    loaded = source.load("a.csv", text.encode())
    assert loaded.points == ((0, 0), (9, 0), (9, 9), (0, 9)) and not loaded.closed


GOOD = deepracer(*wavy(40, 0))


def changed(row, column, value):
    array = GOOD.copy()
    array[row, column] = value
    return array


@pytest.mark.parametrize(
    "name, content, texts",
    [
        ("a.npy", b"nonsense", ["content", "not an array file", ".npy"]),
        ("a.npy", b"", ["content", "not an array file"]),
        ("a.npy", npy(GOOD[:, :4]), ["(40, 4)", "N x 6"]),
        ("a.npy", npy(GOOD.ravel()), ["(240,)", "N x 6"]),
        ("a.npy", npy(GOOD.astype(str)), ["N x 6"]),
        ("a.npy", npy(changed(7, 3, np.nan)), ["row 7, column 3", "nan", "finite"]),
        ("a.npy", npy(changed(2, 0, 1e6)), ["row 2", "500 m"]),
        ("a.npy", npy(np.zeros((0, 6))), ["0 points", "at least 3"]),
        ("a.npy", npy(np.repeat(GOOD[:2], 9, axis=0)), ["2 distinct points", "at least 3"]),
        ("a.npy", npy(np.hstack([GOOD[:, :2]] * 3)), ["width near point", "0.2 m"]),
        ("a.csv", b"\xff\xfe\xfa", ["not text"]),
        ("a.csv", b"# only\n", ["no rows"]),
        ("a.csv", b"0, 0, 1, 1\n1, 0, 1\n", ["line 2", "3 columns", "4: x, y"]),
        ("a.csv", b"0, 0, 1, 1\n1, b, 1, 1\n", ["line 2", "'1, b, 1, 1'", "numbers"]),
        ("a.csv", b"0, 0, 1, 1\n1, 0, inf, 1\n2, 1, 1, 1", ["row 1, column 2", "inf"]),
        ("a.csv", b"0, 0, 1, 1\n1, 0, -3, 1\n2, 1, 1, 1", ["width near point 1", "-2"]),
    ],
)
def test_invalid_routes(name, content, texts):
    with pytest.raises(spec.TrackError) as caught:
        source.load(name, content)
    assert "\n" not in str(caught.value)
    for text in [name, "valid:", *texts]:
        assert text in str(caught.value)


def test_self_crossing_route():
    at = np.linspace(0.0, 2.0 * np.pi, 80, endpoint=False)
    eight = 4.0 * np.stack([np.sin(at), np.sin(at) * np.cos(at)], axis=1)
    with pytest.raises(spec.TrackError, match="crosses itself"):
        geometry.lane(source.load("a.npy", npy(deepracer(eight, 0.3 * np.ones(80)))))


@pytest.mark.parametrize("angle", [0.0, 0.3])
@pytest.mark.parametrize("count", [8, 9, 40])
def test_a_crossing_at_a_point_of_the_curve_is_one(angle, count):
    at = 2.0 * np.pi * np.arange(count) / count
    eight = np.stack([np.sin(at), np.sin(at) * np.cos(at)], axis=1)
    eight[np.hypot(*eight.T) < 1e-9] = 0.0  # both ways through the same point
    eight = eight @ [[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]]
    assert curves.first_crossing(eight) is not None
    assert curves.first_crossing(np.roll(eight, 3, axis=0)[::-1]) is not None


@pytest.mark.parametrize("angle", [0.0, 0.3, 2.0])
def test_straight_parts_do_not_cross(angle):
    sides = [np.linspace(0.0, 3.0, 31)[:-1], np.full(30, 3.0)]
    square = np.vstack([np.stack(sides, 1), np.stack(sides[::-1], 1)])
    square = np.vstack([square, 3.0 - square])[:, ::-1]
    rotation = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    assert curves.first_crossing(square @ rotation) is None
    assert curves.first_crossing(square[:25] @ rotation, closed=False) is None


def test_folded_inner_edge_stays_a_lane():
    """A hairpin tighter than the inner half lane: the area is still one piece around the curve."""
    at = np.linspace(0.0, np.pi, 40)
    bend = 0.3 * np.stack([np.sin(at), -np.cos(at)], axis=1)
    lead = np.linspace(-2.0, -0.05, 30)
    center = np.vstack(
        [
            np.stack([lead, -0.3 * np.ones(30)], axis=1),
            bend,
            np.stack([lead[::-1], 0.3 * np.ones(30)], axis=1),
        ]
    )
    lane = geometry.lane(source.load("a.npy", npy(deepracer(center, 0.5 * np.ones(len(center))))))
    area = region.lane_area(lane)
    assert area.is_valid and area.geom_type == "Polygon" and not lane.closed
    assert region.inside(area)(lane.curve[5:-5]).all()
