"""Ground truth, IMU, GPS, magnetometer, force and torque, contacts."""

from typing import TYPE_CHECKING, Any

import numpy as np
from bullet_sim.plugins.forces import ContactSpec, ForceTorqueSpec, LinkForceSpec
from bullet_sim.plugins.inertial import GpsSpec, GroundTruthSpec, ImuSpec, MagneticSpec
from bullet_sim.pose import Array, Pose, Vector
from bullet_sim.sensors import inertial
from bullet_sim.sensors.contact import nearest, watched_links
from bullet_sim.sensors.inertial import add_noise, joint_wrench, net_wrench
from gazebo_msgs.msg import ContactsState, ContactState
from geometry_msgs.msg import Vector3, Vector3Stamped, Wrench, WrenchStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Imu, MagneticField, NavSatFix

from bullet_bridge.plugins.base import PluginContext, Sensor, ros_side
from bullet_bridge.transport import conversions
from bullet_bridge.transport.packed import PackedOdometry

if TYPE_CHECKING:
    from bullet_sim.description.model import Shape
    from bullet_sim.models.model import Model


@ros_side(GroundTruthSpec)
class GroundTruthSensor(Sensor):
    """nav_msgs/Odometry without error."""

    message = Odometry

    def __init__(self, context: PluginContext) -> None:
        super().__init__(context)
        spec = self.spec
        self._sender = PackedOdometry(
            self.pub, spec.frame_id, spec.child_frame_id, spec.noise_stddev**2
        )

    def update(self, time: float, period: float) -> None:
        linear: Any
        angular: Any
        if self._offset is None:
            position, orientation, linear, angular = self.model.link_motion(self.spec.link)
        else:
            pose, linear, angular = self.sensor_state()
            position, orientation = pose.position, pose.orientation
        linear, angular = inertial.twist(orientation, linear, angular, self.spec.twist_in_child)
        if self.spec.noise_stddev > 0:
            linear = linear + self.rng.normal(0, self.spec.noise_stddev, 3)
            angular = angular + self.rng.normal(0, self.spec.noise_stddev, 3)
        self._sender.send(time, position, orientation, linear, angular)


@ros_side(ImuSpec)
class ImuSensor(Sensor):
    """sensor_msgs/Imu: proper acceleration, mean over the sensor's period."""

    STATE = ("_before",)
    message = Imu

    def start(self, time: float) -> None:
        """Measure from now on."""
        self._before: Any = None  # (velocity, time) at the last measurement

    def measure(self, time: float) -> Imu:
        pose, linear, angular = self.sensor_state()
        if self._before is None:
            acceleration = np.zeros(3)
        else:
            acceleration = inertial.mean_acceleration(
                linear, self._before[0], time - self._before[1]
            )
        self._before = (linear, time)
        rate, force = inertial.reading(pose.orientation, angular, acceleration, self.world.gravity)
        rate = inertial.add_noise(
            rate, self.spec.gyro_noise_stddev, self.rng, self.spec.gyro_noise_mean
        )
        force = inertial.add_noise(
            force, self.spec.accel_noise_stddev, self.rng, self.spec.accel_noise_mean
        )
        return conversions.imu_message(time, self.spec, pose.orientation, rate, force)


@ros_side(GpsSpec)
class GpsSensor(Sensor):
    """sensor_msgs/NavSatFix, and the velocity as geometry_msgs/Vector3Stamped.

    The velocity's axes point to the north, to the west and up.
    """

    message = NavSatFix

    def __init__(self, context: PluginContext) -> None:
        super().__init__(context)
        self._velocity = self.publisher(self.spec.velocity_topic, Vector3Stamped)

    def measure(self, time: float) -> NavSatFix:
        spec = self.spec
        pose, linear, _ = self.sensor_state()
        noise = self.rng.normal(0.0, 1.0, 6)
        position = np.asarray(pose.position) + spec.offset + noise[:3] * spec.noise_stddev
        velocity = np.asarray(linear) + noise[3:] * spec.velocity_noise_stddev
        message = NavSatFix(header=conversions.header(time, spec.frame_id))
        message.status.status, message.status.service = spec.status, spec.service
        message.latitude, message.longitude, message.altitude = inertial.fix(
            position, spec.latitude, spec.longitude, spec.altitude, spec.heading
        )
        message.position_covariance_type = NavSatFix.COVARIANCE_TYPE_DIAGONAL_KNOWN
        for axis in range(3):
            message.position_covariance[4 * axis] = spec.noise_stddev[axis] ** 2
        speed = Vector3Stamped(header=message.header)
        north, west = inertial.to_north_west(spec.heading, velocity[0], velocity[1])
        speed.vector = Vector3(north, west, velocity[2])
        self._velocity.publish(speed)
        return message


@ros_side(MagneticSpec)
class MagneticSensor(Sensor):
    """The earth's field in the sensor frame: Vector3Stamped or MagneticField."""

    message = Vector3Stamped

    def __init__(self, context: PluginContext) -> None:
        spec = context.spec
        if spec.field_message:
            self.message = MagneticField
        super().__init__(context)
        self._field = inertial.field(
            spec.magnitude, spec.heading, spec.declination, spec.inclination
        )

    def measure(self, time: float) -> Any:
        pose, _, _ = self.sensor_state()
        values = pose.matrix.T @ self._field + self.spec.offset
        values = values + add_noise(np.zeros(3), 1.0, self.rng) * self.spec.noise_stddev
        message = self.message(header=conversions.header(time, self.spec.frame_id))
        vector = message.magnetic_field if self.spec.field_message else message.vector
        vector.x, vector.y, vector.z = values.tolist()
        return message


