"""CyberModel against the bicycle's geometry."""

import math
import pathlib

import pytest
import yaml
from cybertruck.drive.model import CyberModel, TruckGeometry
from paddock_common.settings import read

SHAPE = TruckGeometry()
MODEL = CyberModel(SHAPE)
CONFIG = pathlib.Path(__file__).resolve().parents[1] / "config" / "truck.yaml"


def test_defaults_are_those_of_the_file():
    values = yaml.safe_load(CONFIG.read_text())
    assert read(TruckGeometry, values.get, prefix="") == SHAPE
    assert set(values) == set(vars(SHAPE))


@pytest.mark.parametrize(
    "name, value, word",
    [
        ("wheelbase", 0.0, "wheelbase"),
        ("track_width", -0.4, "track_width"),
        ("wheel_radius", float("nan"), "wheel_radius"),
        ("max_speed", "fast", "max_speed"),
        ("max_acceleration", True, "max_acceleration"),
        ("max_steering", 1.2, "1.1704"),
    ],
)
def test_wrong_parameters_are_named(name, value, word):
    with pytest.raises(ValueError, match=word):
        read(TruckGeometry, lambda key, default: value if key == name else default, prefix="")


@pytest.mark.parametrize(
    "linear, angular, steering, speed",
    [
        (0.0, 0.5, 0.0, 0.0),  # no speed, no steering
        (1.0, 0.0, 0.0, 1.0),
        (0.5, 0.5, math.atan(0.508), 0.5),
        (-0.5, 0.5, -math.atan(0.508), -0.5),  # turning left backwards: wheels to the right
        (0.5, 50.0, SHAPE.max_steering, 0.5),
        (0.5, -50.0, -SHAPE.max_steering, 0.5),
        (6.0, 3.0, math.atan(0.508 * 0.5), 3.0),  # too fast: the curvature stays
        (-9.0, 0.0, 0.0, -3.0),
        (1e-300, 1.0, SHAPE.max_steering, 1e-300),
    ],
)
def test_twist(linear, angular, steering, speed):
    assert MODEL.from_twist(linear, angular) == pytest.approx((steering, speed), abs=1e-12)


@pytest.mark.parametrize("degrees", [-45, -20, -1, 0, 5, 30, 45])
def test_wheels_share_one_turning_center(degrees):
    steering, speed = math.radians(degrees), 0.8
    wheels = MODEL.wheels(steering, speed)
    curvature = math.tan(steering) / SHAPE.wheelbase
    assert MODEL.rear_curvature(steering) == pytest.approx(curvature)
    yaw_rate = speed * curvature
    for x, y, angle, spin in (
        (0.0, 0.215, 0.0, wheels.left_rear),
        (0.0, -0.215, 0.0, wheels.right_rear),
        (SHAPE.wheelbase, 0.215, wheels.left_steering, wheels.left_front),
        (SHAPE.wheelbase, -0.215, wheels.right_steering, wheels.right_front),
    ):
        # velocity of that point of the rigid body, against the wheel's direction and speed
        along, across = speed - yaw_rate * y, yaw_rate * x
        rolling = spin * SHAPE.wheel_radius
        assert (rolling * math.cos(angle), rolling * math.sin(angle)) == pytest.approx(
            (along, across), abs=1e-12
        )
    assert MODEL.curvature_of_hinges(wheels.left_steering, wheels.right_steering) == pytest.approx(
        curvature, abs=1e-12
    )


def test_spec_formula_and_joint_limits():
    """Each front wheel has the curvature 1 / (1/k -+ w/2); the inner one needs 60 degrees."""
    wheels = MODEL.wheels(SHAPE.max_steering, 1.0)
    k = math.tan(SHAPE.max_steering) / SHAPE.wheelbase
    assert wheels.left_steering == pytest.approx(math.atan(0.508 / (1 / k - 0.215)))
    assert wheels.right_steering == pytest.approx(math.atan(0.508 / (1 / k + 0.215)))
    assert math.degrees(wheels.left_steering) == pytest.approx(60.0, abs=0.1)
    assert wheels.left_steering < 1.2
    assert wheels.left_rear / wheels.right_rear == pytest.approx((1 / k - 0.215) / (1 / k + 0.215))


def test_left_and_right_are_mirror_images():
    left, right = MODEL.wheels(0.4, 1.0), MODEL.wheels(-0.4, 1.0)
    assert right.right_steering == -left.left_steering
    assert (right.right_rear, right.left_front) == (left.left_rear, left.right_front)
