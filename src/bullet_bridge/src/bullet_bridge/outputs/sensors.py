"""Sensors of a model as topics: read, convert and publish when due and subscribed.

Everything here runs in the simulation thread, except creation of publishers.
"""

from dataclasses import replace

import numpy as np
from bullet_sim.pose import Pose, cross
from bullet_sim.sensors import camera, inertial
from bullet_sim.sensors.lidar import Lidar
from nav_msgs.msg import Odometry
from sensor_msgs.msg import CameraInfo, Image, Imu, LaserScan

from bullet_bridge.loop.schedule import SubscribedSchedule
from bullet_bridge.transport import conversions
from bullet_bridge.transport.packed import PackedImage, PackedOdometry, PackedScan
from bullet_bridge.transport.publishing import publisher


class Output:
    """One sensor of one model.

    Args:
        world, model: of the core.
        spec: the sensor's specification.
        seed: of its noise.
    """

    message = None
    relayed = True  # see publishing.publisher
    reports = True  # it publishes periodically, so that its rate can be measured
    every_step = False  # update() is called after every step, not at the rate of the spec

    def __init__(self, world, model, spec, seed):
        self.world, self.model, self.spec, self.seed = world, model, spec, seed
        fastest = 1.0 / world.time_step  # as in Gazebo: at most one message per step
        rate = fastest if self.every_step else min(spec.rate or fastest, fastest)
        self.schedule = SubscribedSchedule(
            rate, world.time_step, world.step_count, self.has_subscribers
        )
        self.publisher = publisher(spec.topic, self.message, relayed=self.relayed)
        offset = Pose.from_xyz_rpy(*getattr(spec, "pose", ((0, 0, 0), (0, 0, 0))))
        self._offset = None if offset == Pose() else offset
        self.restart()

    def restart(self):
        """Restart schedule and noise after a reset."""
        self.schedule.restart(self.world.step_count)
        self.rng = np.random.default_rng(self.seed)

    def attach(self, arrivals):
        """Subscribe to the output's input topics, if any, through Arrivals."""

    def has_subscribers(self):
        """Whether the output has subscribers."""
        return self.publisher.get_num_connections() > 0

    def update(self, time):
        """Read the sensor and publish it for simulated time [s]."""
        raise NotImplementedError

    def close(self):
        """Unregister the topic."""
        self.publisher.unregister()

    def sensor_state(self):
        """Pose of the sensor frame in the world, velocity of its origin, world axes."""
        pose, linear, angular = self.model.link_state(self.spec.link)
        if self._offset is None:
            return pose, linear, angular
        arm = pose.matrix @ np.asarray(self._offset.position)
        return pose * self._offset, linear + cross(angular, arm), angular


class GroundTruthOutput(Output):
    """nav_msgs/Odometry without error."""

    message = Odometry

    def __init__(self, world, model, spec, seed):
        super().__init__(world, model, spec, seed)
        self._sender = PackedOdometry(
            self.publisher, spec.frame_id, spec.child_frame_id, spec.noise_stddev**2
        )

    def update(self, time):
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


class RaysOutput(Output):
    """Casts the rays of a lidar, all of a scan at one time.

    Attributes:
        lidar: class of the core's lidar.
    """

    lidar = Lidar

    def __init__(self, world, model, spec, seed):
        self._lidar = self.lidar(spec)
        super().__init__(world, model, spec, seed)

    def _scan(self):
        position, orientation, _, _ = self.model.link_motion(self.spec.link)
        return self._lidar.scan(
            self.world.engine,
            position,
            orientation,
            self.rng,
            self.model.body,
        )


class LidarOutput(RaysOutput):
    """sensor_msgs/LaserScan."""

    message = LaserScan

    def __init__(self, world, model, spec, seed):
        super().__init__(world, model, spec, seed)
        self._sender = PackedScan(
            self.publisher, spec, self._lidar.angle_increment, len(self._lidar.angles)
        )

    def update(self, time):
        self._sender.send(time, self._scan())


class DifferenceOutput(Output):
    """Compares a state with that of its last message, which it forgets without subscribers."""

    def restart(self):
        super().restart()
        self._before = None

    def has_subscribers(self):
        subscribed = super().has_subscribers()
        if not subscribed:
            self._before = None
        return subscribed


class ImuOutput(DifferenceOutput):
    """sensor_msgs/Imu: proper acceleration, mean over the sensor's period."""

    message = Imu

    def update(self, time):
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
        self.publisher.publish(
            conversions.imu_message(time, self.spec, pose.orientation, rate, force)
        )


class CameraOutput(Output):
    """sensor_msgs/Image and CameraInfo; pictures come from the render worker."""

    message = Image
    relayed = False

    def __init__(self, world, model, spec, seed):
        from bullet_sim.render.request import CameraRequest

        camera.check(spec.width, spec.height, spec.horizontal_fov, spec.near, spec.far)
        super().__init__(world, model, spec, seed)
        self._info_publisher = publisher(spec.info_topic, CameraInfo, relayed=False)
        self._labels = None
        self._sender = PackedImage(self.publisher, spec.frame_id, spec.encoding)
        self._info = camera.camera_info_arrays(
            spec.width, spec.height, spec.horizontal_fov, spec.distortion
        )
        index, offset = model.link_in_body(spec.link)
        pose = offset * Pose.from_xyz_rpy(*spec.pose)
        request = CameraRequest.from_spec(spec, model.source.key, index + 1, seed)
        index_in_model = next(
            (number for number, other in enumerate(model.description.sensors) if other is spec),
            len(model.description.sensors),
        )
        values = dict(
            vars(request),
            pose=(pose.position, pose.rpy),
            name=f"{model.name}/{spec.link}/{spec.name}/{index_in_model}",
        )
        self._request = CameraRequest(**values)

    @property
    def request(self):
        """CameraRequest of the pictures that have subscribers."""
        return replace(self._request, labels=True) if self._has_labels() else self._request

    def add_labels(self):
        """Publish label images, too: labels/image_raw beside camera_info."""
        namespace = self.spec.info_topic.rsplit("/", 1)[0]
        self._labels = publisher(f"{namespace}/labels/image_raw", Image, relayed=False)
        self._label_sender = PackedImage(self._labels, self.spec.frame_id, "32SC1")

    def _has_labels(self):
        return self._labels is not None and self._labels.get_num_connections() > 0

    def has_subscribers(self):
        return (
            super().has_subscribers()
            or self._info_publisher.get_num_connections() > 0
            or self._has_labels()
        )

    def publish_labels(self, frame):
        """Publish a finished label image with the snapshot's stamp."""
        self._label_sender.send(frame.time, frame.labels)

    def publish_frame(self, frame):
        """Publish a finished picture and its camera_info with the snapshot's stamp."""
        self._info_publisher.publish(self.info_message(frame.time))
        self._sender.send(frame.time, conversions.pixels(frame.rgb, self.spec.encoding))

    def info_message(self, time):
        """camera_info for a simulated time [s]."""
        info = conversions.camera_info(self.spec, self._info)
        info.header.stamp = conversions.stamp(time)
        return info

    def close(self):
        super().close()
        self._info_publisher.unregister()
        if self._labels is not None:
            self._labels.unregister()
