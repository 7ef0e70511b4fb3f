"""The orbit camera and its projection, against hand-made cases."""

import math

import numpy as np
import pytest
from bullet_viewer.view import MAX_DISTANCE, MIN_DISTANCE, OrbitCamera, project, project_rays

FOV = math.radians(90.0)  # focal length = half the width


def test_it_looks_at_its_target():
    camera = OrbitCamera(target=(1.0, 2.0, 0.5), distance=3.0, yaw=0.7, pitch=0.4)
    forward = camera.rotation[:, 0]
    assert camera.position + 3.0 * forward == pytest.approx([1.0, 2.0, 0.5])
    assert camera.position[2] == pytest.approx(0.5 + 3.0 * math.sin(0.4))  # above: looks down
    pixels, depth = project([camera.target], camera.pose, FOV, 640, 480)
    assert pixels[0] == pytest.approx([320.0, 240.0])
    assert depth[0] == pytest.approx(3.0)


@pytest.mark.parametrize(
    "point, position",
    [
        ((2.0, 0.0, 0.0), (320.0, 240.0)),
        ((2.0, 1.0, 0.0), (160.0, 240.0)),  # left is left: focal 320 px * 1 m / 2 m
        ((2.0, 0.0, 1.0), (320.0, 80.0)),  # up is up
        ((2.0, -2.0, -1.0), (640.0, 400.0)),
    ],
)
def test_points_project_as_in_a_pinhole_camera(point, position):
    pixels, _ = project([point], ((0, 0, 0), (0, 0, 0)), FOV, 640, 480)
    assert pixels[0] == pytest.approx(position)


@pytest.mark.parametrize("drag", [(100.0, 0.0), (0.0, 50.0), (-30.0, 20.0)])
def test_orbiting_keeps_target_and_distance(drag):
    camera = OrbitCamera(target=(1.0, 0.0, 0.0), distance=2.0)
    before = camera.position
    camera.orbit(*drag)
    assert not np.allclose(camera.position, before)
    assert np.linalg.norm(camera.position - camera.target) == pytest.approx(2.0)
    assert camera.target == pytest.approx([1.0, 0.0, 0.0])


def test_dragging_to_the_right_moves_the_near_side_to_the_right():
    camera = OrbitCamera(distance=2.0, pitch=0.0)
    near = camera.position + 1.0 * camera.rotation[:, 0]  # between camera and target
    camera.orbit(40.0, 0.0)
    assert project([near], camera.pose, FOV, 640, 480)[0][0, 0] > 320.0


def test_it_never_turns_over():
    camera = OrbitCamera()
    for down in (10000.0, -30000.0):
        camera.orbit(0.0, down)
        assert abs(camera.pitch) < math.pi / 2.0
        assert camera.rotation[2, 2] > 0.0  # its up has an upward part


def test_shifting_makes_the_target_follow_the_pointer():
    camera = OrbitCamera(target=(0.0, 0.0, 0.0), distance=2.0, horizontal_fov=FOV)
    point = camera.target.copy()
    camera.pan(30.0, -20.0, 640)
    position = project([point], camera.pose, FOV, 640, 480)[0][0]
    assert position == pytest.approx([350.0, 220.0])


def test_zoom_has_limits():
    camera = OrbitCamera(distance=2.0)
    camera.zoom(1)
    assert MIN_DISTANCE < camera.distance < 2.0
    camera.zoom(1000)
    assert camera.distance == MIN_DISTANCE
    camera.zoom(-1000)
    assert camera.distance == MAX_DISTANCE
    near, far = camera.clip
    assert 0.0 < near < camera.distance < far


def test_rays_are_cut_where_they_pass_the_camera():
    camera = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    ends = [(4.0, 1.0, 0.0), (-4.0, 0.0, 0.0), (-4.0, -1.0, 0.0)]
    lines = project_rays((2.0, 0.0, 0.0), ends, camera, FOV, 640, 480, near=0.5)
    assert lines[0] == pytest.approx([320.0, 240.0, 240.0, 240.0])
    # the second runs through the camera itself; the third leaves the image on the right:
    # at depth 0.5 it is at a quarter of its length, 0.25 m to the right, 160 px of 320 px/unit
    assert lines[1] == pytest.approx([320.0, 240.0, 320.0, 240.0])
    assert lines[2] == pytest.approx([320.0, 240.0, 480.0, 240.0])


def test_rays_behind_the_camera_are_not_projected():
    camera = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    assert project_rays((-1.0, 0.0, 0.0), [(-2.0, 0.0, 0.0)], camera, FOV, 64, 48).shape == (0, 4)
