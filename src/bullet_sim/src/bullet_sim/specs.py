"""Sensor specifications, as read from a model's <gazebo> and <sensor> elements."""

from dataclasses import dataclass
from typing import Tuple

PoseTuple = Tuple[Tuple[float, float, float], Tuple[float, float, float]]
ZERO_POSE: PoseTuple = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


@dataclass(frozen=True)
class CameraSpec:
    """A colour camera that looks along +x of its sensor frame, z up.

    Attributes:
        name: sensor name.
        link: link that carries it.
        pose: (xyz [m], rpy [rad]) of the sensor frame in the link frame.
        width, height: picture size [px].
        horizontal_fov: [rad].
        near, far: clip distances [m].
        rate: pictures per simulated second [Hz].
        topic, info_topic: resolved topic names.
        frame_id: frame written into the headers.
        noise_stddev: of Gaussian noise on intensities in 0..1.
    """

    name: str
    link: str
    pose: PoseTuple = ZERO_POSE
    width: int = 640
    height: int = 480
    horizontal_fov: float = 1.047
    near: float = 0.02
    far: float = 100.0
    rate: float = 30.0
    topic: str = '/camera/image_raw'
    info_topic: str = '/camera/camera_info'
    frame_id: str = 'camera_link'
    noise_stddev: float = 0.0


@dataclass(frozen=True)
class RaySpec:
    """A planar lidar; angles [rad] about +z from +x, counter-clockwise, ranges [m]."""

    name: str
    link: str
    pose: PoseTuple = ZERO_POSE
    samples: int = 360
    min_angle: float = -3.14159265
    max_angle: float = 3.14159265
    range_min: float = 0.1
    range_max: float = 10.0
    rate: float = 10.0
    noise_stddev: float = 0.0
    topic: str = '/scan'
    frame_id: str = 'laser'
    visualize: bool = False


@dataclass(frozen=True)
class ImuSpec:
    """An inertial measurement unit; rates [rad/s] and accelerations [m/s^2] in its own frame."""

    name: str
    link: str
    pose: PoseTuple = ZERO_POSE
    rate: float = 100.0
    topic: str = '/imu'
    frame_id: str = 'imu_link'
    gyro_noise_stddev: float = 0.0
    accel_noise_stddev: float = 0.0


@dataclass(frozen=True)
class GroundTruthSpec:
    """Pose and velocity of a link without error, as libgazebo_ros_p3d publishes it.

    Attributes:
        link: link whose frame is reported.
        frame_id: the world frame's name in the header.
        child_frame_id: the link's name in the message.
        twist_in_child: True: twist in the child frame, as nav_msgs/Odometry asks; False: along
            the world's axes, as upstream's plugin gives it.
    """

    link: str
    topic: str
    frame_id: str = 'world'
    rate: float = 50.0
    twist_in_child: bool = False
    child_frame_id: str = 'base_link'
    noise_stddev: float = 0.0
