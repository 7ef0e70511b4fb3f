"""What SDF 1.4 to 1.6 have and 1.7 has no more, as sdformat 9 converts it: `gz sdf -p` of Gazebo
11.1. In a version that does not have it, it has no effect."""

import pytest
from bullet_sim.formats.sdf.world import parse_model, parse_world


@pytest.mark.parametrize("version, found", [("1.4", -1.6), ("1.5", -1.6), ("1.6", -9.8)])
def test_gravity_within_physics(version, found):
    physics = "<physics type='ode'><gravity>0 0 -1.6</gravity></physics>"
    text = f'<sdf version="{version}"><world name="w">{physics}</world></sdf>'
    assert parse_world(text, str).gravity == (0.0, 0.0, found)


@pytest.mark.parametrize("version, x, turned", [("1.6", 1.0, False), ("1.7", 0.0, True)])
def test_names_that_a_version_no_longer_has(version, x, turned):
    """<pose frame> and <use_parent_model_frame> of 1.6 in 1.7."""
    text = (
        f'<sdf version="{version}"><model name="m"><link name="a"><pose>1 0 0 0 0 0</pose></link>'
        '<link name="b"><pose frame="a">0 2 0 0 0 1.5707963267948966</pose></link>'
        '<joint name="j" type="revolute"><parent>a</parent><child>b</child><axis><xyz>1 0 0</xyz>'
        "<use_parent_model_frame>1</use_parent_model_frame></axis></joint></model></sdf>"
    )
    model, _ = parse_model(text, str)
    assert model.poses()["b"].position == pytest.approx((x, 2, 0))
    axis = (1.0, 0.0, 0.0) if turned else (0.0, -1.0, 0.0)
    assert model.joints["j"].axis == pytest.approx(axis)


@pytest.mark.parametrize("attribute", ["frame", "relative_to"])
def test_poses_in_a_frame(attribute):
    text = (
        '<sdf version="1.6"><model name="m"><link name="a"><pose>1 0 0 0 0 0</pose></link>'
        f'<link name="b"><pose {attribute}="a">0 2 0 0 0 0</pose></link>'
        '<joint name="j" type="fixed"><parent>a</parent><child>b</child></joint></model></sdf>'
    )
    model, _ = parse_model(text, str)
    pose = model.root_pose * model.joints["j"].origin
    assert pose.position == pytest.approx((1, 2, 0)) and model.warnings == []


@pytest.mark.parametrize("version, factor", [("1.4", 1.0), ("1.5", 1.0), ("1.6", 0.0)])
def test_noise_of_an_imu_for_all_axes(version, factor):
    noise = (
        "<noise><type>gaussian</type><rate><mean>0.1</mean><stddev>0.2</stddev></rate>"
        "<accel><mean>0.3</mean><stddev>0.4</stddev></accel></noise>"
    )
    plugin = '<plugin filename="libgazebo_ros_imu_sensor.so"><frameName>a</frameName></plugin>'
    text = (
        f'<sdf version="{version}"><model name="m"><link name="a"><sensor name="s" type="imu">'
        f"<imu>{noise}</imu>{plugin}</sensor></link></model></sdf>"
    )
    (spec,) = parse_model(text, str)[0].sensors
    found = spec.gyro_noise_mean, spec.gyro_noise_stddev
    found += spec.accel_noise_mean, spec.accel_noise_stddev
    assert found == pytest.approx(tuple(factor * value for value in (0.1, 0.2, 0.3, 0.4)))


@pytest.mark.parametrize("root, version", [("gazebo", "1.2"), ("sdf", "1.2"), ("sdf", "1.3")])
def test_physics_of_the_first_versions(root, version):
    physics = (
        "<physics type='ode'><update_rate>100</update_rate><ode><solver><dt>0.005</dt></solver>"
        "</ode></physics>"
    )
    model = "<model name='m'><link name='l'/></model>"
    text = f'<{root} version="{version}"><world name="w">{physics}{model}</world></{root}>'
    world = parse_world(text, str)
    assert (world.step, world.real_time_factor) == pytest.approx((0.005, 0.5))
    assert [model.name for model, _ in world.models] == ["m"]


def test_later_versions_have_no_such_physics():
    physics = "<physics type='ode'><ode><solver><dt>0.005</dt></solver></ode></physics>"
    text = f'<sdf version="1.4"><world name="w">{physics}</world></sdf>'
    assert parse_world(text, str).step == 0.001


def test_a_model_of_the_first_versions():
    text = '<gazebo version="1.2"><model name="m"><link name="l"/></model></gazebo>'
    assert parse_model(text, str)[0].name == "m"
