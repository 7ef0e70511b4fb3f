"""Shadows without bands, saw teeth and spots; markings that are not hidden by what they lie on.

What is lit is computed for each pixel by a ray to the sun through the scene's boxes. A pixel is
judged where all points near it on its surface agree, so not at a shadow's edge.
"""

from dataclasses import replace

import numpy as np
import pytest
from bullet_sim.description.model import Finish, Geometry, Light, Shape, VisualLink
from bullet_sim.description.world import Scene
from bullet_sim.pose import Pose
from bullet_sim.render.gl.shadows import Map
from bullet_sim.render.request import CameraRequest
from bullet_sim.sensors import camera
from bullet_sim.snapshot import BodySource, BodyState, Snapshot
from pinhole import OPTICAL_FROM_CAMERA

EDGE = 0.015  # [m] from a shadow's edge, across the sun's rays: 1.5 texels of a wide map
NEAR, LIFT = 1e-6, 1e-4  # [m] how far a ray starts from its surface, and what counts as a hit


def box(size, xyz, rpy=(0.0, 0.0, 0.0), color=0.5):
    pose = Pose.from_xyz_rpy(tuple(map(float, xyz)), tuple(map(float, rpy)))
    geometry = Geometry("box", tuple(map(float, size)))
    return Shape(geometry, pose, (color, color, color, 1.0), finish=Finish(specular=(0.0,) * 3))


def sun_at(pitch, yaw=0.3):
    away = (np.cos(pitch) * np.cos(yaw), np.cos(pitch) * np.sin(yaw), -np.sin(pitch))
    return Light("sun", direction=tuple(away), diffuse=(0.8,) * 3, specular=(0.0,) * 3,
                 cast_shadows=True)  # fmt: skip


FLOOR = box((40, 40, 0.1), (0, 0, -0.05))
SCENES = {
    "a zebra crossing 1 mm above the road": (
        [FLOOR] + [box((0.4, 2, 0.001), (x, 0, 0.0005), color=0.9) for x in np.arange(2, 6, 0.8)],
        [],
    ),
    "plates of 3 cm": (
        [FLOOR] + [box((0.5, 0.5, 0.03), (x, y, 0.015)) for x in (3, 4, 5) for y in (-1, 0, 1)],
        [],
    ),
    "a ramp": ([FLOOR, box((3, 2, 0.2), (4, 0, 0.3), (0.0, -0.25, 0.2))], []),
    "a wall": ([FLOOR, box((0.1, 3, 1), (4, 0, 0.5), (0, 0, 0.5))], []),
    "a low curb and a post": (
        [FLOOR, box((0.1, 3, 0.1), (3, 0, 0.05)), box((0.06, 0.06, 1.2), (4, 0.5, 0.6))],
        [],
    ),
    "a car on a marked road": (
        [FLOOR, box((6, 0.3, 0.001), (4, 0, 0.0005), color=0.9)],
        [box((0.4, 0.2, 0.1), (3, 0, 0.1)), box((0.1, 0.05, 0.1), (3.1, 0.12, 0.05))],
    ),
}


def hits(shape, origins, direction):
    """Whether rays to a direction pass through a box, (n,) bool (slab method)."""
    rotation = shape.pose.matrix
    local = (origins - np.array(shape.pose.position)) @ rotation
    along = direction @ rotation
    half = np.array(shape.geometry.size) / 2.0
    with np.errstate(divide="ignore", invalid="ignore"):
        one, other = (-half - local) / along, (half - local) / along
    enter, leave = np.fmin(one, other).max(axis=1), np.fmax(one, other).min(axis=1)
    return (leave > np.maximum(enter, LIFT)) & (leave - np.maximum(enter, 0.0) > LIFT)


def normals_at(shapes, points):
    """Outward normal (n, 3) of the box on which each point lies; NaN where it lies on an edge."""
    normals, nearest = np.full(points.shape, np.nan), np.full(len(points), np.inf)
    for shape in shapes:
        rotation = shape.pose.matrix
        local = (points - np.array(shape.pose.position)) @ rotation
        half = np.array(shape.geometry.size) / 2.0
        beside = np.abs(local) - half
        gap = np.abs(beside.max(axis=1))
        axis = beside.argmax(axis=1)
        better = gap < nearest - 1e-5
        chosen = rotation.T[axis] * np.sign(local[np.arange(len(local)), axis])[:, None]
        normals[better], nearest[better] = chosen[better], gap[better]
    return normals


