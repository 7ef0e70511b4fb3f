"""Frequent messages, packed directly into their wire format.

genpy builds a message from many small objects and packs them field by field, and rospy copies the
bytes twice; that takes longer than reading the numbers from the engine. Here the constant fields
are packed once, the numbers in one call, and the parts are joined once. The bytes are the same as
genpy's; a test compares them.

Wire format: http://wiki.ros.org/msg#Fields (little endian; strings and lists lead with a uint32).
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import rospy
from bullet_sim.pose import Array, Motion

if TYPE_CHECKING:
    from bullet_sim.plugins.lidars import RaySpec

_LENGTH = struct.Struct("<I")
_CLOCK = struct.Struct("<III")  # length, seconds, nanoseconds
_HEADER = struct.Struct("<III")  # seq, stamp: seconds, nanoseconds


def pack_string(text: str) -> bytes:
    """Bytes of a string field."""
    data = text.encode()
    return struct.pack("<I", len(data)) + data


def to_sec_nsec(time: float) -> tuple[int, int]:
    """Seconds and nanoseconds of a simulated time [s], rounded to nanoseconds."""
    seconds = int(time)
    nanoseconds = round((time - seconds) * 1e9)
    return (seconds, nanoseconds) if nanoseconds < 1000000000 else (seconds + 1, 0)


class Packed:
    """Stands in for a message in rospy's publish(): `serialize` writes the packed bytes.

    Args:
        publisher: rospy.Publisher of the message's type.
    """

    _has_header = False  # rospy sets no header: the bytes hold it

    def __init__(self, publisher: rospy.Publisher) -> None:
        self._publisher, self._impl = publisher, publisher.impl
        self._parts: tuple[bytes | memoryview, ...] = ()

    def has_subscribers(self) -> bool:
        """Whether the topic has some."""
        return self._publisher.get_num_connections() > 0

    def serialize(self, buffer: Any) -> None:
        """Write the packed bytes; rospy calls it with the topic's lock held."""
        for part in self._parts:
            buffer.write(part)

    def _send(self, *parts: bytes | memoryview) -> int:
        """Do what publish() of rospy's topic does, without its buffer.

        Returns:
            The topic's seq; 0 if nothing was sent from here.
        """
        impl, failed = self._impl, []
        impl.acquire()
        try:
            if impl.closed or impl.is_latch:  # raises, or stores the latched message
                self._parts = parts
                impl.publish(self)
                return 0
            if not impl.connections:
                return 0
            impl.seq += 1
            data = b"".join((_LENGTH.pack(sum(map(len, parts))), *parts))
            for connection in impl.connections:
                try:
                    connection.write_data(data)
                except Exception as error:  # as rospy: the other connections get the message
                    rospy.logdebug("connection to %s ended: %s", connection.endpoint_id, error)
                    failed.append(connection)
            impl.message_data_sent += len(data)
            seq: int = impl.seq
        finally:
            impl.release()
        for connection in failed:
            connection.close()
        return seq

    def _header(self, time: float) -> bytes:
        """seq and stamp; rospy increments seq just before it serialises a message."""
        return _HEADER.pack((self._impl.seq + 1) & 0xFFFFFFFF, *to_sec_nsec(time))


class PackedJointState(Packed):
    """sensor_msgs/JointState.

    Args:
        with_efforts, with_velocities: whether there is one for each name, or none at all.
        frame: frame_id of the header.
    """

    def __init__(
        self,
        publisher: rospy.Publisher,
        names: Sequence[str],
        with_efforts: bool = True,
        with_velocities: bool = True,
        frame: str = "",
    ) -> None:
        super().__init__(publisher)
        self._constant = (
            pack_string(frame) + struct.pack("<I", len(names)) + b"".join(map(pack_string, names))
        )
        count = len(names)
        self._efforts, self._velocities = count * with_efforts, count * with_velocities
        self._numbers = struct.Struct(f"<I{count}dI{self._velocities}dI{self._efforts}d")
        self._count = count

    def send(
        self,
        time: float,
        positions: Iterable[float],
        velocities: Iterable[float] = (),
        efforts: Iterable[float] = (),
    ) -> None:
        """Publish for a simulated time [s]; three sequences of numbers in the names' order."""
        n = self._count
        self._send(
            self._header(time),
            self._constant,
            self._numbers.pack(
                n, *positions, self._velocities, *velocities, self._efforts, *efforts
            ),
        )


