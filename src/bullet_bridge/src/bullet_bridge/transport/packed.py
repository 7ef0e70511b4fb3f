"""Messages that are sent often, packed straight into their wire format.

genpy builds a message of many small objects and packs them field by field, and rospy copies the
bytes twice, which costs the physics more than reading the numbers. Here the constant parts are
packed once, the numbers in one call, and all is put together once. The bytes are those of the
ordinary message; a test compares them.

Wire format: http://wiki.ros.org/msg#Fields (little endian; strings and lists lead with a uint32).
"""

import struct

import rospy

_LENGTH = struct.Struct("<I")


def text(words):
    """Bytes of a string field."""
    data = words.encode()
    return struct.pack("<I", len(data)) + data


def split(time):
    """Seconds and nanoseconds of a simulated time [s], rounded to nanoseconds."""
    seconds = int(time)
    nanoseconds = round((time - seconds) * 1e9)
    return (seconds, nanoseconds) if nanoseconds < 1000000000 else (seconds + 1, 0)


class Packed:
    """What rospy's topic takes for a message: `serialize` writes the bytes.

    Args:
        wire: rospy.Publisher of the message's type.
    """

    _has_header = False  # the bytes hold the header, with rospy's own count of messages

    def __init__(self, wire):
        self._impl = wire.impl
        self._parts = ()

    def serialize(self, buffer):
        """Write what is to be sent; rospy calls it with the topic locked."""
        for part in self._parts:
            buffer.write(part)

    def _send(self, *parts):
        """What rospy's topic does in publish(), without its buffer."""
        impl, failed = self._impl, []
        impl.acquire()
        try:
            if impl.closed or impl.is_latch:  # an error, or it has to keep the message
                self._parts = parts
                impl.publish(self)
                return
            if not impl.connections:
                return
            impl.seq += 1
            data = b"".join((_LENGTH.pack(sum(map(len, parts))), *parts))
            for connection in impl.connections:
                try:
                    connection.write_data(data)
                except Exception as error:  # as rospy: whatever it is, the others get it
                    rospy.logdebug("connection to %s ended: %s", connection.endpoint_id, error)
                    failed.append(connection)
            impl.message_data_sent += len(data)
        finally:
            impl.release()
        for connection in failed:
            connection.close()

    def _header(self, time):
        """seq and stamp; rospy counts the message right before it is serialised."""
        return struct.pack("<III", (self._impl.seq + 1) & 0xFFFFFFFF, *split(time))


class PackedJointState(Packed):
    """sensor_msgs/JointState.

    Args:
        wire: rospy.Publisher.
        names: of the joints.
    """

    def __init__(self, wire, names):
        super().__init__(wire)
        self._constant = text("") + struct.pack("<I", len(names)) + b"".join(map(text, names))
        count = len(names)
        self._numbers = struct.Struct("<" + f"I{count}d" * 3)
        self._count = count

    def send(self, time, positions, velocities, efforts):
        """Publish for a simulated time [s]; three sequences of numbers in the names' order."""
        n = self._count
        self._send(
            self._header(time),
            self._constant,
            self._numbers.pack(n, *positions, n, *velocities, n, *efforts),
        )


class PackedOdometry(Packed):
    """nav_msgs/Odometry.

    Args:
        wire: rospy.Publisher.
        frame, child_frame: their names.
        variance: on the diagonals of both covariances.
    """

    _NUMBERS = struct.Struct("<7d")
    _TWIST = struct.Struct("<6d")

    def __init__(self, wire, frame, child_frame, variance):
        super().__init__(wire)
        self._frames = text(frame) + text(child_frame)
        self._covariance = struct.pack("<36d", *(variance * (i % 7 == 0) for i in range(36)))

    def send(self, time, position, orientation, linear, angular):
        """Publish for a simulated time [s]: pose and twist [m, m/s, rad/s]."""
        self._send(
            self._header(time),
            self._frames,
            self._NUMBERS.pack(*position, *orientation),
            self._covariance,
            self._TWIST.pack(*linear, *angular),
            self._covariance,
        )


class PackedScan(Packed):
    """sensor_msgs/LaserScan.

    Args:
        wire: rospy.Publisher.
        spec: RaySpec.
        increment: between rays [rad].
        count: of rays.
    """

    def __init__(self, wire, spec, increment, count):
        super().__init__(wire)
        self._constant = text(spec.frame_id) + struct.pack(
            "<7fI",
            spec.min_angle,
            spec.max_angle,
            increment,
            0.0,
            1.0 / spec.rate if spec.rate else 0.0,
            spec.range_min,
            spec.range_max,
            count,
        )
        self._intensities = struct.pack(f"<I{count}f", count, *([0.0] * count))

    def send(self, time, ranges):
        """Publish for a simulated time [s]; ranges (n,) float32 [m]."""
        self._send(
            self._header(time), self._constant, ranges.astype("<f4").tobytes(), self._intensities
        )


class PackedImage(Packed):
    """sensor_msgs/Image.

    Args:
        wire: rospy.Publisher.
        frame: its name.
        encoding: rgb8 and the like.
    """

    def __init__(self, wire, frame, encoding):
        super().__init__(wire)
        self._frame, self._encoding = text(frame), text(encoding)

    def send(self, time, pixels):
        """Publish for a simulated time [s]; pixels (H, W) or (H, W, C) uint8, contiguous."""
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
    """rosgraph_msgs/Clock, latched: the last one is sent again to whoever comes later."""

    def send(self, time):
        """Publish a simulated time [s]."""
        self._send(struct.pack("<II", *split(time)))
