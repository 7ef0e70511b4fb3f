"""The solver 'bullet', PyBullet as it is: our car's circles, friction, contacts, saved states."""

import math

import pytest
from bullet_sim.formats.sdf import world as sdf
from bullet_sim.pose import Pose
from bullet_sim.world import World
from contact_scenes import expected_slide, friction, ground, sdf_box, skid_base, slid, world_of
from driving import drive_positions, drive_velocities
from test_ode_solver import CAR, published, resolve, wheel_angles
from test_world_state import push, stays, twin_box

BASE, RADIUS, REAR, FRONT = 0.163974, 0.03, 0.08105, 0.079601  # of our car [m]
SPEED = 0.3  # [m/s]


@pytest.fixture(name="car")
def _car():
    """Our car on a plane, and its world."""
    world = World(solver="bullet")
    world.spawn(sdf.ground_plane())
    car = world.spawn_urdf("racecar", published(CAR), Pose((0.0, 0.0, 0.0)), resolve)
    world.step(500)
    yield world, car
    world.close()


def steer(car, steering, speed):
    """Command wheels and hinges for a bicycle's angle [rad]; returns its curvature [1/m]."""
    curvature = math.tan(steering) / BASE
    for end, half, ahead in (("rear", REAR, 0.0), ("front", FRONT, BASE * curvature)):
        speeds = [speed / RADIUS * math.hypot(1 - curvature * y, ahead) for y in (half, -half)]
        drive_velocities(car.joints, [f"{side}_{end}_wheel_joint" for side in SIDES], speeds)
    angles = wheel_angles(steering, BASE, FRONT)
    drive_positions(car.joints, [f"{side}_steering_hinge_joint" for side in SIDES], angles)
    return curvature


SIDES = "left", "right"


@pytest.mark.parametrize("steering", [0.15, -0.3, 0.5])
def test_a_circle_of_our_car_is_that_of_the_bicycle(car, steering):
    world, model = car
    curvature = steer(model, steering, SPEED)
    world.step(1500)
    heading, turned, way = model.pose.rpy[2], 0.0, 0.0
    for _ in range(60):
        before = model.pose.position
        world.step(50)
        turned += math.remainder(model.pose.rpy[2] - heading, 2 * math.pi)
        heading, way = model.pose.rpy[2], way + math.dist(before, model.pose.position)
    assert turned / 3.0 == pytest.approx(SPEED * curvature, rel=0.05)
    middle = math.hypot(1.0, curvature * 0.081663)  # base_link is ahead of the rear axle
    assert way / 3.0 == pytest.approx(SPEED * middle, rel=0.05)


def test_our_car_stays_where_it_is_braked(car):
    world, model = car
    steer(model, 0.0, 0.0)
    world.step(500)
    start = model.pose.position
    world.step(5000)
    assert math.dist(start, model.pose.position) < 1e-3 / 12  # 1 mm in a minute


@pytest.mark.parametrize("box_mu, ground_mu", [(0.5, 1.0), (0.5, 0.6), (0.5, 100.0)])
def test_friction_of_a_pair_is_the_product(box_mu, ground_mu):
    mu = box_mu * min(ground_mu, 1.0)  # of what is static: at most 1
    x = slid(friction(box_mu), ground_mu, 0.8, solver="bullet")
    assert x == pytest.approx(expected_slide(mu, 0.8), rel=0.03)


def test_what_rests_has_its_weight_on_the_ground():
    world = world_of(
        (ground(), None), (sdf_box("box", (0.4, 0.4, 0.2), 3.0), None), solver="bullet"
    )
    box, engine = world.models["box"], world.engine
    box.set_state(Pose((0.0, 0.0, 0.1)))
    world.step(500)
    total = sum(contact.force for contact in box.body.contacts(box.root))
    assert total == pytest.approx((0.0, 0.0, 3.0 * 9.81), abs=0.2)
    assert {other for _, other, _, _ in box.body.touching()} == {world.models["floor"].body.number}
    places, normals, forces = engine.all_contacts()
    assert len(places) == len(normals) == len(forces) and forces.sum() == pytest.approx(
        29.43, abs=0.2
    )
    world.close()


def made(*models):
    """A function that makes a world of (description, Pose) pairs."""
    return lambda: world_of((ground(), None), *models, solver="bullet")


@pytest.mark.parametrize(
    "make, exact",
    [
        (made((sdf_box("b0", (0.2, 0.2, 0.2)), Pose((0, 0, 0.1)))), True),
        (made((sdf_box("b0", (0.2, 0.2, 0.2)), Pose((0, 0, 0.1))),
              (sdf_box("b1", (0.2, 0.2, 0.2)), Pose((0, 0, 0.302)))), True),
        (made((twin_box("t"), Pose((0, 0, 0.1)))), False),  # saving clears the contacts
        (made((skid_base(20.0, 0.3, 0.3, 0.2, 1.0), Pose((0, 0, 0.2)))), True),
    ],
    ids=["box", "two boxes", "a link of two boxes", "wheels"],
)  # fmt: skip
@pytest.mark.parametrize("disturb", [lambda world: world.step(50), World.reset])
def test_a_saved_state_goes_on_to_the_bit(make, exact, disturb):
    stays(make, push, exact=exact, disturb=disturb)


def test_batches_do_not_matter():
    places = []
    for batches in ([700], [1] * 700, [3] * 233 + [1]):
        world = world_of(
            (ground(0.3), None),
            (sdf_box("slab", (1, 1, 0.1), surface=friction(0.8), static=True), Pose((1.5, 0, 0))),
            (sdf_box("box", (0.2, 0.2, 0.1), surface=friction(0.6)), Pose((0, 0, 0.05))),
            gravity=(4.0, 0.0, -9.0),
            solver="bullet",
        )
        for count in batches:
            world.step(count)
        places.append(world.models["box"].pose)
        world.close()
    assert places[0] == places[1] == places[2]
