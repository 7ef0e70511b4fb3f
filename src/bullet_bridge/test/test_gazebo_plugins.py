"""Gazebo's own plugins that act without a command of its transport, without a ROS master."""

import pytest
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.plugins.gazebo import InitialVelocitySpec, StandingWheelsSpec
from bullet_sim.pose import Pose
from bullet_sim.world import World
from fake_impl import plugin_of

LINK = (
    '<link name="{}"><inertial><mass value="1"/><inertia ixx="0.1" iyy="0.1" izz="0.1"/>'
    "</inertial></link>"
)
JOINT = (
    '<joint name="{0}" type="continuous"><parent link="base"/><child link="{0}_link"/>'
    '<axis xyz="0 1 0"/></joint>'
)
PLUGIN = '<gazebo><plugin name="p" filename="lib{}.so">{}</plugin></gazebo>'
WHEELS = "<left_joint>left</left_joint><right_joint>{}</right_joint>"


def robot(library, tags):
    links = "".join(map(LINK.format, ("base", "left_link", "right_link")))
    joints = "".join(map(JOINT.format, ("left", "right")))
    return f'<robot name="r">{links}{joints}{PLUGIN.format(library, tags)}</robot>'


@pytest.fixture(name="world")
def _world():
    world = World(gravity=(0.0, 0.0, 0.0))
    yield world
    world.close()


def prepared(world, text):
    model = world.spawn_urdf("r", text, Pose((0.0, 0.0, 1.0)), str)
    plugin = plugin_of(world, model, model.description.sensors[0])
    plugin.prepare()
    assert not plugin.needs_update()
    return model


def test_wheels_without_a_command_stand(world):
    found = parse_urdf(robot("DiffDrivePlugin", WHEELS.format("right")), str)
    assert found.sensors == [StandingWheelsSpec("p", "base", ("left", "right"))]
    assert "Gazebo's own transport" in found.warnings[-1]
    lacking = parse_urdf(robot("DiffDrivePlugin", WHEELS.format("nose")), str)
    assert lacking.sensors == [] and "nose" in lacking.warnings[-1]
    model = prepared(world, robot("DiffDrivePlugin", WHEELS.format("right")))
    for _ in range(100):
        model.joints.add_effort("left", 5.0)
        world.step()
    assert model.joints.state()[0] == pytest.approx({"left": 0.0, "right": 0.0}, abs=0.02)


def test_a_model_begins_with_its_velocity(world):
    tags = "<linear>1 0 0.5</linear><angular>0 0 2</angular>"
    (spec,) = parse_urdf(robot("InitialVelocityPlugin", tags), str).sensors
    assert spec == InitialVelocitySpec("p", "base", (1.0, 0.0, 0.5), (0.0, 0.0, 2.0))
    model = prepared(world, robot("InitialVelocityPlugin", tags))
    world.step(500)
    assert model.pose.position == pytest.approx((0.5, 0.0, 1.25), abs=0.01)
    assert model.pose.rpy[2] == pytest.approx(1.0, abs=0.01)