def wrench_message(time: float, frame: str, force: Vector, torque: Vector) -> WrenchStamped:
    """geometry_msgs/WrenchStamped of two (3,) [N, N m]."""
    message = WrenchStamped(header=conversions.header(time, frame))
    message.wrench.force = Vector3(*map(float, force))
    message.wrench.torque = Vector3(*map(float, torque))
    return message


@ros_side(ForceTorqueSpec)
class ForceTorqueSensor(Sensor):
    """geometry_msgs/WrenchStamped of a joint: its child link on its parent, child's axes."""

    message = WrenchStamped

    def measure(self, time: float) -> WrenchStamped:
        wrench: Any = joint_wrench(self.model, self.spec.joint)
        if self.spec.noise_stddev:
            wrench = [v + self.rng.normal(0.0, self.spec.noise_stddev, 3) for v in wrench]
        return wrench_message(time, self.spec.frame_id, *wrench)


@ros_side(LinkForceSpec)
class LinkForceSensor(Sensor):
    """geometry_msgs/WrenchStamped of the net force on a link, mean over a step, world axes."""

    STATE = ("_before",)
    message = WrenchStamped

    def start(self, time: float) -> None:
        """Measure from now on."""
        self._before: Any = None  # (velocity, angular velocity, time) at the last measurement

    def measure(self, time: float) -> WrenchStamped | None:
        part = self.model.description.links[self.spec.link]
        pose, linear, angular = self.model.link_state(self.spec.link)
        speed = linear + np.cross(angular, pose.matrix @ part.centre)
        before, self._before = self._before, (speed, angular, time)
        if before is None or not time > before[2]:
            return None
        inertia = pose.matrix @ part.inertia @ pose.matrix.T
        wrench = net_wrench(part.mass, inertia, before[:2], (speed, angular), time - before[2])
        return wrench_message(time, self.spec.frame_id, *wrench)


@ros_side(ContactSpec)
class ContactSensor(Sensor):
    """Contacts of the monitored shapes, one state per pair of shapes; an empty list without any.

    As in Gazebo: positions and normals in the world, wrenches in the axes of the sensor's link,
    about its center of mass; the sensor's shape comes first.
    """

    message = ContactsState

    def __init__(self, context: PluginContext) -> None:
        self._monitored = watched_links(context.spec, context.model.description)
        self._indices = sorted({context.model.link_in_body(link)[0] for link, _ in self._monitored})
        super().__init__(context)

    def measure(self, time: float) -> ContactsState:
        message = ContactsState(header=conversions.header(time, self.spec.frame_id))
        pairs: dict[tuple[str, str], tuple[int, list[Any]]] = {}
        for index in self._indices:
            for contact in self.world.engine.contacts(self.model.body, index):
                mine, shape = self._named(self.model, index, contact.position)
                if not self._is_monitored(shape):
                    continue
                other = self._other(contact)
                pairs.setdefault((mine, other), (index, []))[1].append(contact)
        for (mine, other), (index, contacts) in pairs.items():
            message.states.append(self._state(mine, other, index, contacts))
        return message

    def _is_monitored(self, shape: "Shape | None") -> bool:
        return shape is not None and (
            (shape.link, shape.name) in self._monitored or (shape.link, "") in self._monitored
        )

    @staticmethod
    def _named(model: "Model", index: int, position: Array) -> "tuple[str, Shape | None]":
        """(model::link::collision, its Shape) of the shape that a point in the world is on."""
        pose = Pose(*model.frame_at(index))
        name, shapes = model.collisions_at(index)
        shape = nearest(shapes, pose.matrix.T @ (position - np.asarray(pose.position)))
        if shape is None:
            return f"{model.name}::{name}::collision", None
        return f"{model.name}::{shape.link or name}::{shape.name or 'collision'}", shape

    def _other(self, contact: Any) -> str:
        for model in self.world.models.values():
            if model.body == contact.body:
                return self._named(model, contact.link, contact.position)[0]
        return "world"

    def _state(self, mine: str, other: str, index: int, contacts: list[Any]) -> ContactState:
        engine, body = self.world.engine, self.model.body
        rotation = Pose(*self.model.frame_at(index)).matrix.T
        center = engine.link_centre(body, index)
        state = ContactState(
            collision1_name=mine,
            collision2_name=other,
            info=f"{len(contacts)} contact points of {mine} and {other}",
        )
        total = np.zeros(6)
        for contact in contacts:
            torque = np.cross(contact.position - center, contact.force)
            wrench = np.concatenate([rotation @ contact.force, rotation @ torque])
            total += wrench
            state.wrenches.append(_wrench(wrench))
            state.contact_positions.append(Vector3(*contact.position.tolist()))
            state.contact_normals.append(Vector3(*contact.normal.tolist()))
            state.depths.append(contact.depth)
        state.total_wrench = _wrench(total)
        return state


def _wrench(values: Array) -> Wrench:
    return Wrench(force=Vector3(*values[:3].tolist()), torque=Vector3(*values[3:].tolist()))
