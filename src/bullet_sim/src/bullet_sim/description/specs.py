"""Sensor specifications, as read from a model's <gazebo> and <sensor> elements."""

from dataclasses import dataclass

from bullet_sim.description.lens import Lens

PoseTuple = tuple[tuple[float, float, float], tuple[float, float, float]]
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
        noise_stddev, noise_mean: of Gaussian noise on intensities in 0..1.
        encoding: of the messages: rgb8, bgr8 or mono8.
        baseline: of a stereo pair's right camera [m], as <hackBaseline> gives it.
        distortion: (k1, k2, p1, p2, k3) of its lens, as CameraInfo's plumb_bob; (): a pinhole.
        lens: of a wide-angle camera; horizontal_fov is then that of a pinhole, for camera_info.
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
    topic: str = "/camera/image_raw"
    info_topic: str = "/camera/camera_info"
    frame_id: str = "camera_link"
    noise_stddev: float = 0.0
    noise_mean: float = 0.0
    encoding: str = "rgb8"
    baseline: float = 0.0
    distortion: tuple[float, ...] = ()
    lens: Lens | None = None


@dataclass(frozen=True)
class DepthCameraSpec(CameraSpec):
    """A colour camera that also measures distances along its optical axis.

    Attributes:
        depth_topic, depth_info_topic, points_topic: resolved topic names.
        cutoff, cutoff_max: depths outside are unknown: NaN [m].
        millimetres: depth pictures are 16UC1 [mm] with 0 for unknown, instead of 32FC1 [m].
    """

    depth_topic: str = "/camera/depth/image_raw"
    depth_info_topic: str = "/camera/depth/camera_info"
    points_topic: str = "/camera/points"
    cutoff: float = 0.4
    cutoff_max: float = 5.0
    millimetres: bool = False


@dataclass(frozen=True)
class RangeCameraSpec(DepthCameraSpec):
    """The depth camera of a RealSense, without a colour picture: 16UC1 [mm], 0 for unknown.

    Attributes:
        range_min, range_max: depths outside are unknown in the picture [m].
        points_topic: of the point cloud; empty: none. The cutoffs are those of the points.
    """

    range_min: float = 0.0
    range_max: float = 65.535


@dataclass(frozen=True)
class RaySpec:
    """A planar lidar; angles [rad] about +z from +x, counter-clockwise, ranges [m].

    Attributes:
        rate: scans per simulated second [Hz].
        noise_stddev, noise_mean: of Gaussian noise on ranges [m].
    """

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
    topic: str = "/scan"
    frame_id: str = "laser"
    visualize: bool = False
    noise_mean: float = 0.0


@dataclass(frozen=True)
class ImuSpec:
    """An inertial measurement unit; rates [rad/s] and accelerations [m/s^2] in its own frame.

    Attributes:
        rate: messages per simulated second [Hz]; 0: one a physics step.
        variance: written on the diagonals of the covariances.
    """

    name: str
    link: str
    pose: PoseTuple = ZERO_POSE
    rate: float = 100.0
    topic: str = "/imu"
    frame_id: str = "imu_link"
    gyro_noise_stddev: float = 0.0
    accel_noise_stddev: float = 0.0
    gyro_noise_mean: float = 0.0
    accel_noise_mean: float = 0.0
    variance: float = 0.0


@dataclass(frozen=True)
class ContactSpec:
    """A bumper: contacts of some collision shapes.

    Attributes:
        link: link that carries it.
        collisions: names of the shapes it watches, as collision names of the description.
        rate: messages per simulated second [Hz]; 0: one a physics step.
    """

    name: str
    link: str
    collisions: tuple[str, ...] = ()
    rate: float = 0.0
    topic: str = "/bumper_states"
    frame_id: str = "world"


@dataclass(frozen=True)
class GroundTruthSpec:
    """Pose and velocity of a link without error, as libgazebo_ros_p3d publishes it.

    Attributes:
        link: link whose frame is reported.
        frame_id: the world frame's name in the header.
        rate: messages per simulated second [Hz]; 0: one a physics step.
        child_frame_id: the link's name in the message.
        twist_in_child: True: twist in the child frame, as nav_msgs/Odometry asks; False: along
            the world's axes, as upstream's plugin gives it.
        pose: (xyz [m], rpy [rad]) of the reported frame in the link frame.
    """

    link: str
    topic: str
    frame_id: str = "world"
    rate: float = 50.0
    twist_in_child: bool = False
    child_frame_id: str = "base_link"
    noise_stddev: float = 0.0
    pose: PoseTuple = ZERO_POSE


@dataclass(frozen=True)
class JointStatesSpec:
    """libgazebo_ros_joint_state_publisher: positions and velocities of named joints."""

    name: str
    link: str
    joints: tuple[str, ...]
    rate: float = 100.0
    topic: str = "/joint_states"
    frame_id: str = ""


@dataclass(frozen=True)
class WheelDriveSpec:
    """libgazebo_ros_diff_drive and _skid_steer_drive: velocity commands to wheels, odometry.

    Attributes:
        link: root link, whose pose the odometry reports.
        left, right: joints of each side that get that side's speed.
        separation: between the sides [m].
        diameter: of the wheels [m].
        torque: most a wheel gets [N m].
        acceleration: of a wheel's rim [m/s^2]; 0: at once.
        rate: of commands to the wheels and of odometry [Hz].
        command_topic, topic: of velocity commands and of odometry.
        frame_id, child_frame_id: of the odometry.
        publish_tf: also publish the odometry's transform on /tf.
        from_wheels: odometry by the wheels' angles, from zero; else the true pose.
        wheel_states_topic: of JointState with the wheels' positions; empty: none.
        wheel_transforms: also publish the wheels' transforms on /tf.
    """

    name: str
    link: str
    left: tuple[str, ...]
    right: tuple[str, ...]
    separation: float = 0.34
    diameter: float = 0.15
    torque: float = 5.0
    acceleration: float = 0.0
    rate: float = 100.0
    command_topic: str = "/cmd_vel"
    topic: str = "/odom"
    frame_id: str = "odom"
    child_frame_id: str = "base_footprint"
    publish_tf: bool = True
    from_wheels: bool = False
    wheel_states_topic: str = ""
    wheel_transforms: bool = False
