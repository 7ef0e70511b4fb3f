"""What the mirror draws, with PyBullet's own renderer: places, colours, noise, errors."""

import numpy as np
import pytest
from bullet_sim.description.model import Geometry, Shape, VisualLink
from bullet_sim.engine.bullet.camera import PyBulletCamera
from bullet_sim.engine.bullet.client import Client
from bullet_sim.engine.bullet.urdf import visual_urdf
from bullet_sim.errors import RenderError
from bullet_sim.plugins.cameras import CameraSpec
from bullet_sim.render.pybullet_renderer import PyBulletRenderer
from bullet_sim.render.renderer import FAR_DEPTH, gradient, paint_sky
from bullet_sim.render.request import CameraRequest
from bullet_sim.sensors import camera
from bullet_sim.snapshot import BodySource, BodyState, Snapshot
from mirrored import source_of
from pinhole import OPTICAL_FROM_CAMERA, project

pytestmark = pytest.mark.usefixtures("sketches")

LEVEL = (0.0, 0.0, 0.0, 1.0)
GHOST = Shape(Geometry("mesh", path="/no/ghost.obj"))
BOX = """<robot name="box"><link name="base"><visual><geometry><box size="{0} {0} {0}"/></geometry>
<material name="m"><color rgba="{1} 1"/></material></visual></link></robot>"""
ARM = """<robot name="arm"><link name="base"/>
<joint name="pan" type="revolute"><parent link="base"/><child link="head"/><origin xyz="0 0 1"/>
<axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
<link name="head"><inertial><mass value="0.1"/>
<inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"""


def request(name="eye", width=640, height=480, key=0, link_index=1, **changes):
    values = dict(pose=((0.1, 0.0, 0.0), (0.0, 0.0, 0.0)), horizontal_fov=1.2, near=0.05, far=50.0)
    values.update(changes)
    return CameraRequest(name, key, link_index, width=width, height=height, **values)


def snapshot(pan=0.0, box=(3.0, 0.5, 1.2), step=7):
    return Snapshot(
        step * 0.001, step, (BodyState(0, (0, 0, 0), LEVEL, (pan,)), BodyState(1, box, LEVEL, ()))
    )


@pytest.fixture(name="sources")
def _sources():
    return [source_of(ARM), source_of(BOX.format(0.1, "1 0 0"), 1, False)]


@pytest.fixture(name="mirror")
def _mirror(sources):
    mirror = PyBulletRenderer()
    mirror.sync_sources(sources)
    yield mirror
    mirror.close()


def red_pixels(rgb):
    """(n, 2) (u, v) of pixels that are red."""
    rgb = rgb.astype(int)
    v, u = np.nonzero(rgb[:, :, 0] > 2 * rgb[:, :, 1:].max(axis=2) + 20)
    return np.column_stack([u, v])


SIZES = [(640, 480), (400, 150), (160, 300)]
PLACES = [(3, 0, 0), (3, 0.5, 0.2), (2.5, -0.6, -0.2), (2.003, 0.1, 0.1)]


def box_at(in_camera):
    """Snapshot with the box at a place of the camera frame [m]."""
    return snapshot(box=np.add(in_camera, (0.1, 0, 1)).tolist())


def check_outline(rgb, asked, in_camera):
    """The red box covers just those pixels whose centers K puts inside its outline."""
    found = red_pixels(rgb)
    k = camera.intrinsics(asked.width, asked.height, asked.horizontal_fov)
    corners = in_camera + 0.05 * np.array(np.meshgrid(*[(-1, 1)] * 3)).reshape(3, -1).T
    outline = project(corners @ OPTICAL_FROM_CAMERA.T, k)
    inside_low, inside_high = np.ceil(outline.min(axis=0)), np.floor(outline.max(axis=0))
    inside_low = np.maximum(inside_low, 0)
    inside_high = np.minimum(inside_high, (asked.width - 1, asked.height - 1))
    np.testing.assert_allclose(found.min(axis=0), inside_low, atol=1.0)  # [px]
    np.testing.assert_allclose(found.max(axis=0), inside_high, atol=1.0)
    middle = (found.min(axis=0) + found.max(axis=0)) / 2
    np.testing.assert_allclose(middle, (inside_low + inside_high) / 2, atol=0.5)


@pytest.mark.parametrize("width, height", SIZES)
@pytest.mark.parametrize("in_camera", PLACES)
def test_box_is_where_camera_info_says(mirror, width, height, in_camera):
    asked = request(width=width, height=height)
    mirror.apply(box_at(in_camera))
    check_outline(mirror.render(asked), asked, in_camera)


