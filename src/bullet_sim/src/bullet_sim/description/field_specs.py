"""Specifications of sensors that measure a link's place and attitude on the earth, and of plugins
that move a whole model."""

import math
from dataclasses import dataclass

from bullet_sim.description.specs import ZERO_POSE, PoseTuple


@dataclass(frozen=True)
class GpsSpec:
    """A GPS receiver; x of the world points along reference_heading, y to the left of it.

    Attributes:
        rate: fixes per simulated second [Hz]; 0: one a physics step.
        topic, velocity_topic: NavSatFix and Vector3Stamped.
        latitude, longitude: of the world's origin [degrees]; altitude [m].
        heading: of the world's x axis [rad], clockwise from north.
        status, service: of NavSatStatus.
        noise_stddev: of Gaussian noise on x, y, z [m].
        velocity_noise_stddev: on the velocities [m/s].
        offset: constant error [m].
    """

    name: str
    link: str
    pose: PoseTuple = ZERO_POSE
    rate: float = 4.0
    topic: str = "/fix"
    velocity_topic: str = "/fix_velocity"
    frame_id: str = "world"
    latitude: float = 49.860246
    longitude: float = 8.687077
    altitude: float = 0.0
    heading: float = 0.0
    status: int = 0
    service: int = 1
    noise_stddev: tuple[float, float, float] = (0.0, 0.0, 0.0)
    velocity_noise_stddev: tuple[float, float, float] = (0.0, 0.0, 0.0)
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class MagneticSpec:
    """A magnetometer in the earth's field.

    Attributes:
        rate: messages per simulated second [Hz]; 0: one a physics step.
        magnitude: of the field, in the message's unit.
        heading: of the world's x axis [rad], clockwise from north.
        declination, inclination: of the field [rad]; inclination positive downwards.
        field_message: MagneticField instead of Vector3Stamped.
        noise_stddev, offset: along the sensor's axes.
    """

    name: str
    link: str
    pose: PoseTuple = ZERO_POSE
    rate: float = 0.0
    topic: str = "/magnetic"
    frame_id: str = "base_link"
    magnitude: float = 0.44
    heading: float = 0.0
    declination: float = 0.0
    inclination: float = math.radians(60.0)
    field_message: bool = False
    noise_stddev: tuple[float, float, float] = (0.0, 0.0, 0.0)
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class PlanarMoveSpec:
    """libgazebo_ros_planar_move: a model that follows its velocity commands exactly.

    Attributes:
        rate: of odometry [Hz].
        timeout: without a command after which it stops [s]; negative: never.
    """

    name: str
    link: str
    rate: float = 20.0
    timeout: float = -1.0
    command_topic: str = "/cmd_vel"
    topic: str = "/odom"
    frame_id: str = "odom"
    child_frame_id: str = "base_footprint"


@dataclass(frozen=True)
class ForceTorqueSpec:
    """libgazebo_ros_ft_sensor: the wrench of a joint's child link on its parent.

    Attributes:
        link: the child link, whose frame it is given in.
        joint: its name.
        rate: messages per simulated second [Hz]; 0: one a physics step.
        noise_stddev: on each number [N, N m].
    """

    name: str
    link: str
    joint: str
    rate: float = 0.0
    topic: str = "/wrench"
    frame_id: str = ""
    noise_stddev: float = 0.0


@dataclass(frozen=True)
class LinkForceSpec:
    """libgazebo_ros_f3d: the net force and torque on a link, along the world's axes."""

    name: str
    link: str
    rate: float = 0.0
    topic: str = "/force"
    frame_id: str = "world"


@dataclass(frozen=True)
class HandOfGodSpec:
    """libgazebo_ros_hand_of_god: pulls a link to the frame FRAME_desired.

    Attributes:
        frame: FRAME; where the link is comes as FRAME_actual.
        linear, angular: stiffness [N/m], [N m/rad]; it is critically damped.
    """

    name: str
    link: str
    frame: str = "hog"
    linear: float = 200.0
    angular: float = 200.0
    rate: float = 0.0
    topic: str = "/tf"


@dataclass(frozen=True)
class JointPosesSpec:
    """libgazebo_ros_joint_pose_trajectory: puts joints to the points of a trajectory in time."""

    name: str
    link: str
    rate: float = 0.0
    topic: str = "/set_joint_trajectory"


@dataclass(frozen=True)
class JointTransformsSpec:
    """libpaddock_state_publisher: the transforms of all joints, as robot_state_publisher's."""

    name: str
    link: str
    rate: float = 50.0
    topic: str = "/tf"


@dataclass(frozen=True)
class RootTransformSpec:
    """The true transform of a model's root link.

    Attributes:
        frame_id: name of the world's frame.
    """

    name: str
    link: str
    frame_id: str
    rate: float = 50.0
    topic: str = "/tf"
