"""Ground truth, IMU, GPS, magnetometer."""

from __future__ import annotations

import math
from dataclasses import fields, replace
from typing import Any, ClassVar

import numpy as np

from bullet_sim.description.world import Place
from bullet_sim.parts.base import Sensor, part_of
from bullet_sim.parts.errors import TunedSensor
from bullet_sim.parts.outputs import ImuOutput, NumbersOutput, OdometryOutput
from bullet_sim.plugins import inertial as specs
from bullet_sim.pose import Pose, Quat, Vec3, multiply, quaternion_from_yaw
from bullet_sim.sensors import inertial
from bullet_sim.sensors.errors import Bias, SensorErrors


@part_of(specs.GroundTruthSpec)
class GroundTruthSensor(Sensor):
    """nav_msgs/Odometry without error, in the world or relative to a link."""

    whole_periods = True

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        spec = self.spec
        variances = [spec.noise_stddev**2] * 6
        self._sender = self.output(
            OdometryOutput(spec.topic, spec.frame_id, spec.child_frame_id, variances, variances)
        )
        self._shift: Pose | None = Pose.from_xyz_rpy(*spec.offset)
        if self._shift == Pose():
            self._shift = None

    def needs_update(self) -> bool:
        """As ModelPlugin; never where the reference link does not exist."""
        return self.spec.reference is not None and super().needs_update()

    def update(self, time: float, period: float) -> None:
        linear: Any
        angular: Any
        position, orientation, linear, angular = self.model.link_motion(self.spec.link)
        if self.spec.reference:
            frame = self.model.link_motion(self.spec.reference)
            position, orientation, linear, angular = inertial.relative_motion(
                (position, orientation, linear, angular), frame
            )
        if self._shift is not None:
            x, y, z = np.add(position, self._shift.position).tolist()
            position, orientation = (x, y, z), multiply(self._shift.orientation, orientation)
        linear, angular = inertial.twist(orientation, linear, angular, self.spec.twist_in_child)
        if self.spec.noise_stddev > 0:
            linear = linear + self.rng.normal(0, self.spec.noise_stddev, 3)
            angular = angular + self.rng.normal(0, self.spec.noise_stddev, 3)
        self._sender.send(time, position, orientation, linear, angular)


@part_of(specs.ImuSpec)
class ImuSensor(Sensor):
    """sensor_msgs/Imu: proper acceleration, mean over the sensor's period."""

    STATE: ClassVar[tuple[str, ...]] = ("_before", "_reference", "_gyro_bias", "_accel_bias")
    waits_for_time = True

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        spec = self.spec
        self._sender = self.output(ImuOutput(spec.topic, spec.frame_id, spec.variance))
        self._gyro_bias, self._accel_bias = Bias(self.spec.gyro_bias), Bias(self.spec.accel_bias)

    def start(self, time: float) -> None:
        """Measure from now on."""
        self._before: Any = None  # (velocity, time) at the last measurement
        x, y, z, w = self.pose().orientation if self.spec.relative else (0.0, 0.0, 0.0, 1.0)
        self._reference: Quat = (-x, -y, -z, w)  # from the left to an orientation in the world
        self._gyro_bias.restart(self.rng)
        self._accel_bias.restart(self.rng)

    def update(self, time: float, period: float) -> None:
        self._sender.send(time, *self.read(time))

    def read(self, time: float) -> tuple[Quat, Vec3, Vec3]:
        """Orientation, angular velocity [rad/s] and specific force [m/s^2] at a time [s]."""
        period = 0.0 if self._before is None else time - self._before[1]
        orientation, rate, force = self._ideal(time)
        spec = self.spec
        if spec.relative:
            orientation = multiply(self._reference, orientation)
        if spec.turn[:3] != (0.0, 0.0, 0.0):
            orientation = multiply(spec.turn, orientation)
        if spec.orientation_noise > 0.0:  # also of its length, as upstream
            a, b, c, d = self.rng.normal(0.0, spec.orientation_noise, 4).tolist()
            x, y, z, w = orientation
            orientation = x + a, y + b, z + c, w + d
        rate, force = self._with_noise(rate, force)
        if not self._gyro_bias.is_none:
            rate = self._gyro_bias.measured(rate, period, self.rng)
        if not self._accel_bias.is_none:
            force = self._accel_bias.measured(force, period, self.rng)
        return orientation, rate, force

    def _ideal(self, time: float) -> tuple[Quat, Vec3, Vec3]:
        """As read(), without errors."""
        _, orientation, linear, angular = self.sensor_motion()
        force = inertial.specific_force(linear, self._before, time, self.world.gravity)
        self._before = (linear, time)
        force, rate = inertial.twist(orientation, force, angular)
        return orientation, rate, force

    def _with_noise(self, rate: Vec3, acceleration: Vec3) -> tuple[Vec3, Vec3]:
        """Rate and acceleration with their noise."""
        spec = self.spec
        return (
            self._noisy(rate, spec.gyro_noise_stddev, spec.gyro_noise_mean),
            self._noisy(acceleration, spec.accel_noise_stddev, spec.accel_noise_mean),
        )

    def _noisy(self, values: Vec3, stddev: float | Vec3, mean: float | Vec3) -> Vec3:
        """As inertial.add_noise, on plain numbers."""
        x, y, z = values
        if mean:
            a, b, c = (mean, mean, mean) if isinstance(mean, float) else mean
            x, y, z = x + a, y + b, z + c
        if isinstance(stddev, tuple) or stddev > 0.0:
            a, b, c = self.rng.normal(0.0, stddev, 3).tolist()
            x, y, z = x + a, y + b, z + c
        return x, y, z


