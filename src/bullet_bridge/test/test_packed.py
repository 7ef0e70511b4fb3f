"""Packed messages have the same bytes as those that genpy packs."""

import io
import struct
import threading
from types import SimpleNamespace

import genpy_messages
import numpy as np
import pytest
from bullet_bridge.transport import conversions, packed
from bullet_sim.plugins.inertial import GroundTruthSpec, ImuSpec
from bullet_sim.plugins.lidars import RaySpec
from bullet_sim.pose import Pose
from bullet_sim.sensors import camera
from gazebo_msgs.msg import LinkStates, ModelStates
from geometry_msgs.msg import Point32, Quaternion, TransformStamped, Vector3
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import ChannelFloat32, PointCloud
from tf2_msgs.msg import TFMessage


class FakePublisher:
    """Publisher and topic in one; stores the bytes that are sent."""

    closed, endpoint_id = False, "/far"

    def __init__(self, seq=41, latch=False):
        self.impl, self.seq, self.sent, self.is_latch = self, seq, [], latch
        self.connections, self.message_data_sent, self.ended = [self], 0, 0
        self._lock = threading.Lock()

    def acquire(self):
        self._lock.acquire()

    def release(self):
        self._lock.release()

    def write_data(self, data):
        assert int.from_bytes(data[:4], "little") == len(data) - 4
        self.sent.append(data[4:])

    def close(self):
        self.ended += 1

    def publish(self, message):
        buffer = io.BytesIO()
        self.seq += 1
        message.serialize(buffer)
        self.sent.append(buffer.getvalue())


def bytes_of(message, seq=None):
    """Bytes of a message as genpy packs it."""
    if seq is not None:
        message.header.seq = seq
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


TIMES = (0.0, 0.001, 2.0 - 1e-12, 12.345678901, 1e6 + 0.125)


@pytest.mark.parametrize("time", TIMES)
def test_joint_state(time):
    names, fake = ("left", "rechts ä", "x"), FakePublisher()
    values = [np.array([1.5, -2.0, 1e-300]), np.array([0.0, np.pi, 3.0]), np.arange(3.0)]
    packed.PackedJointState(fake, names).send(time, *values)
    assert fake.sent == [bytes_of(genpy_messages.joint_state(time, names, *values), 42)]


@pytest.mark.parametrize("time", TIMES)
def test_odometry(time):
    spec = GroundTruthSpec(
        link="base",
        topic="/odom",
        rate=50.0,
        frame_id="odom",
        child_frame_id="base_link",
        noise_stddev=0.25,
    )
    pose = Pose((1.0, 2.0, 3.0), (0.0, 0.6, 0.0, 0.8))
    linear, angular, fake = np.array([1.0, 2.0, 3.0]), np.array([-1.0, 0.5, 0.0]), FakePublisher()
    sender = packed.PackedOdometry(fake, "odom", "base_link", [0.25**2] * 6, [0.25**2] * 6)
    sender.send(time, pose.position, pose.orientation, linear, angular)
    assert fake.sent == [bytes_of(genpy_messages.odometry(time, spec, pose, linear, angular), 42)]


@pytest.mark.parametrize("time", TIMES)
def test_imu(time):
    spec = ImuSpec("i", "base", frame_id="imu_länk", variance=0.5)
    orientation, rate, force = (0.0, 0.6, 0.0, 0.8), (0.1, -0.2, 1e-300), (9.0, -1.0, 0.25)
    fake = FakePublisher()
    packed.PackedImu(fake, spec.frame_id, spec.variance).send(time, orientation, rate, force)
    message = genpy_messages.imu(time, spec, orientation, rate, force)
    assert fake.sent == [bytes_of(message, 42)]


@pytest.mark.parametrize("message_type", [ModelStates, LinkStates])
@pytest.mark.parametrize("names", [(), ("ground", "bot::base")])
def test_states(names, message_type):
    motions = [((1, 2.5, 3), (0.0, 0.6, 0.0, 0.8), (0.1, 0.2, 0.3), (4, 5, 6.0))] * len(names)
    fake, message = FakePublisher(), message_type(name=list(names))
    for position, orientation, linear, angular in motions:
        message.pose.append(conversions.pose_to_msg(Pose(position, orientation)))
        message.twist.append(conversions.twist_to_msg(linear, angular))
    packed.PackedStates(fake, names).send(motions)
    assert fake.sent == [bytes_of(message)]


def test_joint_state_without_efforts():
    fake = FakePublisher()
    sender = packed.PackedJointState(fake, ("a", "b"), with_efforts=False)
    sender.send(2.5, [1.0, 2.0], [3.0, 4.0])
    arrays = np.array([1.0, 2.0]), np.array([3.0, 4.0]), np.array([])
    assert fake.sent == [bytes_of(genpy_messages.joint_state(2.5, ("a", "b"), *arrays), 42)]


