"""The trailer's kinematics against rigid bodies under constraints, a published model, and signs."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from cybertruck.trailer.geometry import (
    Geometry,
    TrailerError,
    backing_limit,
    has_steady_towing,
    jackknife_angle,
    steady_hitch_angle,
    steady_trailer,
    towing_curvature,
    towing_limit,
    trailer_curvature_limit,
)
from cybertruck.trailer.kinematics import hitch_position, rear_axle, trailer_axle
from cybertruck.trailer.laws import curvature_law, hitch_law
from trailer_sim import advance, derivative, hitch_rate, trailer_curvature
from vehiclemodels.vehicle_dynamics_kst import vehicle_dynamics_kst

OFF_AXLE = Geometry()
ON_AXLE = Geometry(hitch_offset=0.0)
TIGHT = Geometry(max_steering=math.atan(0.508 / 0.8))  # Fmax = 1/0.8 per meter


def rigid_body_rates(poses, speed, steering, geometry):
    """Velocities of two rigid bodies from their constraints alone, as one linear system.

    Args:
        poses: (6,) x, y, heading of the truck at C and of the trailer at its hitch.

    Returns:
        (6,) the rates of `poses`.
    """
    _, _, truck, _, _, trailer = poses

    def point(body, ahead, heading):
        """Rows (2, 6) that give the velocity of a point `ahead` of a body's reference."""
        rows = np.zeros((2, 6))
        rows[0, body], rows[1, body + 1] = 1.0, 1.0
        rows[:, body + 2] = -ahead * math.sin(heading), ahead * math.cos(heading)
        return rows

    def along(heading):
        return np.array((math.cos(heading), math.sin(heading)))

    def across(heading):
        return np.array((-math.sin(heading), math.cos(heading)))

    hitch = point(0, -geometry.hitch_offset, truck) - point(3, 0.0, trailer)
    matrix = np.vstack(
        (
            along(truck) @ point(0, 0.0, truck),  # given speed
            across(truck) @ point(0, 0.0, truck),  # rear wheels
            across(truck + steering) @ point(0, geometry.wheelbase, truck),  # front wheels
            hitch,  # two bodies, one pin
            across(trailer) @ point(3, -geometry.tongue_length, trailer),
        )
    )  # trailer's wheels
    return np.linalg.solve(matrix, np.array((speed, 0.0, 0.0, 0.0, 0.0, 0.0)))


@pytest.mark.parametrize("geometry", (OFF_AXLE, ON_AXLE, Geometry(hitch_offset=0.9)))
@pytest.mark.parametrize("seed", range(5))
def test_rates_equal_rigid_bodies_under_constraints(geometry, seed):
    random = np.random.default_rng(seed)
    heading, hitch, steering = random.uniform(-1.2, 1.2, 3)
    speed = random.choice((-0.4, 0.7))
    curvature = math.tan(0.6 * steering) / geometry.wheelbase
    trailer = heading + hitch
    poses = (0.0, 0.0, heading, *hitch_position(0.0, 0.0, heading, geometry), trailer)
    rates = rigid_body_rates(poses, speed, 0.6 * steering, geometry)
    state = np.array((0.0, 0.0, heading, hitch))
    expected = (*rates[:3], rates[5] - rates[2])
    assert derivative(state, speed, curvature, geometry) == pytest.approx(expected, abs=1e-12)
    ahead = np.array((math.cos(trailer), math.sin(trailer)))
    axle = rates[3:5] + geometry.tongue_length * rates[5] * np.array((ahead[1], -ahead[0]))
    assert trailer_curvature(hitch, curvature, geometry) == pytest.approx(
        rates[5] / (axle @ ahead), abs=1e-9
    )


def published_parameters(geometry):
    """What the published model reads, with limits that never bind here."""
    steering = SimpleNamespace(min=-1.5, max=1.5, v_min=-9.0, v_max=9.0)
    longitudinal = SimpleNamespace(v_min=-9.0, v_max=9.0, v_switch=8.0, a_max=9.0)
    return SimpleNamespace(
        a=0.2,
        b=geometry.wheelbase - 0.2,
        steering=steering,
        longitudinal=longitudinal,
        trailer=SimpleNamespace(l_wb=geometry.tongue_length),
    )


def test_on_axle_equals_the_published_single_track_model_with_trailer():
    random = np.random.default_rng(3)
    parameters = published_parameters(ON_AXLE)
    for _ in range(300):
        x, y, heading = random.uniform(-3.0, 3.0, 3)
        steering, speed = random.uniform(-0.78, 0.78), random.uniform(-1.0, 1.0)
        hitch = random.uniform(-1.5, 1.5)
        theirs = vehicle_dynamics_kst(
            [x, y, steering, speed, heading, hitch], [0.0, 0.0], parameters
        )
        ours = derivative(
            np.array((x, y, heading, hitch)), speed, math.tan(steering) / ON_AXLE.wheelbase, ON_AXLE
        )
        np.testing.assert_allclose(
            ours, [theirs[0], theirs[1], theirs[4], theirs[5]], atol=1e-9, rtol=0
        )


def test_trailer_and_truck_places_are_inverse():
    place = trailer_axle(0.4, -0.7, 2.0, 0.5, OFF_AXLE)
    assert rear_axle(*place, 0.5, OFF_AXLE) == pytest.approx((0.4, -0.7, 2.0), abs=1e-14)