class PackedOdometry(Packed):
    """nav_msgs/Odometry.

    Args:
        pose_variances, twist_variances: the six on the diagonals of the covariances.
    """

    _NUMBERS = struct.Struct("<7d")
    _TWIST = struct.Struct("<6d")

    def __init__(
        self,
        publisher: rospy.Publisher,
        frame: str,
        child_frame: str,
        pose_variances: Sequence[float],
        twist_variances: Sequence[float],
    ) -> None:
        super().__init__(publisher)
        self._frames = pack_string(frame) + pack_string(child_frame)
        self._pose_covariance, self._twist_covariance = map(
            _pack_diagonal, (pose_variances, twist_variances)
        )

    def send(
        self,
        time: float,
        position: Iterable[float],
        orientation: Iterable[float],
        linear: Iterable[float],
        angular: Iterable[float],
    ) -> int:
        """Publish for a simulated time [s]: pose and twist [m, m/s, rad/s].

        Returns:
            seq of its header; 0 without a subscriber.
        """
        return self._send(
            self._header(time),
            self._frames,
            self._NUMBERS.pack(*position, *orientation),
            self._pose_covariance,
            self._TWIST.pack(*linear, *angular),
            self._twist_covariance,
        )


def _pack_diagonal(values: Sequence[float]) -> bytes:
    """Bytes of a square matrix with a diagonal."""
    size = len(values)
    matrix = [0.0] * size**2
    matrix[:: size + 1] = values
    return struct.pack(f"<{size**2}d", *matrix)


class PackedImu(Packed):
    """sensor_msgs/Imu.

    Args:
        frame: frame_id of the header.
        variance: on the diagonals of the covariances.
    """

    _NUMBERS = struct.Struct("<4d72s3d72s3d72s")

    def __init__(self, publisher: rospy.Publisher, frame: str, variance: float = 0.0) -> None:
        super().__init__(publisher)
        self._frame = pack_string(frame)
        self.set_variances([variance] * 3, [variance] * 3, [variance] * 3)

    def set_variances(
        self, orientation: Sequence[float], rate: Sequence[float], force: Sequence[float]
    ) -> None:
        """Set the diagonals (3,) of the covariances [rad^2, rad^2/s^2, m^2/s^4]."""
        self._covariances = [_pack_diagonal(values) for values in (orientation, rate, force)]

    def send(
        self,
        time: float,
        orientation: Iterable[float],
        rate: Iterable[float],
        force: Iterable[float],
    ) -> None:
        """Publish for a simulated time [s]: (x, y, z, w), [rad/s], [m/s^2]."""
        first, second, third = self._covariances
        self._send(
            self._header(time),
            self._frame,
            self._NUMBERS.pack(*orientation, first, *rate, second, *force, third),
        )


class PackedStates(Packed):
    """gazebo_msgs/ModelStates or LinkStates.

    Args:
        names: of the models or links.
    """

    def __init__(self, publisher: rospy.Publisher, names: Sequence[str]) -> None:
        super().__init__(publisher)
        self._count, count = len(names), struct.pack("<I", len(names))
        self._names = count + b"".join(map(pack_string, names))
        self._numbers = struct.Struct(f"<I{7 * len(names)}dI{6 * len(names)}d")

    def send(self, motions: Iterable[Motion]) -> None:
        """Publish (position [m], orientation, linear [m/s], angular [rad/s]) of each name."""
        poses: list[float] = []
        twists: list[float] = []
        for position, orientation, linear, angular in motions:
            poses += position
            poses += orientation
            twists += linear
            twists += angular
        self._send(self._names, self._numbers.pack(self._count, *poses, self._count, *twists))


class PackedTransforms(Packed):
    """tf2_msgs/TFMessage: transforms of one time.

    Args:
        frames: (frame, child frame) of each.
    """

    _NUMBERS = struct.Struct("<7d")

    def __init__(self, publisher: rospy.Publisher, frames: Sequence[tuple[str, str]]) -> None:
        super().__init__(publisher)
        self._count = struct.pack("<I", len(frames))
        self._frames = [pack_string(frame) + pack_string(child) for frame, child in frames]

    def send(
        self, time: float, poses: Iterable[tuple[Iterable[float], Iterable[float]]], seq: int = 0
    ) -> None:
        """Publish for a simulated time [s]; (position [m], orientation) of each, seq of all."""
        stamp = _HEADER.pack(seq, *to_sec_nsec(time))
        parts = [self._count]
        for frames, (position, orientation) in zip(self._frames, poses):
            parts += stamp, frames, self._NUMBERS.pack(*position, *orientation)
        self._send(*parts)


