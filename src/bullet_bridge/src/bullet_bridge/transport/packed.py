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

import numpy as np
import rospy
from bullet_sim.pose import Array, Motion

if TYPE_CHECKING:
    from bullet_sim.plugins.contacts import ContactPair
    from bullet_sim.plugins.lidars import RaySpec

_LENGTH = struct.Struct("<I")
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


def to_secs_nsecs(times: Sequence[float]) -> Array:
    """As to_sec_nsec of each of k times: (k, 2) uint32."""
    given, stamps = np.array(times), np.empty((len(times), 2), "<u4")
    whole = np.floor(given)
    nanoseconds = np.rint((given - whole) * 1e9)
    over = nanoseconds >= 1e9
    stamps[:, 0], stamps[:, 1] = whole + over, np.where(over, 0.0, nanoseconds)
    return stamps


class Block:
    """Packs several messages at once, of which only numbers differ.

    Args:
        parts: of a message: bytes, or how many float64 there are.
        has_header: a seq and a stamp are before them.
    """

    def __init__(self, *parts: bytes | int, has_header: bool = True) -> None:
        data, self._places = [bytes(_HEADER.size * has_header)], []
        for part in parts:
            if isinstance(part, int):
                begin = _LENGTH.size + sum(map(len, data))
                self._places.append((begin, part))
                part = bytes(8 * part)
            data.append(part)
        message = b"".join(data)
        self._template = np.frombuffer(_LENGTH.pack(len(message)) + message, np.uint8)
        self._has_header = has_header

    def pack(self, seq: int, times: Sequence[float], numbers: Array) -> Array:
        """Messages with their lengths (k, n) uint8.

        Args:
            seq: of the first one's header.
            times: (k,) [s].
            numbers: (k, m) of the parts.
        """
        count = len(numbers)
        block = np.repeat(self._template[None], count, axis=0)
        if self._has_header:
            header = np.empty((count, 3), "<u4")
            header[:, 0] = np.arange(seq, seq + count) & 0xFFFFFFFF
            header[:, 1:] = to_secs_nsecs(times)
            block[:, _LENGTH.size : _LENGTH.size + _HEADER.size] = header.view(np.uint8)
        first = 0
        for begin, size in self._places:
            part = np.ascontiguousarray(numbers[:, first : first + size], "<f8")
            block[:, begin : begin + 8 * size] = part.view(np.uint8).reshape(count, 8 * size)
            first += size
        return block


class Packed:
    """Stands in for a message in rospy's publish(): `serialize` writes the packed bytes.

    Args:
        publisher: rospy.Publisher of the message's type.
    """

    _has_header = False  # rospy sets no header: the bytes hold it

    def __init__(self, publisher: rospy.Publisher) -> None:
        self._publisher, self._impl = publisher, publisher.impl
        self._parts: tuple[bytes | memoryview, ...] = ()
        self._block: Block | None = None

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
        impl = self._impl
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
            failed = self._write("write_data", data)
            impl.message_data_sent += len(data)
            seq: int = impl.seq
        finally:
            impl.release()
        for connection in failed:
            connection.close()
        return seq

    def _write(self, method: str, data: Any) -> list[Any]:
        """Call a method of each connection; those that fail."""
        failed = []
        for connection in self._impl.connections:
            try:
                getattr(connection, method)(data)
            except Exception as error:  # as rospy: the other connections get the message
                rospy.logdebug("connection to %s ended: %s", connection.endpoint_id, error)
                failed.append(connection)
        return failed

    def _make_block(self) -> Block:
        """The Block of its messages."""
        raise NotImplementedError

    def send_all(self, times: Sequence[float], *values: Any) -> None:
        """Publish for each of k simulated times [s]; values: sequences of arrays (k,)."""
        columns = [column for each in values for column in each]
        self._send_block(times, np.stack(columns, axis=1))

    def _send_block(self, times: Sequence[float], numbers: Array) -> None:
        """Do what publish() of rospy's topic does, with several messages; numbers: see Block."""
        if self._block is None:
            self._block = self._make_block()
        impl = self._impl
        impl.acquire()
        try:
            if impl.closed or not impl.connections:
                return
            block = self._block.pack(impl.seq + 1, times, numbers)
            impl.seq += len(block)
            failed = self._write("write_block", block)
            impl.message_data_sent += block.size
        finally:
            impl.release()
        for connection in failed:
            connection.close()

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

    def _make_block(self) -> Block:
        return Block(self._frames, 7, self._pose_covariance, 6, self._twist_covariance)

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
        self._block = None

    def _make_block(self) -> Block:
        first, second, third = self._covariances
        return Block(self._frame, 4, first, 3, second, 3, third)

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

    def _make_block(self) -> Block:
        count = _LENGTH.pack(self._count)
        parts = self._names, count, 7 * self._count, count, 6 * self._count
        return Block(*parts, has_header=False)

    def send_states(self, motions: Sequence[Any], count: int, chosen: slice | list[int]) -> None:
        """Publish several times.

        Args:
            motions: of each name as send() takes it, of arrays with one more dimension.
            count: of messages; chosen: their indices in that dimension.
        """
        numbers = np.empty((count, 13 * len(motions)))
        poses = numbers[:, : 7 * len(motions)].reshape(count, -1, 7)
        twists = numbers[:, 7 * len(motions) :].reshape(count, -1, 6)
        for row, (position, orientation, linear, angular) in enumerate(motions):
            poses[:, row, :3] = position[:, chosen].T
            poses[:, row, 3:] = orientation[:, chosen].T
            twists[:, row, :3] = linear[:, chosen].T
            twists[:, row, 3:] = angular[:, chosen].T
        self._send_block([], numbers)

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


