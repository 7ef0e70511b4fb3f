"""Projection to the ground, line detection, and the drivers' commands."""

import math

import cv2
import numpy as np
import pytest
from deepracer_control.drivers.commands import Units
from deepracer_control.drivers.follow_line import LineFollower
from deepracer_control.drivers.line_vision import LineVision, Mount, ground_points
from deepracer_control.drivers.pursuit import Path, Pursuit, arc_curvature

WIDTH, HEIGHT, FOV = 320, 240, 1.13
FOCAL = WIDTH / 2.0 / math.tan(FOV / 2.0)
MATRIX = (FOCAL, 0, WIDTH / 2.0, 0, FOCAL, HEIGHT / 2.0, 0, 0, 1)
ORANGE, WHITE, ASPHALT, GRASS = (20, 140, 245), (240, 242, 242), (56, 53, 52), (58, 122, 52)


def render(curvature, side=0.0, half_lane=0.38, orange=True):
    """Returns the camera image of a lane of constant curvature [1/m], its line `side` m left."""
    ground = ground_points(WIDTH, HEIGHT, MATRIX, Mount())
    x, y = ground[:, :, 0], ground[:, :, 1]
    if curvature:
        radius = 1.0 / curvature
        off = np.sign(radius) * (abs(radius) - np.hypot(x, y - side - radius))
        along = np.arctan2(x, np.sign(radius) * (radius + side - y)) * abs(radius)
    else:
        off, along = y - side, x
    image = np.full((HEIGHT, WIDTH, 3), (235, 200, 150), np.uint8)
    on_ground = np.isfinite(x)
    for color, where in (
        (GRASS, on_ground),
        (WHITE, abs(off) < half_lane),
        (ASPHALT, abs(off) < half_lane - 0.03),
        (ORANGE, (abs(off) < 0.0125) & (along % 0.25 < 0.15) & orange),
    ):
        image[on_ground & where] = color
    return cv2.GaussianBlur(image, (3, 3), 0)


def test_ground_points_invert_the_projection():
    mount = Mount(ahead=0.2, height=0.15, pitch=0.3)
    ground = ground_points(WIDTH, HEIGHT, MATRIX, mount)
    for row, column in ((120, 160), (200, 10), (239, 319)):
        x, y = ground[row, column]
        ahead, down = x - mount.ahead, mount.height
        depth = ahead * math.cos(mount.pitch) + down * math.sin(mount.pitch)
        below = down * math.cos(mount.pitch) - ahead * math.sin(mount.pitch)
        assert FOCAL * -y / depth + WIDTH / 2 == pytest.approx(column + 0.5, abs=1e-6)
        assert FOCAL * below / depth + HEIGHT / 2 == pytest.approx(row + 0.5, abs=1e-6)
    assert np.isnan(ground[0]).all()  # 25 degrees above the axis is above the horizon


@pytest.mark.parametrize("curvature", [-1.0, -0.5, 0.0, 0.5, 1.0])
def test_curvature_of_the_line(curvature):
    vision = LineVision()
    for _ in range(3):
        goal = vision.find_goal(render(curvature), MATRIX)
    assert arc_curvature(*goal) == pytest.approx(curvature, abs=0.08)
    assert 0.45 < math.hypot(*goal) < 0.7


@pytest.mark.parametrize("side", [-0.15, 0.15])
def test_steers_back_to_the_line(side):
    goal = LineVision().find_goal(render(0.0, side), MATRIX)
    assert goal[1] == pytest.approx(side, abs=0.02)


@pytest.mark.parametrize("curvature", [-2.0, 2.0])
def test_hairpin_by_the_border_alone(curvature):
    vision = LineVision()
    for k in (0.5, 1.0, 1.4, 1.7):
        vision.find_goal(render(math.copysign(k, curvature)), MATRIX)
    for _ in range(4):
        goal = vision.find_goal(render(curvature, orange=False), MATRIX)
    assert arc_curvature(*goal) == pytest.approx(curvature, rel=0.25)