class PackedBase:
    """Odometry of a base and its transform, which has the odometry's header.

    Args:
        odometry, transform: publishers, or None.
        spec: has pose_covariance and twist_covariance: the diagonals.
        frames: of the odometry and of the base.
    """

    def __init__(
        self,
        odometry: rospy.Publisher | None,
        transform: rospy.Publisher | None,
        spec: Any,
        frames: tuple[str, str],
    ) -> None:
        self._odometry = odometry and PackedOdometry(
            odometry, *frames, spec.pose_covariance, spec.twist_covariance
        )
        self._transform = transform and PackedTransforms(transform, [frames])

    def has_subscribers(self) -> bool:
        """Whether one of the topics has some."""
        outputs = self._odometry, self._transform
        return any(output.has_subscribers() for output in outputs if output is not None)

    def send(
        self,
        time: float,
        position: Iterable[float],
        orientation: Iterable[float],
        linear: Iterable[float],
        angular: Iterable[float],
        with_transform: bool = True,
        flat: bool = False,
    ) -> None:
        """Publish for a simulated time [s]: pose, and twist in the base's frame [m/s, rad/s].

        Args:
            flat: the odometry's height is 0, its transform's is not.
        """
        seq = 0
        if self._odometry is not None:
            place = (*tuple(position)[:2], 0.0) if flat else position
            seq = self._odometry.send(time, place, orientation, linear, angular)
        if with_transform and self._transform is not None:
            self._transform.send(time, [(position, orientation)], seq)


class PackedScan(Packed):
    """sensor_msgs/LaserScan, as upstream without a scan_time.

    Args:
        increment: between rays [rad].
        count: of rays.
    """

    def __init__(
        self, publisher: rospy.Publisher, spec: RaySpec, increment: float, count: int
    ) -> None:
        super().__init__(publisher)
        self._constant = pack_string(spec.frame_id) + struct.pack(
            "<7fI",
            spec.min_angle,
            spec.max_angle,
            increment,
            0.0,
            0.0,  # scan_time, as upstream
            spec.range_min,
            spec.range_max,
            count,
        )
        self._intensities = struct.pack(f"<I{count}f", count, *([0.0] * count))

    def send(self, time: float, ranges: Array, intensities: Array | None = None) -> None:
        """Publish for a simulated time [s]; ranges (n,) float32 [m], intensities: None: zeros."""
        packed = self._intensities
        if intensities is not None:
            packed = packed[:4] + intensities.astype("<f4").tobytes()
        self._send(self._header(time), self._constant, ranges.astype("<f4").tobytes(), packed)


class PackedImage(Packed):
    """sensor_msgs/Image.

    Args:
        frame: frame_id of the header.
        encoding: such as rgb8.
    """

    def __init__(self, publisher: rospy.Publisher, frame: str, encoding: str) -> None:
        super().__init__(publisher)
        self._frame, self._encoding = pack_string(frame), pack_string(encoding)

    def send(self, time: float, pixels: Any) -> None:
        """Publish for a simulated time [s]; pixels (H, W) or (H, W, C), contiguous."""
        height, width = pixels.shape[:2]
        step = pixels.strides[0]
        self._send(
            self._header(time),
            self._frame,
            struct.pack("<II", height, width),
            self._encoding,
            struct.pack("<BII", 0, step, height * step),
            memoryview(pixels).cast("B"),
        )


class PackedClock(Packed):
    """rosgraph_msgs/Clock."""

    def send(self, times: Sequence[float]) -> None:
        """Publish simulated times [s]; those before the last in one piece."""
        *earlier, last = times
        if earlier:
            connections = self._impl.connections  # replaced, not changed, by other threads
            if connections:
                data = b"".join(_CLOCK.pack(8, *to_sec_nsec(time)) for time in earlier)
                for connection in connections:
                    try:
                        connection.write_data(data)
                    except Exception as error:  # the last time's message closes it
                        rospy.logdebug("connection to %s ended: %s", connection.endpoint_id, error)
        self._send(struct.pack("<II", *to_sec_nsec(last)))