@part_of(specs.ModelImuSpec)
class ModelImuSensor(ImuSensor):
    """As libgazebo_ros_imu.so: without gravity, and turned as there.

    That plugin turns rates and accelerations from the world's axes by the orientation instead of by
    its inverse. So they are in the sensor's axes only while these are parallel to the world's.
    """

    whole_periods = True

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        self._turn = Pose.from_xyz_rpy(*self.spec.pose).orientation

    def _ideal(self, time: float) -> tuple[Quat, Vec3, Vec3]:
        _, orientation, linear, angular = self.model.link_motion(self.spec.link)
        x, y, z, w = orientation = multiply(self._turn, orientation)
        acceleration = inertial.specific_force(linear, self._before, time, (0.0, 0.0, 0.0))
        self._before = (linear, time)
        turned = inertial.twist((-x, -y, -z, w), angular, acceleration)
        return orientation, *turned


@part_of(specs.BiasedImuSpec)
class BiasedImuSensor(ImuSensor, TunedSensor):
    """An IMU with biases that drift and that services set.

    As upstream <rpyOffset> is multiplied with the link's orientation from the left, which gives the
    orientation and the axes of accelerations; rates are in the sensor's own axes.
    """

    CACHE: ClassVar[tuple[str, ...]] = ("_gravity", "_link")
    resets = True

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        spec = self.spec
        self.errors = tuple(map(SensorErrors, (spec.accel, spec.gyro, spec.heading)))
        self._gravity: float | None = None  # [m/s^2] that the sent variances are computed with
        self._bias_sender = None
        if spec.bias_topic:
            self._bias_sender = self.output(ImuOutput(spec.bias_topic, spec.frame_id))
        self._turn = Pose.from_xyz_rpy(*spec.pose).orientation

    def tuned(self) -> dict[str, SensorErrors]:
        names = (f"{self.spec.topic}/{name}" for name in ("accel", "rate", "yaw"))
        return dict(zip(names, self.errors))

    def _ideal(self, time: float) -> tuple[Quat, Vec3, Vec3]:
        _, self._link, linear, angular = self.model.link_motion(self.spec.link)
        orientation = multiply(self._turn, self._link)
        force = inertial.specific_force(linear, self._before, time, self.world.gravity)
        self._before = (linear, time)
        force, _ = inertial.twist(orientation, force, angular)
        rate, _ = inertial.twist(multiply(self._link, self._turn), angular, angular)
        return orientation, rate, force

    def read(self, time: float) -> tuple[Quat, Vec3, Vec3]:
        """As an ImuSensor, with the biases, which also tilt and turn the orientation."""
        spec, period = self.spec, self.elapsed(time)
        orientation, rate, force = self._ideal(time)
        of_force, of_rate, of_heading = self.errors
        force = of_force.measured(force, period, self.rng)
        rate = of_rate.measured(rate, period, self.rng)
        of_heading.measured(NO_BIAS, period, self.rng)
        tilting = of_force.bias
        gravity = math.hypot(*self.world.gravity)
        if gravity != self._gravity:
            self._gravity = gravity
            rates, forces = ([n * n for n in of.noise] for of in (spec.gyro, spec.accel))
            tilt = [v / gravity**2 if gravity > 0.0 else -1.0 for v in forces[:2]]
            self._sender.set_variances([*tilt, spec.heading.noise[0] ** 2], rates, forces)
        if gravity > 0.0 and any(tilting):
            orientation = inertial.tilt_error(orientation, tilting, gravity, self._link)
        if yaw := of_heading.bias[0]:
            orientation = multiply(quaternion_from_yaw(yaw), orientation)
        if self._bias_sender is not None:
            self._bias_sender.send(
                time,
                (0.0, 0.0, 0.0, 1.0),
                of_rate.bias,
                tilting,
            )
        return orientation, rate, force


