"""A four-wheeled car with Ackermann steering drives where kinematics says it does."""

import math

import numpy as np
import pytest
from bullet_sim.formats.sdf import world as sdf
from bullet_sim.pose import Pose
from bullet_sim.world import World

BASE, TRACK_FRONT, TRACK_REAR, RADIUS = 0.163974, 0.159202, 0.1621, 0.03
REAR = -0.081663  # x of the rear axle
WHEELS = {
    "left_rear": (0.0, TRACK_REAR / 2),
    "right_rear": (0.0, -TRACK_REAR / 2),
    "left_front": (BASE, TRACK_FRONT / 2),
    "right_front": (BASE, -TRACK_FRONT / 2),
}
SOFT = "<kp>1e6</kp><kd>100</kd><fdir1>0 0 1</fdir1>"
HINGES = ("left_hinge", "right_hinge")


def link(name, mass, moments, collision="", mu=""):
    """URDF of a link; a mu becomes a <gazebo> block."""
    x, y, z = moments
    text = (
        f'<link name="{name}"><inertial><mass value="{mass}"/><inertia ixx="{x}" ixy="0" '
        f'ixz="0" iyy="{y}" iyz="0" izz="{z}"/></inertial>{collision}</link>'
    )
    if mu:
        text += f'<gazebo reference="{name}"><mu1>{mu}</mu1><mu2>{mu}</mu2>{SOFT}</gazebo>'
    return text


def joint(name, kind, parent, child, xyz, axis, limits=""):
    """URDF of a joint."""
    return (
        f'<joint name="{name}" type="{kind}"><origin xyz="{xyz}"/><parent link="{parent}"/>'
        f'<child link="{child}"/><axis xyz="{axis}"/>'
        f'<limit effort="10" velocity="100" {limits}/></joint>'
    )


def car_urdf():
    """DeepRacer's numbers; the hubs' different heights tilt its kingpins by 1.4 degrees.

    The wheels touch as docs/physics.md has it for a car that drives what it steers.
    """
    cylinder = (
        '<collision><origin rpy="1.5707963267948966 0 0"/><geometry><cylinder '
        f'radius="{RADIUS}" length="0.004"/></geometry></collision>'
    )
    parts = [link("chassis", 1.9068, (0.004151895, 0.010379737, 0.010379737))]
    for side in ("left", "right"):
        front, rear = WHEELS[side + "_front"], WHEELS[side + "_rear"]
        parts += [
            link(side + "_hinge", 0.05, (1e-5, 1e-5, 1e-5)),
            joint(
                side + "_hinge",
                "revolute",
                "chassis",
                side + "_hinge",
                f"{REAR + BASE} {front[1]} 0.011759",
                "0 0 1",
                'lower="-1.05" upper="1.05"',
            ),
            joint(
                side + "_front",
                "continuous",
                side + "_hinge",
                side + "_front_wheel",
                "0 0 0",
                "0 1 0",
            ),
            joint(
                side + "_rear",
                "continuous",
                "chassis",
                side + "_rear_wheel",
                f"{REAR} {rear[1]} 0.01575",
                "0 1 0",
            ),
        ]
        parts += [
            link(side + end, 0.042222, (6.11771e-5, 9.44606e-5, 6.11771e-5), cylinder, 0.5)
            for end in ("_front_wheel", "_rear_wheel")
        ]
    plugin = '<gazebo><plugin name="c" filename="libgazebo_ros_control.so"/></gazebo>'
    return f'<robot name="car">{"".join(parts)}{plugin}</robot>'


class Car:
    """The car on the ground plane."""

    def __init__(self):
        self.world = World()
        self.world.engine.set_solver_iterations(100)  # as track.world
        self.world.spawn(sdf.ground_plane())
        self.model = self.world.spawn_urdf("car", car_urdf(), Pose((0, 0, 0.0145)), str)

    def engage(self):
        """Start a controller on every joint, and settle."""
        kinds = [(name, "velocity") for name in WHEELS] + [(name, "position") for name in HINGES]
        for name, kind in kinds:
            self.model.manager.load(
                name,
                {"type": f"{kind}_controllers/Joint{kind.capitalize()}Controller", "joint": name},
            )
        self.model.manager.switch([name for name, _ in kinds], [])
        self.run(0.3)

    def run(self, seconds):
        self.world.step(round(seconds / self.world.time_step))

    @property
    def rear_axle(self):
        """Position (2,) of the rear axle's middle [m]."""
        return np.array((self.model.pose * Pose((REAR, 0, 0))).position[:2])

    def drive(self, speed, curvature=0.0):
        """Command every wheel and hinge for the rear axle's middle to follow that curvature."""
        for name, (x, y) in WHEELS.items():
            along, across = speed * (1 - curvature * y), speed * curvature * x
            self.model.manager.command(name, [math.hypot(along, across) / RADIUS])
            if x:
                self.model.manager.command(
                    name.replace("front", "hinge"), [math.atan2(across, along)]
                )


@pytest.fixture
def car():
    made = Car()
    yield made
    made.world.close()


def fit_circle(points):
    """Center (2,) and radius of the circle through points (n, 2), least squares."""
    rows = np.c_[2 * points, np.ones(len(points))]
    x, y, rest = np.linalg.lstsq(rows, (points**2).sum(axis=1), rcond=None)[0]
    return np.array([x, y]), math.sqrt(rest + x * x + y * y)


def test_straight(car):
    car.engage()
    start = car.rear_axle
    car.drive(10 * RADIUS)
    car.run(1.0)
    middle = car.rear_axle
    car.run(1.0)
    end = car.rear_axle
    assert np.linalg.norm(middle - start) == pytest.approx(0.3, rel=0.05)
    assert np.linalg.norm(end - middle) == pytest.approx(0.3, rel=0.01)
    assert abs(math.degrees(car.model.pose.rpy[2])) < 0.2


@pytest.mark.parametrize("degrees, speed", [(5, 1.0), (-10, 1.0), (20, 0.5), (-20, 1.0), (30, 0.5)])
def test_circle_radius_and_drift(car, degrees, speed):
    curvature = math.tan(math.radians(degrees)) / BASE
    lap = 2 * math.pi / abs(speed * curvature)
    car.engage()
    car.drive(speed, curvature)
    car.run(0.5)
    points = []
    for _ in range(40):  # one lap
        car.run(lap / 40)
        points.append(car.rear_axle)
    _, radius = fit_circle(np.array(points))
    (first, _), (second, _) = (
        fit_circle(np.array(points[:20])),
        fit_circle(np.array(points[20:])),
    )
    assert radius * abs(curvature) == pytest.approx(1.0, rel=0.01)
    assert np.linalg.norm(second - first) < 0.01 / 2 * radius  # within half a lap


@pytest.mark.parametrize("engaged", [True, False])
def test_stays_where_it_stands(car, engaged):
    if engaged:
        car.engage()
    car.run(1.0)
    start = car.rear_axle
    car.run(5.0)
    assert np.linalg.norm(car.rear_axle - start) < 1e-3 / 12  # 1 mm in a minute


def test_uncontrolled_wheels_yield_to_effort(car):
    for _ in range(500):
        for name in WHEELS:
            car.model.body.motor(name).add_effort(0.01)
        car.run(0.001)
    assert car.rear_axle[0] - REAR > 0.03
