"""Lens distortion: the picture agrees with OpenCV's model, and with camera_info."""

import math
from dataclasses import replace

import cv2
import numpy as np
import pytest
from bullet_sim.description.model import Geometry, Shape, VisualLink
from bullet_sim.description.world import Scene
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.plugins.cameras import CameraSpec, Lens
from bullet_sim.pose import Pose
from bullet_sim.render.gl.renderer import GlRenderer
from bullet_sim.render.request import CameraRequest, Quality
from bullet_sim.sensors import camera
from bullet_sim.snapshot import BodySource, Snapshot

LENSES = [
    (-0.25, 0.05, 0.001, -0.002, 0.0),
    (0.2, -0.03, 0.0, 0.0, 0.01),
    (-0.3, 0.1, 0.0, 0.0, 0.0),
]
SIZE, FOV = (320, 240), 1.3


@pytest.fixture(name="gl", scope="module")
def _gl():
    renderer = GlRenderer(Quality("false", "false"))
    yield renderer
    renderer.close()


def marks():
    """Small balls 4 m ahead, (n, 3) in the camera frame."""
    across = np.linspace(-2.2, 2.2, 7)
    up = np.linspace(-1.5, 1.5, 5)
    return np.array([(4.0, y, z) for y in across for z in up])


@pytest.mark.parametrize("lens", LENSES)
def test_marks_are_where_opencv_projects_them(gl, lens):
    balls = [
        Shape(Geometry("sphere", (0.05,)), Pose(tuple(map(float, place))), (1.0, 1.0, 1.0, 1.0))
        for place in marks()
    ]
    dark = Scene(ambient=(1.0,) * 3, background=(0.0,) * 3, lights=())
    gl.sync_sources([BodySource(1, "", True, (VisualLink(shapes=tuple(balls)),))], dark)
    asked = CameraRequest("c", None, 0, ((0, 0, 0), (0, 0, 0)), *SIZE, FOV, 0.1, 20.0)
    gl.apply(Snapshot(0.0, 0, ()))
    rgb, depth = gl.render_with_depth(replace(asked, distortion=lens, depth=True))
    assert rgb.shape == (240, 320, 3) and depth.shape == (240, 320)
    count, _, _, centres = cv2.connectedComponentsWithStats((rgb[:, :, 0] > 100).astype(np.uint8))
    k = camera.intrinsics(*SIZE, FOV)
    optical = marks() @ camera.OPTICAL_FROM_CAMERA.T
    expected, _ = cv2.projectPoints(optical, np.zeros(3), np.zeros(3), k, np.array(lens))
    expected = expected[:, 0, :]
    inside = ((expected > 6) & (expected < np.array(SIZE) - 7)).all(axis=1)
    assert inside.sum() >= 15 and count - 1 >= inside.sum()
    gaps = np.linalg.norm(centres[1:, None] - expected[inside][None], axis=2).min(axis=0)
    assert gaps.max() < 0.5  # [px]
    u, v = np.rint(expected[inside]).astype(int).T
    assert np.abs(depth[v, u] - 3.95).max() < 0.03


def test_without_distortion_nothing_is_warped(gl):
    asked = CameraRequest("c", None, 0, ((0, 0, 0), (0, 0, 0)), *SIZE, FOV, 0.1, 20.0)
    plain = gl.render(asked)
    np.testing.assert_array_equal(plain, gl.render(replace(asked, distortion=())))


CAMERA = """<robot name="r"><link name="base"/><gazebo reference="base">
<sensor type="camera" name="c">
<update_rate>10</update_rate><camera><horizontal_fov>1</horizontal_fov>{camera}</camera>
<plugin name="p" filename="libgazebo_ros_camera.so">{plugin}</plugin></sensor></gazebo></robot>"""
BENT = (
    "<distortion><k1>-0.2</k1><k2>0.03</k2><k3>0.01</k3><p1>0.001</p1><p2>-0.002</p2></distortion>"
)


def spec_of(**parts):
    found = parse_urdf(CAMERA.format(**{"camera": "", "plugin": "", **parts}), str, "r")
    return found.sensors[0]


def test_distortion_of_a_description_and_its_camera_info():
    spec = spec_of(camera=BENT)
    assert spec.distortion == (-0.2, 0.03, 0.001, -0.002, 0.01)
    assert CameraRequest.from_spec(spec, 1, 0).distortion == spec.distortion
    d, k, _, p = camera.camera_info_arrays(320, 240, 1.0, spec.distortion)
    assert d.tolist() == list(spec.distortion) and p[0] == k[0]
    assert spec_of().distortion == () and CameraSpec("a", "l").distortion == ()
    by_plugin = "<distortionK1>-0.1</distortionK1><distortionT2>0.2</distortionT2>"
    assert spec_of(plugin=by_plugin).distortion == (-0.1, 0.0, 0.0, 0.2, 0.0)
    tiny = "".join(
        f"<distortion{name}>0.00000001</distortion{name}>" for name in ("K1", "K2", "T1")
    )
    assert spec_of(plugin=tiny).distortion == ()


