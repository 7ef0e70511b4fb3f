"""Skid steering against the balance of friction: bounded by a pyramid, and by a cone."""

import functools
import math

import numpy as np
import pytest
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.models.contacts import needs_cone, skid_wheels
from bullet_sim.pose import Pose
from contact_scenes import ground, nowhere, skid_base, world_of
from scipy.optimize import fsolve

world_of = functools.partial(world_of, solver="bullet")

WHEEL_MASS = 0.05  # of the base's mass
CONE = "1 0 0"  # fdir1 of wheels that have the cone


def drive(world, left, right, radius, effort=1e4):
    """Let the wheels of the two sides turn at rim speeds [m/s]."""
    model = world.models["skid"]
    for name, speed in (("fl", left), ("rl", left), ("fr", right), ("rr", right)):
        number = model.joints.names.index(name)
        world.engine.drive_velocity(model.body, number, speed / radius, effort)


def turned(
    mass, half_base, half_track, left, right, radius=0.1, round_wheels=True, time=1.5, fdir1=CONE
):
    """Rate of turn [rad/s] and speed [m/s], means over the last half second."""
    base = skid_base(
        mass,
        half_base,
        half_track,
        radius,
        WHEEL_MASS * mass,
        round_wheels=round_wheels,
        fdir1=fdir1,
    )
    world = world_of((ground(), None), (base, Pose((0, 0, radius))))
    drive(world, left, right, radius)
    world.step(round((time - 0.5) * 1000))
    rates, speeds = [], []
    for _ in range(50):
        world.step(10)
        _, _, linear, angular = world.models["skid"].link_motion("base")
        rates.append(angular[2])
        speeds.append(math.hypot(linear[0], linear[1]))
    world.close()
    return sum(rates) / 50, sum(speeds) / 50


def balance(mass, half_base, half_track, left, right, height, mu=0.8, gravity=9.81):
    """Steady turn of a base on four wheels: forces, moment and shift of load, solved numerically.

    Returns:
        Rate of turn [rad/s] and speed [m/s].
    """
    a, b = half_base, half_track

    def left_over(state):
        forward, sideways, rate = state
        ax, ay = -sideways * rate, forward * rate
        force_x = force_y = moment = 0.0
        for x, y, rim in ((a, b, left), (a, -b, right), (-a, b, left), (-a, -b, right)):
            load = mass * (
                gravity / 4
                - math.copysign(ay * height / (4 * b), y)
                - math.copysign(ax * height / (4 * a), x)
            )
            slip = (forward - rate * y - rim, sideways + rate * x)
            size = math.hypot(*slip) + 1e-9
            fx, fy = (-mu * load * s / size for s in slip)
            force_x, force_y, moment = force_x + fx, force_y + fy, moment + x * fy - y * fx
        return force_x - mass * ax, force_y - mass * ay, moment

    start = ((left + right) / 2, 0.0, (right - left) / 2 * b / (a * a + b * b))
    forward, sideways, rate = fsolve(left_over, start)
    return rate, math.hypot(forward, sideways)


@pytest.mark.parametrize(
    "mass, ratio, speed",
    [
        (20.0, 0.5, 0.3),
        (20.0, 1.0, 0.1),
        (20.0, 1.0, 0.3),
        (20.0, 1.0, 2.0),
        (20.0, 1.5, 0.3),
        (2.0, 0.5, 0.1),
        (2.0, 1.5, 1.0),
        (60.0, 1.0, 0.5),
        (60.0, 1.5, 2.0),
    ],
)
@pytest.mark.parametrize("round_wheels", [True, False])
def test_turning_on_the_spot(mass, ratio, speed, round_wheels):
    """omega = b v / (a^2 + b^2), whatever mass and friction are."""
    b = 0.2
    a = ratio * b
    rate, _ = turned(mass, a, b, -speed, speed, round_wheels=round_wheels)
    assert rate == pytest.approx(b * speed / (a * a + b * b), rel=0.1)


@pytest.mark.parametrize(
    "mass, ratio, left, right",
    [(20.0, 1.0, 0.3, 0.6), (20.0, 1.0, 1.0, 2.0), (60.0, 1.0, 0.0, 0.5), (2.0, 1.5, 0.4, 1.2)],
)
def test_arcs(mass, ratio, left, right):
    b, radius = 0.2, 0.1
    rate, speed = turned(mass, ratio * b, b, left, right, time=2.5)
    wanted, wanted_speed = balance(
        mass * (1 + 4 * WHEEL_MASS), ratio * b, b, left, right, height=radius
    )
    assert rate == pytest.approx(wanted, rel=0.1)
    assert speed == pytest.approx(wanted_speed, rel=0.1)


