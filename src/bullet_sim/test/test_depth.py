"""Depth pictures: the buffer's arithmetic, and a box at a known distance, in both processes."""

import numpy as np
import pytest
from bullet_sim.description.model import Finish, Geometry, Shape, VisualLink
from bullet_sim.description.world import Scene
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.plugins.cameras import CameraSpec
from bullet_sim.plugins.depth_cameras import DepthCameraSpec
from bullet_sim.pose import Pose
from bullet_sim.render.client import RenderClient
from bullet_sim.render.gl.renderer import GlRenderer
from bullet_sim.render.pybullet_renderer import PyBulletRenderer
from bullet_sim.render.request import CameraRequest, Quality
from bullet_sim.sensors import camera
from bullet_sim.snapshot import BodySource, BodyState, Snapshot
from mirrored import source_of
from PIL import Image

pytestmark = pytest.mark.usefixtures("sketches")

SCENE = """<robot name="s"><link name="base"><visual><origin xyz="3 0 0"/><geometry>
<box size="1 1 1"/></geometry><material name="m"><color rgba="1 0 0 1"/></material></visual>
</link></robot>"""
FAR, FACE = 20.0, 2.5  # [m] far clip; the box's near face
SNAPSHOT = Snapshot(0.007, 7, (BodyState(0, (0, 0, 0), (0, 0, 0, 1), ()),))


def request(**changes):
    """A depth camera at the origin that looks along +x."""
    values = dict(
        pose=((0, 0, 0), (0, 0, 0)),
        width=120,
        height=90,
        horizontal_fov=1.2,
        near=0.1,
        far=FAR,
        depth=True,
    )
    values.update(changes)
    return CameraRequest("eye", 0, 0, **values)


@pytest.fixture(name="source")
def _source():
    return source_of(SCENE)


@pytest.mark.parametrize("near, far", [(0.02, 100.0), (0.1, 8.0), (0.5, 300.0)])
def test_buffer_is_the_inverse_of_the_projection(near, far):
    matrix = np.reshape(camera.projection_matrix(1.0, 1.3, near, far), (4, 4)).T
    for distance in np.geomspace(near, far, 7):
        clip = matrix @ (0.0, 0.0, -distance, 1.0)
        buffer = np.array([[(clip[2] / clip[3] + 1.0) / 2.0]])
        assert camera.meters_from_buffer(buffer, near, far)[0, 0] == pytest.approx(distance)


def test_points_of_a_picture():
    k = camera.intrinsics(4, 3, np.pi / 2)  # focal length 2 px, middle (1.5, 1)
    depth = np.full((3, 4), 2.0, np.float32)
    depth[0, 0] = np.nan
    points = camera.points(depth, k)
    assert points.shape == (3, 4, 3) and np.isnan(points[0, 0]).all()
    np.testing.assert_allclose(points[2, 3], (1.5, 1.0, 2.0), rtol=1e-6)
    np.testing.assert_allclose(points[1, 0], (-1.5, 0.0, 2.0), rtol=1e-6)


def test_cutoffs_are_open():
    depth = np.array([[0.3, 0.4, 0.5, 5.0, 6.0]], np.float32)
    known = np.isfinite(camera.within(depth, np.float32(0.4), 5.0))
    assert known.tolist() == [[False, False, True, False, False]]


def check_scene(depth, rgb):
    """The box's face is flat at FACE: depth is along the axis, not along each ray."""
    k = camera.intrinsics(120, 90, 1.2)
    red = rgb[:, :, 0].astype(int) > 2 * rgb[:, :, 1:].max(axis=2).astype(int)
    inner = np.zeros_like(red)
    half = int(0.5 / FACE * k[0, 0]) - 2
    inner[44 - half : 46 + half, 59 - half : 61 + half] = True
    assert red[inner].all()
    np.testing.assert_allclose(depth[inner], FACE, atol=0.005)  # [m]
    assert (depth[:5] == np.float32(FAR)).all()
    points = camera.points(depth, k)[inner]
    assert np.abs(points[:, :2]).max() <= 0.5


