"""The sky's colors: Gazebo 11's of a world with an empty <sky>, the sun's way, time of day."""

import numpy as np
import pytest
from bullet_sim.description.world import Scene
from bullet_sim.pose import Pose
from bullet_sim.render.gl import sky
from bullet_sim.render.gl.renderer import GlRenderer
from bullet_sim.render.request import CameraRequest, Quality
from bullet_sim.snapshot import Snapshot

# Azimuth and elevation [degrees] -> what a camera of Gazebo 11.1 showed there: the upper edge of
# the image of a public world.
GAZEBO = {
    (30.3, 10.2): (162, 178, 221),
    (23.6, 10.8): (158, 174, 219),
    (16.3, 11.3): (154, 170, 216),
    (8.3, 11.7): (151, 167, 214),
    (-0.1, 11.8): (149, 165, 212),
    (-8.4, 11.7): (149, 165, 212),
    (-16.4, 11.3): (150, 166, 212),
    (-23.7, 10.8): (152, 168, 213),
}


def towards(azimuth, elevation):
    a, e = np.radians((azimuth, elevation))
    return np.array((np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)))


def test_colors_are_those_of_gazebo():
    directions = np.array([towards(*place) for place in GAZEBO])
    found = sky.colors(directions, Scene.daytime).astype(int)
    assert np.abs(found - np.array(list(GAZEBO.values()))).max() <= 1


@pytest.mark.parametrize(
    "daytime, direction",
    [
        ((6.0, 6.0, 20.0), (0.0, 1.0, 0.0)),
        ((13.0, 6.0, 20.0), (0.0, 0.0, 1.0)),
        ((20.0, 6.0, 20.0), (0.0, -1.0, 0.0)),
        ((1.0, 6.0, 20.0), (0.0, 0.0, -1.0)),
        ((10.0, 6.0, 20.0), (0.0, np.cos(np.pi * 2 / 7), np.sin(np.pi * 2 / 7))),
    ],
)
def test_the_sun_rises_at_y_and_sets_opposite(daytime, direction):
    np.testing.assert_allclose(sky.sun_direction(daytime), direction, atol=1e-9)


def test_day_and_night():
    ahead = towards(0.0, 10.0)[None]
    noon, night = (sky.colors(ahead, (hour, 6.0, 20.0)).astype(int) for hour in (13.0, 0.0))
    assert noon.min() > 120 and night.max() < 40 and night[0, 2] > night[0, 0]
    assert np.isfinite(sky.colors(-ahead, (5.0, 12.0, 12.0))).all()


def test_below_the_horizon_it_fades_into_the_background():
    assert sky.colors(towards(40.0, -14.0)[None], Scene.daytime).tolist() == [[178] * 3]
    low, level = (sky.colors(towards(0.0, e), Scene.daytime).astype(int) for e in (-1.0, 0.0))
    assert np.abs(low - level).max() < 12


@pytest.mark.parametrize("rpy", [(0, 0, 0), (0.3, -1.2, 2.5), (0, 0.1, -2.0), (0, -0.9, 1.57)])
def test_each_pixel_has_the_color_of_its_direction(rpy):
    renderer = GlRenderer(Quality("false", "false"))
    try:
        renderer.sync_sources([], Scene(background=None))
        renderer.apply(Snapshot(0.0, 0, ()))
        asked = CameraRequest("eye", None, 0, ((9, 9, 9), rpy), 160, 120, 1.2, 0.05, 100.0)
        shown = renderer.render(asked).astype(int)
    finally:
        renderer.close()
    f = 80.0 / np.tan(0.6)
    u, v = np.meshgrid(np.arange(160) + 0.5 - 80.0, np.arange(120) + 0.5 - 60.0)
    directions = np.stack([np.full_like(u, f), -u, -v], axis=-1)
    directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
    place = Pose.from_xyz_rpy((0.0, 0.0, 0.0), tuple(map(float, rpy)))
    exact = sky.colors(directions @ place.matrix.T, Scene.daytime).astype(int)
    assert np.percentile(np.abs(shown - exact), 99) <= 4 and np.abs(shown - exact).mean() < 0.5


def test_a_sky_follows_its_time():
    renderer = GlRenderer(Quality("false", "false"))
    asked = CameraRequest("eye", None, 0, ((0, 0, 0), (0, -0.5, 0)), 8, 6, 0.2, 0.05, 100.0)
    try:
        means = []
        for hour in (13.0, 1.0, 13.0):
            scene = Scene(background=None, daytime=(hour, 6.0, 20.0))
            renderer.sync_sources([], scene)
            renderer.apply(Snapshot(0.0, 0, ()))
            means.append(renderer.render(asked).mean())
    finally:
        renderer.close()
    assert means[0] == means[2] > 60.0 and means[1] < 10.0
