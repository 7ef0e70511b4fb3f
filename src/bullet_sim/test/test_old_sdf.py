"""What SDF 1.4 to 1.6 have and 1.7 has no more, as sdformat 9 converts it."""

import pytest
from bullet_sim.formats.sdf.world import parse_model, parse_world


@pytest.mark.parametrize("version", ["1.4", "1.5", "1.6"])
def test_gravity_within_physics(version):
    physics = "<physics type='ode'><gravity>0 0 -1.6</gravity></physics>"
    text = f'<sdf version="{version}"><world name="w">{physics}</world></sdf>'
    assert parse_world(text, str).gravity == (0.0, 0.0, -1.6)


@pytest.mark.parametrize("attribute", ["frame", "relative_to"])
def test_poses_in_a_frame(attribute):
    text = (
        '<sdf version="1.6"><model name="m"><link name="a"><pose>1 0 0 0 0 0</pose></link>'
        f'<link name="b"><pose {attribute}="a">0 2 0 0 0 0</pose></link>'
        '<joint name="j" type="fixed"><parent>a</parent><child>b</child></joint></model></sdf>'
    )
    model, _ = parse_model(text, str)
    assert model.joints["j"].origin.position == pytest.approx((1, 2, 0)) and model.warnings == []


def test_noise_of_an_imu_for_all_axes():
    noise = (
        "<noise><type>gaussian</type><rate><mean>0.1</mean><stddev>0.2</stddev></rate>"
        "<accel><mean>0.3</mean><stddev>0.4</stddev></accel></noise>"
    )
    plugin = '<plugin name="p" filename="libgazebo_ros_imu_sensor.so"/>'
    text = (
        '<sdf version="1.5"><model name="m"><link name="a"><sensor name="s" type="imu">'
        f"<imu>{noise}</imu>{plugin}</sensor></link></model></sdf>"
    )
    (spec,) = parse_model(text, str)[0].sensors
    assert (spec.gyro_noise_mean, spec.gyro_noise_stddev) == pytest.approx((0.1, 0.2))
    assert (spec.accel_noise_mean, spec.accel_noise_stddev) == pytest.approx((0.3, 0.4))
