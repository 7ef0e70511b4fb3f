"""The grid against known places, there and back, and where the world lies on it."""

import math

import numpy as np
import pytest
from robot_localization.frames import Transform, matrix
from robot_localization.navsat import Alignment, LocalPlane, NotAligned, UtmGrid

PLACES = [(48.0, 11.5), (-33.9, 151.2), (0.001, -77.0), (-0.001, 6.9), (69.6, 18.9), (83.0, 2.0)]


@pytest.mark.parametrize("latitude, longitude", PLACES)
def test_utm_there_and_back(latitude, longitude):
    grid = UtmGrid.at(latitude, longitude)
    assert grid.back(*grid.forward(latitude, longitude, 12.0)) == pytest.approx(
        (latitude, longitude, 12.0), abs=1e-8
    )


def test_utm_on_the_central_meridian():
    """On it: 500 km, and the scaled way from the equator along the meridian."""
    grid = UtmGrid.at(45.0, 9.0)
    east, north, _ = grid.forward(45.0, 9.0)
    assert grid.zone == 32 and grid.north
    assert east == pytest.approx(500e3, abs=1e-3)
    assert north == pytest.approx(0.9996 * 4984944.378, abs=0.01)  # arc to 45 deg on WGS 84
    assert grid.convergence(45.0, 9.0) == pytest.approx(0.0, abs=1e-6)


def test_utm_in_the_south_counts_from_ten_thousand_kilometers():
    grid = UtmGrid.at(-45.0, 9.0)
    assert not grid.north
    assert grid.forward(-45.0, 9.0)[1] == pytest.approx(1e7 - 0.9996 * 4984944.378, abs=0.01)


@pytest.mark.parametrize("latitude, longitude", [(48.0, 11.5), (48.0, 6.5), (-33.9, 151.2)])
def test_convergence_is_that_of_the_sphere_nearly(latitude, longitude):
    """tan g = tan(longitude from the central meridian) sin(latitude)."""
    grid = UtmGrid.at(latitude, longitude)
    off = math.radians(longitude - (6 * grid.zone - 183))
    expected = math.atan(math.tan(off) * math.sin(math.radians(latitude)))
    assert grid.convergence(latitude, longitude) == pytest.approx(expected, rel=2e-3)


@pytest.mark.parametrize("text, zone, north", [("31U", 31, True), ("56h", 56, False)])
def test_zones_by_name(text, zone, north):
    grid = UtmGrid.named(text)
    assert (grid.zone, grid.north) == (zone, north)


@pytest.mark.parametrize("text", ["", "U31", "61N", "31", "31I"])
def test_names_of_no_zone(text):
    with pytest.raises(ValueError, match=f"UTM zone is '{text}'"):
        UtmGrid.named(text)


@pytest.mark.parametrize("latitude, longitude", PLACES)
def test_local_plane_there_and_back(latitude, longitude):
    plane = LocalPlane(latitude, longitude)
    assert plane.forward(latitude, longitude, 100.0) == pytest.approx((0, 0, 100), abs=1e-6)
    place = latitude + 0.02, longitude + 0.03, 250.0
    assert plane.back(*plane.forward(*place)) == pytest.approx(place, abs=1e-9)


def test_local_plane_by_the_radii_of_curvature():
    latitude, small = math.radians(40.0), 1e-5
    e2 = (2.0 - 1.0 / 298.257223563) / 298.257223563
    bow = 1.0 - e2 * math.sin(latitude) ** 2
    meridian, normal = 6378137.0 * (1.0 - e2) / bow**1.5, 6378137.0 / math.sqrt(bow)
    plane = LocalPlane(40.0, -3.0)
    assert plane.forward(40.0 + small, -3.0)[1] == pytest.approx(
        math.radians(small) * meridian, rel=1e-5
    )
    assert plane.forward(40.0, -3.0 + small)[0] == pytest.approx(
        math.radians(small) * normal * math.cos(latitude), rel=1e-5
    )


def world(x, y, yaw):
    return Transform(matrix(0.0, 0.0, yaw), np.array((x, y, 0.0)))


def aligned(pose, yaw, antenna=None, **options):
    item = Alignment(local=True, **options)
    item.set_fix(48.0, 11.5, 500.0)
    item.set_attitude(matrix(0.0, 0.0, yaw))
    item.set_pose(pose)
    assert item.align(antenna)
    return item