def test_the_law_sets_the_target_trailer_curvature():
    random = np.random.default_rng(5)
    target, hitch = random.uniform(-1.0, 1.0, 500), random.uniform(-0.9, 0.9, 500)
    inside = np.abs(hitch + np.arctan(0.7 * target)) < 1.4
    curvature = curvature_law(target, hitch, OFF_AXLE)
    made = trailer_curvature(hitch, curvature, OFF_AXLE)
    assert inside.sum() > 400
    np.testing.assert_allclose(made[inside], target[inside], atol=1e-11, rtol=0)
    fraction = (target * 0.7 * np.cos(hitch) + np.sin(hitch)) / (
        target * 0.3 * 0.7 * np.sin(hitch) - 0.3 * np.cos(hitch)
    )
    np.testing.assert_allclose(curvature[inside], fraction[inside], rtol=1e-9)


def test_beyond_a_right_angle_the_law_unfolds():
    for hitch, target in ((1.3, 0.8), (-1.3, -0.8)):
        curvature = curvature_law(target, hitch, OFF_AXLE)
        assert np.sign(curvature) == -np.sign(hitch)


@pytest.mark.parametrize("geometry", (OFF_AXLE, ON_AXLE))
def test_hitch_law_makes_the_error_decay_along_arc_length(geometry):
    for hitch in (-0.8, -0.1, 0.5):
        curvature = hitch_law(0.2, hitch, 0.4, geometry)
        assert hitch_rate(-1.0, hitch, curvature, geometry) == pytest.approx(
            -(hitch - 0.2) / 0.4, abs=1e-12
        )


def test_jackknife_angle():
    assert math.degrees(jackknife_angle(TIGHT)) == pytest.approx(75.6, abs=0.05)
    assert jackknife_angle(OFF_AXLE) is None
    angle = jackknife_angle(TIGHT)
    for beyond, sign in ((-0.01, -1), (0.01, 1)):  # backing with the steering that unfolds most
        rate = hitch_rate(-1.0, angle + beyond, -TIGHT.max_curvature, TIGHT)
        assert np.sign(rate) == sign
    angles = np.linspace(0.0, OFF_AXLE.hitch_stop, 50)
    assert np.all(hitch_rate(-1.0, angles, -OFF_AXLE.max_curvature, OFF_AXLE) < 0.0)


def test_backing_limit_is_the_nearer_of_stop_and_jackknife():
    assert backing_limit(OFF_AXLE, 0.1) == pytest.approx(math.radians(80.0) - 0.1)
    assert math.degrees(backing_limit(TIGHT, 0.0)) == pytest.approx(75.6, abs=0.05)


def test_steady_towing():
    assert not has_steady_towing(OFF_AXLE.max_curvature, OFF_AXLE)  # 0.59 m < 0.70 m
    assert math.isnan(steady_hitch_angle(OFF_AXLE.max_curvature, OFF_AXLE))
    edge = 1.0 / math.sqrt(0.7**2 - 0.3**2)
    assert has_steady_towing(0.999 * edge, OFF_AXLE) and not has_steady_towing(
        1.001 * edge, OFF_AXLE
    )
    curvatures = np.array((-1.2, -0.4, 0.0, 0.3, 1.2))
    angles = steady_hitch_angle(curvatures, OFF_AXLE)
    np.testing.assert_allclose(hitch_rate(1.0, angles, curvatures, OFF_AXLE), 0.0, atol=1e-12)
    np.testing.assert_allclose(towing_curvature(angles, OFF_AXLE), curvatures, atol=1e-12)


def test_towing_limit_keeps_the_hitch_angle():
    limit = towing_limit(OFF_AXLE)
    assert limit < OFF_AXLE.max_curvature
    assert steady_hitch_angle(limit, OFF_AXLE) == pytest.approx(-math.radians(45.0), abs=1e-12)
    state = np.zeros(4)
    for _ in range(3000):
        state = advance(state, 0.5, limit, 0.01, OFF_AXLE)
    assert state[3] == pytest.approx(-math.radians(45.0), abs=1e-3)


@pytest.mark.parametrize("geometry", (OFF_AXLE, ON_AXLE))
def test_steady_trailer_circle(geometry):
    target = np.array((-0.8, -0.2, 0.0, 0.5))
    curvature, angle = steady_trailer(target, geometry)
    np.testing.assert_allclose(hitch_rate(1.0, angle, curvature, geometry), 0.0, atol=1e-12)
    np.testing.assert_allclose(trailer_curvature(angle, curvature, geometry), target, atol=1e-12)
    limit = trailer_curvature_limit(0.6, geometry)
    assert steady_trailer(limit, geometry)[1] == pytest.approx(-0.6, abs=1e-12)


@pytest.mark.parametrize(
    "field, value",
    (
        ("wheelbase", 0.0),
        ("wheelbase", math.nan),
        ("hitch_offset", -0.1),
        ("tongue_length", "0.7"),
        ("max_steering", 1.6),
        ("hitch_stop", 0.0),
    ),
)
def test_bad_geometry_is_refused_by_name_and_value(field, value):
    with pytest.raises(TrailerError) as caught:
        Geometry(**{field: value})
    assert field in str(caught.value) and repr(value) in str(caught.value)
