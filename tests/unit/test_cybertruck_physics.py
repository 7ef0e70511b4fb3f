"""The simulated truck agrees with its kinematics: rest, circles, wheels."""

import math

import numpy as np
import pytest
from truck_sim import FRONT, HINGES, REAR, Truck

SPEED = 0.5  # [m/s]


@pytest.fixture(scope="module")
def trucks():
    """The two trucks, settled; every test begins with this state again."""
    made = {trailer: Truck(trailer) for trailer in (False, True)}
    yield made
    for truck in made.values():
        truck.world.close()


@pytest.fixture(params=[False, True], ids=["alone", "trailer"])
def truck(request, trucks):
    trucks[request.param].settle()
    return trucks[request.param]


@pytest.fixture
def alone(trucks):
    trucks[False].settle()
    return trucks[False]


@pytest.fixture
def train(trucks):
    trucks[True].settle()
    return trucks[True]


def fit_circle(points):
    """Returns the radius of the circle through points (n, 2), least squares."""
    rows = np.c_[2 * points, np.ones(len(points))]
    x, y, rest = np.linalg.lstsq(rows, (points**2).sum(axis=1), rcond=None)[0]
    return math.sqrt(rest + x * x + y * y)


def test_at_rest_for_ten_seconds(truck):
    """./run test long stands for a minute."""
    check_rest(truck, 10.0)


def check_rest(truck, seconds):
    """Creep of at most 1 mm and 0.1 degrees in half a minute, also of hinges and hitch."""
    truck.drive(0.0, 0.0, 1.0)
    start, yaw, angles = truck.position, truck.yaw, []

    def look():
        positions = truck.joints()[0]
        angles.append(
            [positions[name] for name in positions if name in HINGES or name.startswith("hitch")]
        )

    truck.drive(0.0, 0.0, seconds, look)
    assert np.linalg.norm(truck.position - start) < 1e-3 * seconds / 30.0
    assert abs(math.degrees(truck.yaw - yaw)) < 0.1 * seconds / 30.0
    assert math.degrees(np.ptp(angles, axis=0).max()) < 0.1 * seconds / 30.0
    assert truck.lifted() == []


def check_circle(truck, degrees, run_up):
    """Drives 2 m of a circle; radius, hinge angles and wheel speeds are those of the geometry.

    Args:
        truck: Truck.
        degrees: Steering angle.
        run_up: Until the circle is steady [s].
    """
    steering = math.radians(degrees)
    radius = truck.kinematics.geometry.wheelbase / math.tan(abs(steering))
    truck.drive(steering, SPEED, run_up)
    points, speeds = [], []
    seconds = 2.0 / SPEED

    def look():
        points.append(truck.position[:2])
        speeds.append([truck.joints()[1][name] for name in REAR + FRONT])

    truck.drive(steering, SPEED, seconds, look)
    assert fit_circle(np.array(points)) == pytest.approx(radius, rel=2e-3)
    wanted = truck.kinematics.wheels(steering, SPEED)
    angles = truck.joints()[0]
    assert [angles[name] for name in HINGES] == pytest.approx(
        [wanted.left_steering, wanted.right_steering], rel=1e-3
    )
    rear, front = np.mean(speeds, axis=0).reshape(2, 2)
    assert rear == pytest.approx([wanted.left_rear, wanted.right_rear], rel=1e-3)
    assert front == pytest.approx([wanted.left_front, wanted.right_front], rel=5e-3)  # free


@pytest.mark.parametrize("degrees", [-20, 40])
def test_circle(alone, degrees):
    check_circle(alone, degrees, 1.0)


# At 40 degrees the hitch runs on a circle of 0.67 m, less than the tongue is long: no trailer can
# follow that, it folds to its stop.
@pytest.mark.parametrize("degrees", [-10, 30])
def test_circle_with_trailer(train, degrees):
    """The hitch runs at hypot(R, L1) from the center, the trailer's axle points there."""
    check_circle(train, degrees, 4.0)
    shape = train.kinematics.geometry
    radius = shape.wheelbase / math.tan(math.radians(abs(degrees)))
    expected = -math.copysign(
        math.atan2(shape.hitch_offset, radius)
        + math.asin(shape.tongue_length / math.hypot(radius, shape.hitch_offset)),
        degrees,
    )
    assert train.joints()[0]["hitch_yaw_joint"] == pytest.approx(expected, abs=math.radians(1.0))


def test_hitch_is_positive_when_the_trailer_heads_left_of_the_truck(train):
    train.drive(math.radians(-20), SPEED, 3.0)
    trailer, _, _ = train.model.link_state("trailer_link")
    turned = math.remainder(trailer.rpy[2] - train.yaw, 2 * math.pi)
    assert turned > math.radians(5)
    assert train.joints()[0]["hitch_yaw_joint"] == pytest.approx(turned, abs=1e-3)
    axle, _, _ = train.model.link_state("trailer_axle")
    hitch = np.array(trailer.position[:2])
    tongue = np.linalg.norm(hitch - axle.position[:2])
    assert tongue == pytest.approx(train.kinematics.geometry.tongue_length, abs=1e-4)
    assert axle.position[2] == pytest.approx(0.0, abs=2e-3)


def test_manoeuvres_keep_all_wheels_down_and_the_hitch_smooth(train):
    """Pulling away, stopping from 1.5 m/s, full lock both ways; looked at in every step."""
    lifted, jumps, last = set(), [0.0], {}

    def look():
        lifted.update(train.lifted())
        for name, angle in train.joints()[0].items():
            if name.startswith("hitch"):
                jumps.append(abs(angle - last.get(name, angle)))
                last[name] = angle

    lock = train.kinematics.geometry.max_steering
    for steering, speed, seconds in (
        (0, 1.5, 1.2),
        (0, 0, 1.2),
        (lock, 1.0, 1.2),
        (-lock, 1.0, 1.4),
        (0, 1.5, 1.0),
        (lock, 1.5, 0.8),
        (0, 0, 1.2),
        (0, -0.5, 0.6),
    ):
        train.drive(steering, speed, seconds, look, every=1)
    assert lifted == set()
    assert math.degrees(max(jumps)) < 0.5


def test_it_stops_from_full_speed_as_fast_as_its_limit_says(alone):
    speed, limit = 1.5, alone.kinematics.geometry.max_acceleration
    alone.drive(0.0, speed, 2.0)
    start = alone.position
    alone.drive(0.0, 0.0, speed / limit + 0.3)
    assert alone.position[0] - start[0] == pytest.approx(speed**2 / (2 * limit), rel=0.05)
    assert abs(alone.joints()[1][REAR[0]]) < 0.01