def test_labels_are_where_the_picture_shows_the_box(mirror, sources):
    mirror.apply(box_at((3, 0.5, 0.2)))
    labels, rgb = mirror.labels(request()), mirror.render(request())
    assert labels.dtype == np.int32
    found = {source.key: (labels == source.key).sum() for source in sources}
    red = red_pixels(rgb)
    box = labels[red[0][1], red[0][0]]
    assert found[box] == len(red) and (labels[red[:, 1], red[:, 0]] == box).all()


def test_camera_turns_with_its_joint(mirror):
    mirror.apply(snapshot(pan=np.pi / 2, box=(0.0, 3.1, 1.0)))
    found = red_pixels(mirror.render(request()))
    np.testing.assert_allclose(found.mean(axis=0), (319.5, 239.5), atol=1.0)
    mirror.apply(snapshot(pan=0.0, box=(0.0, 3.1, 1.0)))
    assert len(red_pixels(mirror.render(request()))) == 0


def test_same_snapshot_same_bits(mirror):
    mirror.apply(snapshot())
    first = mirror.render(request())
    mirror.apply(snapshot(pan=1.0))
    mirror.apply(snapshot())
    np.testing.assert_array_equal(first, mirror.render(request()))


def test_noise_depends_on_seed_name_and_step_alone(mirror):
    mirror.apply(snapshot())
    noisy = request(noise_stddev=0.02, seed=4, width=64, height=48)
    first = mirror.render(noisy, step=10)
    other = mirror.render(noisy, step=11)
    assert (first != other).any()
    np.testing.assert_array_equal(first, mirror.render(noisy, step=10))
    clean = mirror.render(request(width=64, height=48))
    assert (first.astype(int) - clean).std() == pytest.approx(0.02 * 255, rel=0.1)


def test_sources_come_change_and_go(mirror, sources):
    mirror.apply(snapshot())
    mirror.sync_sources(sources[:1])
    assert len(red_pixels(mirror.render(request()))) == 0
    mirror.sync_sources([sources[0], source_of(BOX.format(0.4, "0 0 1"), 1, False)])
    mirror.apply(snapshot(box=(3.1, 0.0, 1.0)))
    red, green, blue = mirror.render(request())[240, 320]
    assert blue > 100 and red < 20 and green < 20


def test_a_body_that_does_not_load_is_named_and_the_others_are_drawn(mirror, sources):
    bad = BodySource(
        5, False, (VisualLink(shapes=(Shape(Geometry("mesh", path="/no/ghost.obj")),)),)
    )
    with pytest.raises(RenderError, match="body 5: PyBullet cannot load"):
        mirror.sync_sources([bad, *sources])
    mirror.sync_sources([bad, *sources])  # said once
    mirror.apply(snapshot())
    assert len(red_pixels(mirror.render(request()))) > 0


@pytest.mark.parametrize(
    "changes, words",
    [
        ({"key": 9}, r"camera eye: body 9 .*\[0, 1\]"),
        ({"link_index": 4}, "camera eye: link index 4, .*0 to 1"),
        ({"width": 0}, "0x480"),
    ],
)
def test_bad_requests_are_named(mirror, changes, words):
    mirror.apply(snapshot())
    with pytest.raises(ValueError, match=words):
        mirror.render(request(**changes))


def test_request_from_spec():
    spec = CameraSpec(
        "front", "head", ((0.1, 0, 0), (0, 0, 0)), 320, 240, 1.0, 0.1, 9.0, noise_stddev=0.01
    )
    assert CameraRequest.from_spec(spec, 3, 2, seed=8) == CameraRequest(
        "front", 3, 2, ((0.1, 0.0, 0.0), (0.0, 0.0, 0.0)), 320, 240, 1.0, 0.1, 9.0, 0.01, 8
    )


def test_sky_replaces_only_what_was_not_drawn():
    depth = np.full((8, 6), 0.99, np.float32)
    depth[:3] = 1.0
    depth[5, 2] = FAR_DEPTH
    rgb = paint_sky(np.full((8, 6, 3), 7, np.uint8), depth)
    sky = np.broadcast_to(gradient(8), (8, 6, 3))
    empty = depth >= FAR_DEPTH
    np.testing.assert_array_equal(rgb[empty], sky[empty])
    assert (rgb[~empty] == 7).all()


def test_looks_are_loaded_only_where_they_are_drawn(sources):
    """A client that is not drawn does not read what its bodies look like."""
    view = camera.view_matrix((-0.5, 0.0, 0.0), np.eye(3))
    projection = camera.projection_matrix(1.0, 1.0, 0.1, 10.0)
    seen = []
    for draw in (True, False):
        client, links = Client(draw), sources[1].links
        client.load_text(1, visual_urdf(links, [link.shapes for link in links]), "0")
        rgb, _ = PyBulletCamera(client).render(32, 32, view, projection)
        seen.append(len(red_pixels(rgb)) > 0)
        client.close()
    assert seen == [True, False]