def pyramid(mass, half_base, half_track, left, right, mu=0.8, time=1.5, gravity=9.81):
    """Mean rate [rad/s] over the last half second of a plate on four wheels of equal load.

    Each wheel's friction is bounded along the world's x and y separately; below 1 mm/s of slip it
    rises linearly. The equations of motion are integrated in steps of 0.1 ms.
    """
    a, b, step = half_base, half_track, 1e-4
    wheels = np.array([(a, b), (a, -b), (-a, b), (-a, -b)])
    rims = np.array([left, right, left, right])
    load = mu * mass * gravity / 4
    spin = mass * ((2 * a) ** 2 + (1.9 * b) ** 2) / 12  # the base's inertia in contact_scenes
    spin += mass * WHEEL_MASS * 4 * (a * a + b * b)
    velocity, heading, rate, rates = np.zeros(2), 0.0, 0.0, []
    for number in range(round(time / step)):
        c, s = math.cos(heading), math.sin(heading)
        places = wheels @ np.array([[c, s], [-s, c]])
        slip = velocity + rate * np.column_stack((-places[:, 1], places[:, 0]))
        slip -= rims[:, None] * (c, s)
        force = -load * np.clip(slip / 1e-3, -1.0, 1.0)
        velocity = velocity + force.sum(0) / (mass * (1 + 4 * WHEEL_MASS)) * step
        rate += float((places[:, 0] * force[:, 1] - places[:, 1] * force[:, 0]).sum()) / spin * step
        heading += rate * step
        if number * step >= time - 0.5:
            rates.append(rate)
    return float(np.mean(rates))


@pytest.mark.parametrize("round_wheels", [True, False])
@pytest.mark.parametrize(
    "mass, ratio, left, right",
    [(20.0, 0.5, -0.3, 0.3), (20.0, 0.9, -0.3, 0.3), (2.0, 0.8, -1.0, 1.0), (60.0, 0.7, 0.2, 0.6)],
)
def test_a_pyramid_bounds_friction_along_each_axis_of_the_ground(
    mass, ratio, left, right, round_wheels
):
    b = 0.2
    wanted = pyramid(mass, ratio * b, b, left, right)
    rate, _ = turned(mass, ratio * b, b, left, right, round_wheels=round_wheels, fdir1="")
    assert rate == pytest.approx(wanted, rel=0.1)


def vehicle(steering="", wheel=""):
    """Model of a base with one wheel below a swivel joint; XML to add to both of them."""
    inertial = (
        '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
        "</inertial>"
    )
    text = (
        f'<robot name="v"><link name="base">{inertial}</link><link name="fork">{inertial}</link>'
        f'<link name="wheel">{inertial}<collision><geometry><sphere radius="0.1"/></geometry>'
        '</collision></link><joint name="swivel" type="continuous"><parent link="base"/>'
        '<child link="fork"/><axis xyz="0 0 1"/></joint><joint name="axle" type="continuous">'
        '<parent link="fork"/><child link="wheel"/><axis xyz="0 1 0"/></joint>'
    )
    if steering == "limits":
        text = text.replace(
            '"swivel" type="continuous">',
            '"swivel" type="revolute"><limit lower="-1" upper="1" effort="1" velocity="1"/>',
        )
    elif steering:
        text += (
            f'<transmission name="t"><type>transmission_interface/SimpleTransmission</type><joint '
            f'name="{steering}"><hardwareInterface>hardware_interface/EffortJointInterface'
            '</hardwareInterface></joint><actuator name="m"/></transmission>'
        )
    text += f'<gazebo reference="wheel">{wheel}</gazebo></robot>'
    return parse_urdf(text, nowhere, "v")


@pytest.mark.parametrize(
    "steering, wheel, wanted",
    [
        ("", "", False),  # a castor
        ("axle", "", False),
        ("limits", "", True),
        ("swivel", "", True),
        ("", "<mu1>0.5</mu1><mu2>0.4</mu2><fdir1>1 0 0</fdir1>", False),
    ],
)
def test_steered_wheels_need_the_cone(steering, wheel, wanted):
    world = world_of((vehicle(steering, wheel), None))
    assert needs_cone(world.models["v"]) is wanted
    world.close()


@pytest.mark.parametrize("fdir1, wanted", [("", False), ("1 0 0", True)])
def test_wheels_that_skid_with_a_direction_of_friction_need_the_cone(fdir1, wanted):
    world = world_of((skid_base(20.0, 0.2, 0.2, 0.1, 1.0, fdir1=fdir1), None))
    assert needs_cone(world.models["skid"]) is wanted
    world.close()


def test_acceleration_straight_ahead_is_what_the_efforts_allow():
    """a = 4 tau / r / (m + 4 I / r^2) below the friction limit."""
    mass, radius, effort = 20.0, 0.1, 1.0
    base = skid_base(mass, 0.2, 0.2, radius, 1.0)
    world = world_of((ground(), None), (base, Pose((0, 0, radius))))
    world.step(200)
    drive(world, 50.0, 50.0, radius, effort)
    world.step(1000)
    speed = world.models["skid"].link_motion("base")[2][0]
    world.close()
    inertia = 1.0 * radius**2 / 2
    expected = 4 * effort / radius / (mass + 4 + 4 * inertia / radius**2)
    assert speed == pytest.approx(expected, rel=0.1)


def test_wheels_of_a_skid_steered_base_are_found_and_others_are_not():
    base = skid_base(20.0, 0.2, 0.2, 0.1, 1.0)
    joints = list(base.joints.values())
    assert skid_wheels(joints, base.links) == ["fl", "fr", "rl", "rr"]
    assert skid_wheels(joints[:2], base.links) == []  # one axle
    steered = [j for j in joints if j.child.startswith("r")]  # the front axle hangs elsewhere
    assert skid_wheels(steered, base.links) == []