NO_BIAS = (0.0, 0.0, 0.0)


@part_of(specs.GpsSpec)
class GpsSensor(TunedSensor):
    """sensor_msgs/NavSatFix, and the velocity as geometry_msgs/Vector3Stamped.

    The velocity's axes point to the north, to the west and up.
    """

    STATE: ClassVar[tuple[str, ...]] = ("_reference", "_status")
    resets = True

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        spec = self.spec
        given = {field.name: getattr(spec, field.name) for field in fields(Place)}
        given = {name: value for name, value in given.items() if value is not None}
        self._reference: Place = replace(self.world.place, **given)
        self._meters = inertial.radii(self._reference.latitude)  # they stay, as upstream
        self.errors = SensorErrors(spec.errors), SensorErrors(spec.velocity_errors)
        self._status = (spec.status, spec.service)
        self._fixes = self.output(
            NumbersOutput(spec.topic, spec, "sensor_msgs/NavSatFix", "fix", 3)
        )
        self._velocities = self.output(
            NumbersOutput(spec.velocity_topic, spec, "geometry_msgs/Vector3Stamped", "vector", 3)
        )

    def tuned(self) -> dict[str, SensorErrors]:
        names = (f"{self.spec.topic}/{name}" for name in ("position", "velocity"))
        return dict(zip(names, self.errors))

    def update(self, time: float, period: float) -> None:
        elapsed = self.elapsed(time)
        position, _, linear, _ = self.sensor_motion()
        of_position, of_velocity = self.errors
        u, v, w = of_velocity.measured(linear, elapsed, self.rng)
        fix = of_position.measured(position, elapsed, self.rng)
        a, b, c = of_velocity.drift  # which the position's drift adds up
        x, y, z = of_position.drift
        of_position.drift = x + elapsed * a, y + elapsed * b, z + elapsed * c
        place = inertial.fix(fix, self._reference, self._meters)
        self._fixes.send(time, place, self._status, of_position.spec)
        self._velocities.send(time, (*inertial.to_north_west(self._reference.heading, u, v), w))


@part_of(specs.MagneticSpec)
class MagneticSensor(TunedSensor):
    """The earth's field in the sensor frame: Vector3Stamped or MagneticField."""

    resets = True

    def __init__(self, context: Any) -> None:
        spec = context.spec
        self.errors = (SensorErrors(spec.errors),)
        super().__init__(context)
        message, field = "geometry_msgs/Vector3Stamped", "vector"
        if spec.field_message:
            message, field = "sensor_msgs/MagneticField", "magnetic_field"
        self._sender = self.output(NumbersOutput(spec.topic, spec, message, field, 3))
        heading = self.world.place.heading if spec.heading is None else spec.heading
        self._field = inertial.field(spec.magnitude, heading, spec.declination, spec.inclination)

    def tuned(self) -> dict[str, SensorErrors]:
        return {self.spec.topic: self.errors[0]}

    def update(self, time: float, period: float) -> None:
        pose, _, _ = self.sensor_state()
        true = (pose.matrix.T @ self._field).tolist()
        values = self.errors[0].measured((true[0], true[1], true[2]), self.elapsed(time), self.rng)
        self._sender.send(time, values)
