"""Lens distortion by Gazebo's formula, what camera_info says of it, wide-angle lenses."""

import math
from dataclasses import replace

import cv2
import numpy as np
import pytest
from bullet_sim.description.model import Geometry, Shape, VisualLink
from bullet_sim.description.world import Scene
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.plugins.cameras import CameraSpec
from bullet_sim.pose import Pose
from bullet_sim.render.lenses import plan_distortion
from bullet_sim.render.request import CameraRequest, Distortion, Intrinsics, Lens
from bullet_sim.sensors import camera
from bullet_sim.snapshot import BodySource, Snapshot
from pinhole import OPTICAL_FROM_CAMERA, project

pytestmark = pytest.mark.usefixtures("sketches")
SHADOWS = "false"

LENSES = [
    Distortion(-0.3, 0.05, crop=True),
    Distortion(-0.3, 0.05),
    Distortion(0.25),
    Distortion(-0.2, p1=0.03, p2=-0.05, crop=True),
    Distortion(0.2, -0.1, 0.05, center=(0.4, 0.55)),
]
SIZE, FOV = (320, 240), 1.3


def marks():
    """Small balls 4 m ahead, (n, 3) in the camera frame."""
    across = np.linspace(-2.2, 2.2, 7)
    up = np.linspace(-1.5, 1.5, 5)
    return np.array([(4.0, y, z) for y in across for z in up])


def brown(x, y, lens):
    """Gazebo's formula for one point, in widths and heights of the image."""
    dx, dy = x - lens.center[0], y - lens.center[1]
    r2 = dx * dx + dy * dy
    radial = 1.0 + lens.k1 * r2 + lens.k2 * r2**2 + lens.k3 * r2**3
    return (
        lens.center[0] + dx * radial + 2 * lens.p1 * dx * dy + lens.p2 * (r2 + 2 * dx * dx),
        lens.center[1] + dy * radial + 2 * lens.p2 * dx * dy + lens.p1 * (r2 + 2 * dy * dy),
    )


@pytest.mark.parametrize("lens", LENSES)
def test_marks_are_where_gazebos_formula_puts_them(gl, lens):
    """Depths stay those of the pinhole."""
    balls = [
        Shape(Geometry("sphere", (0.05,)), Pose(tuple(map(float, place))), (1.0, 1.0, 1.0, 1.0))
        for place in marks()
    ]
    dark = Scene(ambient=(1.0,) * 3, background=(0.0,) * 3, lights=())
    gl.sync_sources([BodySource(1, True, (VisualLink(shapes=tuple(balls)),))], dark)
    asked = CameraRequest("c", None, 0, ((0, 0, 0), (0, 0, 0)), *SIZE, FOV, 0.1, 20.0)
    gl.apply(Snapshot(0.0, 0, ()))
    rgb, depth = gl.render_with_depth(replace(asked, distortion=lens, depth=True))
    assert rgb.shape == (240, 320, 3)
    np.testing.assert_array_equal(depth, gl.render_with_depth(replace(asked, depth=True))[1])
    count, _, _, centers = cv2.connectedComponentsWithStats((rgb[:, :, 0] > 100).astype(np.uint8))
    k = camera.intrinsics(*SIZE, FOV)
    straight = project(marks() @ OPTICAL_FROM_CAMERA.T, k)
    moved = np.array([brown(*((place + 0.5) / SIZE), lens) for place in straight])
    zoom = np.ones(2)
    if lens.crop:
        zoom = np.subtract(brown(1.0, 1.0, lens), brown(0.0, 0.0, lens))
    expected = ((moved - 0.5) / zoom + 0.5) * SIZE - 0.5
    inside = ((expected > 8) & (expected < np.array(SIZE) - 9)).all(axis=1)
    inside &= ((straight > 8) & (straight < np.array(SIZE) - 9)).all(axis=1)
    assert inside.sum() >= 15 and count - 1 >= inside.sum()
    gaps = np.linalg.norm(centers[1:, None] - expected[inside][None], axis=2).min(axis=0)
    assert gaps.max() < 1.5 and np.median(gaps) < 0.8  # [px]; the map moves whole pixels