def test_mirror_measures_a_box(source):
    mirror = PyBulletRenderer()
    mirror.sync_sources([source])
    mirror.apply(SNAPSHOT)
    rgb, depth = mirror.render_with_depth(request())
    mirror.close()
    assert depth.dtype == np.float32 and depth.shape == (90, 120)
    check_scene(depth, rgb)


@pytest.mark.parametrize("kind", ["tiny", "auto"])
def test_worker_sends_depth_to_those_who_ask(source, kind):
    with RenderClient() as client:
        client.start(kind)
        client.set_sources([source])
        plain = CameraRequest(**{**vars(request(depth=False)), "name": "plain"})
        deep, flat = client.render_sync(SNAPSHOT, [request(), plain], 30.0)
    assert flat.depth is None and deep.step == 7
    check_scene(deep.depth, deep.rgb)
    np.testing.assert_array_equal(deep.rgb, flat.rgb)


PLUGIN = """<robot name="r"><link name="base"/><gazebo reference="base">
<sensor type="depth" name="c"><update_rate>10</update_rate><camera/>
<plugin name="p" filename="libgazebo_ros_{}.so">{}</plugin></sensor></gazebo></robot>"""


@pytest.mark.parametrize(
    "library, cutoffs, organized",
    [("depth_camera", (0.3, np.inf), False), ("openni_kinect", (0.3, 6.0), True)],
)
def test_cutoffs_and_rows_of_the_two_plugins(library, cutoffs, organized):
    values = "<pointCloudCutoff>0.3</pointCloudCutoff><pointCloudCutoffMax>6</pointCloudCutoffMax>"
    (spec,) = parse_urdf(PLUGIN.format(library, values), str, "r").sensors
    assert ((spec.cutoff, spec.cutoff_max), spec.organized) == (cutoffs, organized)
    (spec,) = parse_urdf(PLUGIN.format(library, ""), str, "r").sensors
    assert spec.cutoff_max == (5.0 if organized else np.inf)


def test_holes_of_a_cut_out_image_have_the_surfaces_depth(tmp_path):
    """As in Gazebo, whose depth has no textures."""
    Image.fromarray(np.full((4, 4, 4), (255, 0, 0, 0), np.uint8)).save(tmp_path / "hole.png")
    panel = Shape(
        Geometry("box", (0.1, 2.0, 2.0)),
        Pose((3.0, 0.0, 0.0)),
        texture=str(tmp_path / "hole.png"),
        painted=True,
        finish=Finish(rejection=0.5),
    )
    gl = GlRenderer(Quality("false", "false"))
    try:
        sources = [BodySource(0, True, (VisualLink(shapes=(panel,)),))]
        gl.sync_sources(sources, Scene(background=(0.0, 0.0, 1.0)))
        gl.apply(SNAPSHOT)
        rgb, depth = gl.render_with_depth(request())
    finally:
        gl.close()
    assert rgb[45, 60].tolist() == [0, 0, 255]
    assert depth[45, 60] == pytest.approx(2.95, abs=1e-3) and depth[0, 0] == np.float32(FAR)


def test_requests_of_specs():
    assert CameraRequest.from_spec(DepthCameraSpec("a", "l"), 1, 0).depth
    assert not CameraRequest.from_spec(CameraSpec("a", "l", noise_mean=0.1), 1, 0).depth
    assert CameraRequest.from_spec(CameraSpec("a", "l", noise_mean=0.1), 1, 0).noise_mean == 0.1


def test_noise_has_its_mean():
    gray = np.full((50, 50, 3), 100, np.uint8)
    assert (camera.add_noise(gray, 0.0, None, 0.1) == 126).all()
    noisy = camera.add_noise(gray, 0.01, np.random.default_rng(0), 0.1)
    assert noisy.mean() == pytest.approx(125.5, abs=0.2)
