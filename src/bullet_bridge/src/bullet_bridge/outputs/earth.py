"""GPS and magnetometer of hector_gazebo_plugins."""

import numpy as np
from bullet_sim.sensors import inertial
from bullet_sim.sensors.inertial import add_noise
from geometry_msgs.msg import Vector3, Vector3Stamped
from sensor_msgs.msg import MagneticField, NavSatFix

from bullet_bridge.outputs.sensors import Output
from bullet_bridge.transport import conversions
from bullet_bridge.transport.publishing import publisher


class GpsOutput(Output):
    """sensor_msgs/NavSatFix, and the velocity as geometry_msgs/Vector3Stamped.

    The velocity's axes point to the north, to the west and up.
    """

    message = NavSatFix

    def __init__(self, world, model, spec, seed):
        super().__init__(world, model, spec, seed)
        self._velocity = publisher(spec.velocity_topic, Vector3Stamped)

    def has_subscribers(self):
        return super().has_subscribers() or self._velocity.get_num_connections() > 0

    def update(self, time):
        spec = self.spec
        pose, linear, _ = self.sensor_state()
        noise = self.rng.normal(0.0, 1.0, 6)
        position = np.asarray(pose.position) + spec.offset + noise[:3] * spec.noise_stddev
        velocity = np.asarray(linear) + noise[3:] * spec.velocity_noise_stddev
        message = NavSatFix()
        message.header.stamp, message.header.frame_id = conversions.stamp(time), spec.frame_id
        message.status.status, message.status.service = spec.status, spec.service
        message.latitude, message.longitude, message.altitude = inertial.fix(
            position, spec.latitude, spec.longitude, spec.altitude, spec.heading
        )
        message.position_covariance_type = NavSatFix.COVARIANCE_TYPE_DIAGONAL_KNOWN
        for axis in range(3):
            message.position_covariance[4 * axis] = spec.noise_stddev[axis] ** 2
        self.publisher.publish(message)
        speed = Vector3Stamped(header=message.header)
        north, west = inertial.to_north_west(spec.heading, velocity[0], velocity[1])
        speed.vector = Vector3(north, west, velocity[2])
        self._velocity.publish(speed)

    def close(self):
        super().close()
        self._velocity.unregister()


class MagneticOutput(Output):
    """The earth's field in the sensor frame: Vector3Stamped or MagneticField."""

    message = Vector3Stamped

    def __init__(self, world, model, spec, seed):
        if spec.field_message:
            self.message = MagneticField
        super().__init__(world, model, spec, seed)
        self._field = inertial.field(
            spec.magnitude, spec.heading, spec.declination, spec.inclination
        )

    def update(self, time):
        pose, _, _ = self.sensor_state()
        values = pose.matrix.T @ self._field + self.spec.offset
        values = values + add_noise(np.zeros(3), 1.0, self.rng) * self.spec.noise_stddev
        message = self.message()
        message.header.stamp, message.header.frame_id = conversions.stamp(time), self.spec.frame_id
        vector = message.magnetic_field if self.spec.field_message else message.vector
        vector.x, vector.y, vector.z = values.tolist()
        self.publisher.publish(message)