def expected(shapes, points, towards):
    """Whether points see the sun: 1 lit, 0 in the shadow, NaN at an edge; and normals . sun."""
    normals = normals_at(shapes, points)
    facing = normals @ towards
    helper = np.where(np.abs(normals[:, 2:]) < 0.9, (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
    u = np.cross(normals, helper)
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    v = np.cross(normals, u)
    edge = EDGE / np.maximum(facing, 0.03)[:, None]
    lit = []
    for a, b in ((0, 0), (1, 0), (-1, 0), (0, 1), (0, -1)):
        origins = points + edge * (a * u + b * v) + NEAR * normals
        lit.append(~np.any([hits(shape, origins, towards) for shape in shapes], axis=0))
    lit = np.array(lit)
    agree = (lit == lit[0]).all(axis=0)
    return np.where(agree, lit[0].astype(float), np.nan), facing


CORNERS = [box((0.5, 0.5, 0.5), (x, y, 0.25)) for x in (-15, 15) for y in (-15, 15)]


@pytest.mark.parametrize("others", [[], CORNERS], ids=["alone", "in a wide world"])
@pytest.mark.parametrize("pitch", [0.15, 0.5, 1.3])
@pytest.mark.parametrize("name", SCENES)
def test_shadows_are_where_rays_say(gl, name, pitch, others):
    still, moving = SCENES[name]
    still = still + others
    sun = sun_at(pitch)
    scene = Scene(ambient=(0.3,) * 3, background=(0.0,) * 3, lights=(sun,))
    bodies = [BodySource(1, True, (VisualLink(shapes=tuple(still)),))]
    bodies.append(BodySource(2, False, (VisualLink(shapes=tuple(moving)),)))
    gl.apply(Snapshot(0.0, 0, ()))
    states = tuple(BodyState(key, (0, 0, 0), (0, 0, 0, 1), ()) for key in (1, 2))
    judged = wrong = 0
    for pose in (((0.5, 0.0, 0.8), (0.0, 0.25, 0.0)), ((4.0, -3.0, 0.4), (0.0, 0.1, 1.5))):
        asked = CameraRequest("eye", None, 0, pose, 160, 120, 1.0, 0.05, 60.0, depth=True)
        pictures = []
        for shown in (scene, replace(scene, shadows=False)):
            gl.sync_sources([], shown)
            gl.sync_sources(bodies, shown)
            gl.apply(Snapshot(0.0, 0, states))
            rgb, depth = gl.render_with_depth(asked)
            pictures.append(rgb[:, :, 0].astype(int))
        near = (depth < 9.0).ravel()
        k = camera.intrinsics(160, 120, 1.0)
        optical = camera.points(depth, k).reshape(-1, 3)[near].astype(float)
        ahead = optical @ OPTICAL_FROM_CAMERA
        place = Pose.from_xyz_rpy(*pose)
        points = ahead @ place.matrix.T + np.array(place.position)
        lit, facing = expected([*still, *moving], points, -np.array(sun.direction))
        dark, full = (picture.ravel()[near] for picture in pictures)
        clear = (facing > 0.03) & ~np.isnan(lit)
        share = (full - dark) / np.maximum(255 * 0.5 * 0.8 * facing, 1.0)  # of the light missing
        judged += clear.sum()
        wrong += ((share > 0.35) != (lit < 0.5))[clear].sum()
    assert judged > 5000
    assert wrong <= 2e-4 * judged, f"{wrong} of {judged} pixels"


@pytest.mark.parametrize("near", [0.02, 0.1])
def test_markings_1_mm_above_the_road_show_to_the_horizon(gl, near):
    """Each pixel of the stripes is as it is without the road, up to 80 m away."""
    stripes = [box((80, 0.3, 0.0005), (42, y, 0.00075), color=0.9) for y in (-3, -1, 1, 3)]
    road = box((200, 40, 0.1), (90, 0, -0.05), color=0.2)
    scene = Scene(ambient=(1.0,) * 3, background=(0.2,) * 3, lights=())
    asked = CameraRequest("eye", None, 0, ((0, 0, 0.6), (0, 0.1, 0)), 640, 480, 1.0, near, 300.0)
    pictures = []
    for shapes in ([road, *stripes], stripes):
        gl.sync_sources([BodySource(1, True, (VisualLink(shapes=tuple(shapes)),))], scene)
        gl.apply(Snapshot(0.0, 0, ()))
        pictures.append(gl.render(asked)[:, :, 0].astype(int))
    bright = pictures[1] > 200
    assert bright.sum() > 5000
    assert (pictures[0][bright] > 200).mean() > 0.999


def test_maps_have_few_sizes_each_half_again_as_large_at_most(gl):
    """While a box grows a little its map stays as it is: its shadow's edges do not crawl."""
    cover, edges = Map(gl._context.gl, 4096), []
    for side in np.linspace(1.0, 1.9, 40):
        low = np.full(3, -side / 2.0)
        cover.fit(np.eye(3), low, -low, np.zeros(3))
        edges.append(2.0 / cover.clip[0, 0])
        assert 1.02 * side <= edges[-1] <= 1.02 * side * np.sqrt(2.0) * 1.001
    assert len(set(edges)) == 2