def test_a_barrel_that_is_not_cropped_has_a_border(gl):
    white = Scene(background=(1.0,) * 3, lights=())
    gl.sync_sources([], white)
    gl.apply(Snapshot(0.0, 0, ()))
    asked = CameraRequest("c", None, 0, ((0, 0, 0), (0, 0, 0)), *SIZE, FOV, 0.1, 20.0)
    lens = Distortion(-0.3)
    border = gl.render(replace(asked, distortion=lens))[:, :, 0]
    assert border[120, 160] == 255 and border[:3, :3].max() < 100
    cropped = gl.render(replace(asked, distortion=replace(lens, crop=True)))[:, :, 0]
    assert (cropped > 200).mean() > 0.98


def test_a_model_in_focal_lengths_bends_less(gl):
    """What Gazebo calls not legacy: lengths are in focal lengths, the image is not cropped."""
    lens = Distortion(-0.1, legacy=False)
    points = plan_distortion(*SIZE, FOV, lens)
    focal = 160.0 / math.tan(FOV / 2.0)
    x, y = (points[30, 40] + 0.5) / SIZE - 0.5  # in the pinhole's image
    r2 = (x * 320 / focal) ** 2 + (y * 320 / focal) ** 2
    seen_at = (0.5 + np.array((x, y)) * (1.0 - 0.1 * r2)) * SIZE - 0.5
    assert np.abs(seen_at - (40, 30)).max() < 1.5


def test_without_distortion_nothing_is_warped(gl):
    asked = CameraRequest("c", None, 0, ((0, 0, 0), (0, 0, 0)), *SIZE, FOV, 0.1, 20.0)
    plain = gl.render(asked)
    np.testing.assert_array_equal(plain, gl.render(replace(asked, distortion=None)))


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
    """The image has the camera's, camera_info the plugin's or with autoDistortion the camera's."""
    spec = spec_of(camera=BENT)
    assert spec.distortion == Distortion(-0.2, 0.03, 0.01, 0.001, -0.002, crop=True)
    assert CameraRequest.from_spec(spec, 1, 0).distortion == spec.distortion
    assert spec.coefficients == ()
    auto = spec_of(camera=BENT, plugin="<autoDistortion>true</autoDistortion>")
    assert auto.coefficients == (-0.2, 0.03, 0.001, -0.002, 0.01)
    d, k, _, p = camera.camera_info_arrays(320, 240, 1.0, auto.coefficients, 300.0, (161.0, 0.0))
    assert d.tolist() == list(auto.coefficients) and p[0] == k[0] == 300.0
    assert (k[2], k[5]) == (161.0, 120.5), "as camera_utils: half of height + 1"
    assert not spec_of(camera=BENT, plugin="<borderCrop>0</borderCrop>").distortion.crop
    assert spec_of().distortion is None and CameraSpec("a", "l").distortion is None
    by_plugin = "<distortionK1>-0.1</distortionK1><distortionT2>0.2</distortionT2>"
    only_info = spec_of(plugin=by_plugin + "<focalLength>250</focalLength><Cx>150</Cx>")
    assert only_info.distortion is None and only_info.coefficients == (-0.1, 0.0, 0.0, 0.2, 0.0)
    assert (only_info.focal_length, only_info.center_x, only_info.center_y) == (250.0, 150.0, 0.0)
    tiny = "<distortion><k1>0.00000001</k1></distortion>"
    assert spec_of(camera=tiny).distortion is None
    pincushion = "<distortion><k1>0.2</k1><center>0.4 0.6</center></distortion>"
    assert spec_of(camera=pincushion).distortion == Distortion(0.2, center=(0.4, 0.6))
    newer = "<distortion><k1>-0.2</k1>{}</distortion>".format(
        "<ignition:legacy_mode>false</ignition:legacy_mode>"
    )
    assert spec_of(camera=newer).distortion == Distortion(-0.2, legacy=False)


