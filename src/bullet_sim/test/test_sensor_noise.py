"""<noise> of an IMU: each axis has its own, with biases that stay, wander, and are rounded."""

import math

import numpy as np
import pytest
from bullet_sim.formats.sdf.world import parse_model
from bullet_sim.sensors.errors import Bias, BiasModel


def imu_of(inside, plugin=""):
    name = "libgazebo_ros_imu_sensor.so"
    text = (
        '<sdf version="1.7"><model name="m"><link name="a"><sensor name="s" type="imu"><imu>'
        f'{inside}</imu><plugin name="p" filename="{name}"><frameName>a</frameName>'
        f"{plugin}</plugin></sensor></link>"
        "</model></sdf>"
    )
    model, _ = parse_model(text, str)
    assert model.warnings == []
    return model.sensors[0]


def axis(name, tags, kind="gaussian"):
    return f'<{name}><noise type="{kind}">{tags}</noise></{name}>'


def test_each_axis_has_its_own_noise():
    spec = imu_of(
        "<angular_velocity>"
        + axis("x", "<mean>0.1</mean><stddev>0.01</stddev>")
        + axis("z", "<stddev>0.03</stddev><bias_mean>0.5</bias_mean><precision>0.2</precision>")
        + "</angular_velocity><linear_acceleration>"
        + axis("y", "<bias_stddev>0.4</bias_stddev><dynamic_bias_stddev>0.6</dynamic_bias_stddev>"
               "<dynamic_bias_correlation_time>300</dynamic_bias_correlation_time>")
        + "</linear_acceleration>"
    )  # fmt: skip
    assert spec.gyro_noise_mean == (0.1, 0.0, 0.0) and spec.gyro_noise_stddev == (0.01, 0.0, 0.03)
    assert spec.accel_noise_mean == spec.accel_noise_stddev == 0.0
    assert spec.gyro_bias == BiasModel(mean=(0, 0, 0.5), precision=(0, 0, 0.2))
    assert spec.accel_bias == BiasModel(stddev=(0, 0.4, 0), wander=(0, 0.6, 0), time=(0, 300, 0))


def test_noise_of_type_none_is_none():
    inside = "".join(axis(name, "<mean>1</mean><stddev>2</stddev>", "none") for name in "xyz")
    spec = imu_of(f"<linear_acceleration>{inside}</linear_acceleration>")
    assert (spec.accel_noise_mean, spec.accel_noise_stddev) == (0.0, 0.0)


def test_an_old_noise_has_a_bias_for_all_axes():
    """Of SDF up to 1.5; a URDF becomes 1.7, where it has no effect."""
    tags = "<bias_mean>0.1</bias_mean><bias_stddev>0.2</bias_stddev>"
    noise = f"<noise><type>gaussian</type><rate>{tags}</rate><accel>{tags}</accel></noise>"
    assert imu_of(noise).gyro_bias == BiasModel()
    text = (
        '<sdf version="1.5"><model name="m"><link name="a"><sensor name="s" type="imu"><imu>'
        f'{noise}</imu><plugin filename="libgazebo_ros_imu_sensor.so"><frameName>a</frameName>'
        "</plugin></sensor></link></model></sdf>"
    )
    (spec,) = parse_model(text, str)[0].sensors
    assert spec.gyro_bias == spec.accel_bias == BiasModel((0.1,) * 3, (0.2,) * 3)


def test_a_bias_at_the_start_has_its_mean_deviation_and_a_random_sign():
    bias, rng, found = Bias(BiasModel((0.5,) * 3, (0.1,) * 3)), np.random.default_rng(1), []
    for _ in range(2000):
        bias.restart(rng)
        found.append(bias.bias)
    assert np.mean(np.array(found) > 0.0) == pytest.approx(0.5, abs=0.03)
    size = np.abs(found)
    assert (size.mean(), size.std()) == pytest.approx((0.5, 0.1), abs=0.01)
    assert bias.measured((1.0, 2.0, 3.0), 0.1, rng) == tuple(np.add((1, 2, 3), bias.bias))


def test_a_bias_that_wanders_has_the_spread_and_the_memory_of_its_process():
    """In the long run a deviation of sigma sqrt(tau / 2), and exp(-t / tau) of what it was."""
    sigma, tau, period = 0.4, 0.5, 0.05
    bias, rng = Bias(BiasModel(wander=(sigma,) * 3, time=(tau,) * 3)), np.random.default_rng(2)
    bias.restart(rng)
    found = np.array([bias.measured((0.0, 0.0, 0.0), period, rng) for _ in range(40000)])[1000:]
    assert found.std() == pytest.approx(sigma * math.sqrt(tau / 2.0), rel=0.03)
    kept = np.mean(found[10:] * found[:-10]) / found.var()
    assert kept == pytest.approx(math.exp(-10 * period / tau), abs=0.03)


def test_without_any_it_is_none_and_draws_nothing():
    bias, rng, other = Bias(BiasModel()), np.random.default_rng(3), np.random.default_rng(3)
    bias.restart(rng)
    assert bias.is_none and rng.random() == other.random()
    assert not Bias(BiasModel(precision=(0.1, 0.0, 0.0))).is_none


def test_measurements_are_rounded_to_the_precision():
    bias, rng = Bias(BiasModel(mean=(1e-9,) * 3, precision=(0.25, 0.0, 0.5))), None
    assert bias.measured((0.4, 0.4, 0.8), 0.1, rng) == (0.5, 0.4, 1.0)