@pytest.mark.parametrize("with_odometry", [True, False])
def test_a_base_has_one_header_for_odometry_and_transform(with_odometry):
    spec = SimpleNamespace(pose_covariance=[1, 2, 3, 4, 5, 6.0], twist_covariance=[0.5] * 6)
    odometry, transform = (FakePublisher() if with_odometry else None), FakePublisher()
    sender = packed.PackedBase(odometry, transform, spec, ("odom", "base"))
    pose = (1.0, 2.0, 0.0), (0.0, 0.0, 0.6, 0.8)
    sender.send(2.5, *pose, (1.0, 0.5, 0.0), (0.0, 0.0, 0.3))
    message = Odometry().deserialize(odometry.sent[0]) if with_odometry else None
    (moved,) = TFMessage().deserialize(transform.sent[0]).transforms
    assert (moved.header.frame_id, moved.child_frame_id) == ("odom", "base")
    assert moved.transform.translation.y == 2.0 and moved.transform.rotation.z == 0.6
    assert moved.header.stamp == conversions.stamp(2.5)
    if message is not None:
        assert moved.header == message.header and message.header.seq == 42
        assert message.pose.covariance[::7] == (1, 2, 3, 4, 5, 6)
        assert message.twist.covariance[::7] == (0.5,) * 6 and message.pose.covariance[1] == 0.0
    sender.send(2.6, *pose, (0, 0, 0), (0, 0, 0), with_transform=False)
    assert len(transform.sent) == 1


def test_scan():
    spec = RaySpec(
        name="laser",
        link="laser",
        topic="/scan",
        frame_id="laser",
        rate=10.0,
        samples=5,
        min_angle=-1.0,
        max_angle=1.0,
        range_min=0.1,
        range_max=9.0,
    )
    ranges, fake = np.array([1.0, np.inf, -np.inf, 0.3, 8.0], np.float32), FakePublisher()
    packed.PackedScan(fake, spec, 0.5, 5).send(2.5, ranges)
    assert fake.sent == [bytes_of(genpy_messages.laser_scan(2.5, spec, 0.5, ranges), 42)]


@pytest.mark.parametrize("channels", [0, 1, 2])
def test_cloud(channels):
    points, fake = np.array([[1.0, -2.0, 0.5], [np.nan, np.inf, 7.0]]), FakePublisher()
    values = [np.array([0.25, 3.0]) + number for number in range(channels)]
    packed.PackedCloud(fake, "lidar").send(2.5, points, *values)
    message = PointCloud(header=conversions.header(2.5, "lidar"))
    message.points = [Point32(*point) for point in points]
    message.channels = [ChannelFloat32(values=of_channel) for of_channel in values]
    assert fake.sent == [bytes_of(message, 42)]


@pytest.mark.parametrize("encoding", ["rgb8", "mono8"])
def test_image(encoding):
    rgb, fake = np.random.default_rng(1).integers(0, 256, (4, 6, 3), np.uint8), FakePublisher()
    pixels = camera.pixels(rgb, encoding)
    packed.PackedImage(fake, "camera", encoding).send(2.5, pixels)
    assert fake.sent == [bytes_of(genpy_messages.image(2.5, "camera", rgb, encoding), 42)]


@pytest.mark.parametrize("latch", [True, False])
@pytest.mark.parametrize("time", TIMES)
def test_clock(time, latch):
    fake = FakePublisher(latch=latch)
    packed.PackedClock(fake).send([time])
    assert fake.sent == [bytes_of(Clock(conversions.stamp(time)))]


def test_times_of_several_steps_leave_as_messages_of_their_own():
    fake = FakePublisher()
    fake.connections = [SimpleNamespace(write_data=fake.sent.append)]
    packed.PackedClock(fake).send([1.0, 1.001, 1.002])
    stream = b"".join(fake.sent)
    wanted = [bytes_of(Clock(conversions.stamp(time))) for time in (1.0, 1.001, 1.002)]
    assert stream == b"".join(struct.pack("<I", len(data)) + data for data in wanted)


def test_the_lock_is_released_when_sending_fails():
    fake = FakePublisher(latch=True)
    fake.publish = lambda message: 1 / 0
    with pytest.raises(ZeroDivisionError):
        packed.PackedClock(fake).send([1.0])
    assert fake._lock.acquire(blocking=False)


def test_a_connection_that_fails_is_closed_and_the_others_get_the_message():
    fake, broken = FakePublisher(), FakePublisher()
    broken.write_data = lambda data: 1 / 0
    fake.connections = [broken, fake]
    packed.PackedClock(fake).send([1.0])
    assert len(fake.sent) == 1 and (broken.ended, fake.ended) == (1, 0)
    assert fake.message_data_sent == 12 and fake._lock.acquire(blocking=False)


def test_without_a_subscriber_nothing_is_done():
    fake = FakePublisher()
    fake.connections = []
    packed.PackedClock(fake).send([1.0])
    assert (fake.sent, fake.seq, fake.message_data_sent) == ([], 41, 0)


def test_wrong_count_of_joints_is_an_error():
    with pytest.raises(struct.error):
        packed.PackedJointState(FakePublisher(), ("a", "b")).send(0.0, [1.0], [1.0], [1.0])


@pytest.mark.parametrize("time", TIMES)
def test_transforms(time):
    frames = [("base", "wheel"), ("world", "bäse")]
    poses = [Pose((1.0, -2.0, 1e-9), (0.0, 0.6, 0.0, 0.8)), Pose()]
    message = TFMessage()
    for (frame, child), pose in zip(frames, poses):
        item = TransformStamped(child_frame_id=child)
        item.header.stamp, item.header.frame_id = conversions.stamp(time), frame
        item.transform.translation = Vector3(*pose.position)
        item.transform.rotation = Quaternion(*pose.orientation)
        message.transforms.append(item)
    fake = FakePublisher()
    sender = packed.PackedTransforms(fake, frames)
    sender.send(time, [(pose.position, pose.orientation) for pose in poses])
    assert fake.sent == [bytes_of(message)]