def test_a_bad_distortion_is_named_and_counts_as_none():
    text = CAMERA.format(camera="<distortion><k1>much</k1></distortion>", plugin="")
    found = parse_urdf(text, str, "r")
    assert found.sensors[0].distortion is None
    assert any("k1" in str(warning) and "much" in str(warning) for warning in found.warnings)


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
    gl.sync_sources([BodySource(1, True, (VisualLink(shapes=tuple(balls)),))], dark)
    gl.apply(Snapshot(0.0, 0, ()))
    request = replace(CameraRequest.from_spec(found.sensors[0], 1, 0), near=0.1)
    rgb = gl.render(request)
    _, _, _, centers = cv2.connectedComponentsWithStats((rgb[:, :, 0] > 100).astype(np.uint8))
    for (theta, phi), place in zip(angles, places):
        away = 150.0 * RADIUS[kind](theta)
        expected = 149.5 - away * np.array((math.cos(phi), math.sin(phi)))
        gap = np.linalg.norm(centers[1:] - expected, axis=1).min()
        assert gap < 1.0, (theta, phi, place)


def test_the_texture_of_a_lens_is_how_fine_its_image_is(gl):
    """Edges of narrow stripes: the fewer pixels the six images have, the softer they are."""
    stripes = [
        Shape(Geometry("box", (0.02, 0.02, 4.0)), Pose((2.0, y, 0.0)), (1.0,) * 4)
        for y in np.arange(-0.8, 0.8, 0.04).tolist()
    ]
    dark = Scene(ambient=(1.0,) * 3, background=(0.0,) * 3, lights=())
    gl.sync_sources([BodySource(1, True, (VisualLink(shapes=tuple(stripes)),))], dark)
    gl.apply(Snapshot(0.0, 0, ()))
    request = CameraRequest("c", None, 0, ((0, 0, 0), (0, 0, 0)), 400, 400, 1.0, 0.1, 20.0)
    images = [
        gl.render(replace(request, lens=Lens(0.5, texture=edge)))[150:250, 150:250, 0].astype(int)
        for edge in (1024, 64)
    ]
    steepest = [np.abs(np.diff(image, axis=1)).max() for image in images]
    assert steepest[0] > 150 and steepest[1] < 40
    found = parse_urdf(WIDE.format("<env_texture_size>512</env_texture_size>"), str, "r")
    assert found.sensors[0].lens.texture == 512 and found.warnings == []
    assert parse_urdf(WIDE.format(""), str, "r").sensors[0].lens.texture == 256


def test_intrinsics_and_samples_of_descriptions():
    spec = spec_of(
        camera="<image><anti_aliasing>2</anti_aliasing></image><lens><intrinsics><fx>300</fx>"
        "<fy>310</fy><cx>150</cx></intrinsics></lens>"
    )
    assert spec.intrinsics == Intrinsics(300.0, 310.0, 150.0, 120.0, 0.0) and spec.samples == 2
    assert CameraRequest.from_spec(spec, 1, 0).intrinsics == spec.intrinsics
    assert spec_of().intrinsics is None and spec_of().samples == 4
    bad = CAMERA.format(camera="<lens><intrinsics><fx>0</fx></intrinsics></lens>", plugin="")
    found = parse_urdf(bad, str, "r")
    assert found.sensors[0].intrinsics is None and "must be above 0" in found.warnings[0]


def test_a_lens_sees_nothing_beyond_its_cutoff(gl):
    gl.sync_sources([], Scene(background=(1.0, 1.0, 1.0)))
    gl.apply(Snapshot(0.0, 0, ()))
    request = CameraRequest("c", None, 0, ((0, 0, 0), (0, 0, 0)), 200, 200, 1.0, 0.1, 20.0)
    rgb = gl.render(replace(request, lens=Lens(math.pi, cutoff=math.pi / 4)))[:, :, 0]
    radius = np.hypot(*(np.indices((200, 200)) - 99.5))
    t = np.clip((radius / 100 - 0.5) / 0.02 + 1, 0, 1)  # it fades as by Gazebo's shader
    assert rgb == pytest.approx(255 * (1 - t * t * (3 - 2 * t)), abs=1.0)
    behind = gl.render(replace(request, lens=Lens(2 * math.pi)))  # a whole turn has no seam
    assert (behind[radius < 98] == 255).all()


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