class Framed(Packed):
    """A message with a header.

    Args:
        frame: frame_id of the header.
    """

    def __init__(self, publisher: rospy.Publisher, frame: str) -> None:
        super().__init__(publisher)
        self._frame = pack_string(frame)


class PackedContacts(Framed):
    """gazebo_msgs/ContactsState."""

    def send(self, time: float, pairs: Sequence[ContactPair]) -> None:
        """Publish for a simulated time [s]: a state of each pair."""
        parts = [self._header(time), self._frame, _LENGTH.pack(len(pairs))]
        for number, pair in enumerate(pairs):
            count = _LENGTH.pack(len(pair.depths))
            seconds, nanoseconds = to_sec_nsec(pair.time)
            info = (  # upstream's text
                f"Debug:  i:({number}/{len(pairs)})     my geom:{pair.first}   other geom:"
                f"{pair.second}         time:{seconds}.{nanoseconds:09d}\n"
            )
            parts += map(pack_string, (info, pair.first, pair.second))
            parts += count, pair.wrenches.tobytes(), pair.total.tobytes()
            for values in (pair.positions, pair.normals, pair.depths):
                parts += count, values.tobytes()
        self._send(*parts)


class PackedCloud(Framed):
    """sensor_msgs/PointCloud, whose channels have no names."""

    def send(self, time: float, points: Array, *channels: Array) -> None:
        """Publish for a simulated time [s]; points (n, 3) [m], each channel (n,)."""
        parts = [self._header(time), self._frame, _LENGTH.pack(len(points))]
        parts += points.astype("<f4").tobytes(), _LENGTH.pack(len(channels))
        for values in channels:
            parts += pack_string(""), _LENGTH.pack(len(values)), values.astype("<f4").tobytes()
        self._send(*parts)


class PackedImage(Framed):
    """sensor_msgs/Image.

    Args:
        frame: frame_id of the header.
        encoding: such as rgb8.
    """

    def __init__(self, publisher: rospy.Publisher, frame: str, encoding: str) -> None:
        super().__init__(publisher, frame)
        self._encoding = pack_string(encoding)

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
                lengths = np.full((len(earlier), 1), 8, "<u4")
                data = np.hstack((lengths, to_secs_nsecs(earlier))).tobytes()
                for connection in connections:
                    try:
                        connection.write_data(data)
                    except Exception as error:  # the last time's message closes it
                        rospy.logdebug("connection to %s ended: %s", connection.endpoint_id, error)
        self._send(struct.pack("<II", *to_sec_nsec(last)))