def test_no_line_detected():
    grass = np.full((HEIGHT, WIDTH, 3), GRASS, np.uint8)
    follower = LineFollower(LineVision(), timeout=1.0)
    assert follower.command(0.0, grass, MATRIX) == (0.0, 0.0)
    speed, curvature = follower.command(1.0, render(0.8), MATRIX)
    assert speed > 0.1 and curvature > 0.5
    assert follower.command(1.9, grass, MATRIX) == (speed, curvature)
    assert follower.command(2.1, grass, MATRIX) == (0.0, 0.0)
    assert follower.command(0.5, grass, MATRIX) == (0.0, 0.0)  # the clock jumped back


def test_slower_in_bends():
    follower = LineFollower(LineVision(), speed=1.0, grip=0.5)
    straight, bend = (follower.command(t, render(k), MATRIX)[0] for t, k in ((0, 0.0), (1, 1.0)))
    assert straight == 1.0
    assert bend == pytest.approx(math.sqrt(0.5), rel=0.15)


def circle(radius=1.5, count=200):
    at = 2.0 * np.pi * np.arange(count + 1) / count
    return radius * np.stack([np.sin(at), 1.0 - np.cos(at)], axis=1)


def test_pursuit_on_a_circle_returns_its_curvature():
    pursuit = Pursuit(Path(circle()), max_speed=3.0, max_lateral_acceleration=1.5)
    for angle in np.linspace(0.0, 6.2, 30):
        x, y = 1.5 * math.sin(angle), 1.5 * (1.0 - math.cos(angle))
        speed, curvature = pursuit.command(x, y, angle)
        assert curvature == pytest.approx(1.0 / 1.5, rel=0.03)
        assert speed == pytest.approx(1.5, rel=0.03)  # v^2 / R = 1.5 m/s^2


def test_positions_on_a_circuit():
    path = Path(circle(2.0)[:-1], closed=True)
    assert path.closed and path.length == pytest.approx(4.0 * math.pi, rel=1e-3)
    quarter = path.nearest(2.3, 2.0)
    assert path.distance(2.3, 2.0) == pytest.approx(0.3, abs=1e-3)
    assert path.arc_length(0, quarter) == pytest.approx(math.pi, rel=2e-2)
    assert path.arc_length(quarter, 0) == pytest.approx(3.0 * math.pi, rel=2e-2)
    assert Path([(0, 0), (1, 0), (2, 0)]).arc_length(75, 50) == pytest.approx(-0.5)


def test_open_path_ends_with_a_stop():
    pursuit = Pursuit(Path([(0, 0), (1, 0), (2, 0)]))
    assert pursuit.command(1.0, 0.1, 0.0)[0] == 1.0
    assert pursuit.command(1.0, 0.1, 0.0)[1] < 0.0
    assert pursuit.command(1.99, 0.0, 0.0) == (0.0, 0.0)


@pytest.mark.parametrize(
    "points", [[(0, 0), (1, 0)], [(0, 0)] * 5, [(0, 0), (1, float("nan")), (2, 0)]]
)
def test_invalid_paths(points):
    with pytest.raises(ValueError, match="path"):
        Path(points)


@pytest.mark.parametrize("limit", ["lookahead", "max_speed", "max_lateral_acceleration"])
@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), "fast", True])
def test_invalid_limits(limit, value):
    with pytest.raises(ValueError, match=limit):
        Pursuit(Path(circle()), **{limit: value})


def test_units_of_both_modes():
    twist = Units("ackermann").twist(0.5, 1.2)
    assert (twist.linear.x, twist.angular.z) == pytest.approx((0.5, 0.6))
    twist = Units("original").twist(0.3, 1.2)
    assert twist.linear.x == pytest.approx(10.0)
    assert twist.angular.z == pytest.approx(-math.degrees(math.atan(0.164 * 1.2)) / 15.0)
    assert Units().twist(0.5, 50.0).angular.z == pytest.approx(0.5 * math.tan(0.5236) / 0.164)
    with pytest.raises(ValueError, match="mode"):
        Units("metric")