def north_of(meters):
    return 48.0 + math.degrees(meters / 6378137.0 * 1.0025)  # near enough; compared at 1 %


def test_facing_east_at_the_origin_the_world_is_east_and_north():
    item = aligned(world(0.0, 0.0, 0.0), 0.0)
    assert item.to_world(48.0, 11.5, 500.0) == pytest.approx((0, 0, 0), abs=1e-6)
    assert item.to_world(north_of(100.0), 11.5, 510.0) == pytest.approx((0, 100, 10), abs=1.0)


def test_a_world_that_looks_north():
    item = aligned(world(0.0, 0.0, 0.0), math.pi / 2)
    assert item.to_world(north_of(100.0), 11.5, 500.0) == pytest.approx((100, 0, 0), abs=1.0)


def test_a_robot_that_has_driven_already():
    item = aligned(world(7.0, -3.0, 1.0), math.pi / 2)
    assert item.to_world(48.0, 11.5, 500.0)[:2] == pytest.approx((7.0, -3.0))
    displacement = item.to_world(north_of(100.0), 11.5, 500.0)[:2] - (7.0, -3.0)
    assert displacement == pytest.approx((100 * math.cos(1.0), 100 * math.sin(1.0)), rel=0.01)


def test_offset_and_declination_add_to_the_heading():
    item = aligned(world(0, 0, 0), math.pi / 2 - 0.3, declination=0.1, yaw_offset=0.2)
    assert item.to_world(north_of(100.0), 11.5, 500.0) == pytest.approx((100, 0, 0), abs=1.0)


def test_an_antenna_off_the_center():
    """1 m behind the center of a robot that looks north: the center is 1 m further north."""
    item = aligned(world(0, 0, 0), math.pi / 2, np.array((-1.0, 0.0, 0.5)))
    assert item.to_world(48.0, 11.5, 500.0) == pytest.approx((-1.0, 0.0, 0.5), abs=1e-6)


def test_utm_heading_is_corrected_by_the_convergence():
    """True north seen from the world: without the convergence it would be 1.9 degrees off."""
    item = Alignment()
    item.set_fix(48.0, 11.5, 0.0)
    item.set_attitude(np.eye(3))
    item.set_pose(world(0, 0, 0))
    assert item.align()
    east, north, _ = item.to_world(48.001, 11.5, 0.0)
    assert abs(math.atan2(east, north)) < 1e-4


def test_flat_worlds_have_no_altitude():
    item = aligned(world(0, 0, 0), 0.0, flat=True)
    assert item.to_world(48.0, 11.5, 700.0)[2] == 0.0


def test_places_of_positions():
    item = aligned(world(7.0, -3.0, 1.0), 0.4)
    place = item.to_geodetic(np.array((20.0, 30.0, 1.0)))
    assert item.to_world(*place) == pytest.approx((20.0, 30.0, 1.0), abs=1e-6)


def test_nothing_is_known_before_everything_came():
    item = Alignment()
    assert not item.align()
    item.set_pose(world(0, 0, 0))
    item.set_attitude(np.eye(3))
    assert not item.align()
    with pytest.raises(NotAligned):
        item.to_world(48.0, 11.5, 0.0)
    item.set_fix(48.0, 11.5, 0.0)
    assert item.align()


def test_a_datum_by_hand_is_the_origin():
    item = aligned(world(5.0, 5.0, 1.0), 0.3)
    item.set_datum(48.1, 11.6, 0.0, np.eye(3))
    item.set_fix(10.0, 10.0, 0.0)  # counts no more
    item.set_pose(world(9.0, 9.0, 9.0))
    assert item.align(np.array((1.0, 1.0, 1.0)))
    assert item.to_world(48.1, 11.6, 0.0) == pytest.approx((0, 0, 0), abs=1e-6)


def test_a_zone_by_hand_aligns_anew():
    item = Alignment()
    for _ in range(2):
        item.set_fix(48.0, 12.1, 0.0)
        item.set_attitude(np.eye(3))
        item.set_pose(world(0, 0, 0))
        assert item.align()
        zone = item.grid.zone
        assert item.to_world(48.0, 12.1, 0.0) == pytest.approx((0, 0, 0), abs=1e-6)
        item.set_zone("32U")
    assert zone == 32
    with pytest.raises(ValueError):
        item.set_zone("north")