RADIUS = {
    "equidistant": lambda theta: theta / (math.pi / 2.0),
    "stereographic": lambda theta: math.tan(theta / 2.0) / math.tan(math.pi / 4.0),
    "equisolid_angle": lambda theta: math.sin(theta / 2.0) / math.sin(math.pi / 4.0),
}
WIDE = """<robot name="r"><link name="base"/><gazebo reference="base">
<sensor type="wideanglecamera" name="c"><update_rate>10</update_rate><camera>
<horizontal_fov>3.1415926535</horizontal_fov><image><width>300</width><height>300</height></image>
<lens>{}</lens></camera>
<plugin name="p" filename="libgazebo_ros_camera.so"/></sensor></gazebo></robot>"""


@pytest.mark.parametrize("kind", RADIUS)
def test_a_wide_angle_lens_maps_angles_as_its_type_says(gl, kind):
    """Balls all around at up to 80 degrees from the axis, also across the cube's edges."""
    found = parse_urdf(WIDE.format(f"<type>{kind}</type>"), str, "r")
    assert found.warnings == []
    angles = [(theta, phi) for theta in (0.2, 0.7, 0.785, 1.1, 1.4) for phi in np.arange(0, 6, 0.9)]
    places = [
        (4 * math.cos(t), 4 * math.sin(t) * math.cos(p), 4 * math.sin(t) * math.sin(p))
        for t, p in angles
    ]
    balls = [Shape(Geometry("sphere", (0.08,)), Pose(place), (1.0,) * 4) for place in places]
    dark = Scene(ambient=(1.0,) * 3, background=(0.0,) * 3, lights=())
    gl.sync_sources([BodySource(1, "", True, (VisualLink(shapes=tuple(balls)),))], dark)
    gl.apply(Snapshot(0.0, 0, ()))
    request = replace(CameraRequest.from_spec(found.sensors[0], 1, 0), near=0.1)
    rgb = gl.render(request)
    _, _, _, centres = cv2.connectedComponentsWithStats((rgb[:, :, 0] > 100).astype(np.uint8))
    for (theta, phi), place in zip(angles, places):
        away = 150.0 * RADIUS[kind](theta)
        expected = 149.5 - away * np.array((math.cos(phi), math.sin(phi)))
        gap = np.linalg.norm(centres[1:] - expected, axis=1).min()
        assert gap < 1.0, (theta, phi, place)


def test_a_lens_sees_nothing_beyond_its_cutoff(gl):
    gl.sync_sources([], Scene(background=(1.0, 1.0, 1.0)))
    gl.apply(Snapshot(0.0, 0, ()))
    request = CameraRequest("c", None, 0, ((0, 0, 0), (0, 0, 0)), 200, 200, 1.0, 0.1, 20.0)
    rgb = gl.render(replace(request, lens=Lens(math.pi, cutoff=math.pi / 4)))[:, :, 0]
    radius = np.hypot(*(np.indices((200, 200)) - 99.5))
    assert (rgb[radius < 49] == 255).all() and (rgb[radius > 51] == 0).all()
    behind = gl.render(replace(request, lens=Lens(2 * math.pi)))  # a whole turn has no seam
    assert (behind[radius < 99] == 255).all()


def test_lenses_of_descriptions():
    def lens_of(text):
        found = parse_urdf(WIDE.format(text), str, "r")
        return found.sensors[0].lens, found.warnings

    assert lens_of("") == (Lens(3.1415926535, 2.0, 2.0, 0.0, 1.0, "tan"), [])
    custom = "<type>custom</type><custom_function><c1>1.05</c1><c2>4</c2><f>1.0</f><fun>tan</fun>"
    lens, warnings = lens_of(f"{custom}</custom_function><scale_to_hfov>false</scale_to_hfov>")
    assert lens == Lens(3.1415926535, 1.05, 4.0, 0.0, 1.0, "tan", False) and not warnings
    lens, warnings = lens_of("<type>gnomonical</type>")  # a pinhole of 180 degrees
    assert lens == Lens(3.1415926535) and "shows nothing" in warnings[0]
    lens, warnings = lens_of("<type>fish</type>")
    assert lens.c1 == 2.0 and "known are gnomonical" in warnings[0]
