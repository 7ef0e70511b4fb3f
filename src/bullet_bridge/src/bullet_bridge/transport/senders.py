"""What the core's parts send -> messages of ROS on topics."""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

import roslib.message
from bullet_sim.parts import outputs
from bullet_sim.parts.outputs import Output
from bullet_sim.registry import ByClass
from gazebo_msgs.msg import ContactsState
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Image, Imu, JointState, LaserScan, NavSatFix
from tf2_msgs.msg import TFMessage

from bullet_bridge.transport import conversions
from bullet_bridge.transport.packed import (
    PackedBase,
    PackedContacts,
    PackedImage,
    PackedImu,
    PackedJointState,
    PackedOdometry,
    PackedScan,
)

# Class of an Output -> function of a RosPart and the Output that makes what sends it.
SENDERS: ByClass[Callable[[Any, Any], Any]] = ByClass()
sends = SENDERS.enter


def message_class(message: Any) -> Any:
    """Class of a message's type, which may be its name."""
    return roslib.message.get_message_class(message) if isinstance(message, str) else message


def sender(part: Any, output: Output) -> Any:
    """What sends an Output on the topics of a RosPart."""
    return SENDERS.of(output)(part, output)


class Converted:
    """Sends messages that a function makes of a time and what a part sends."""

    def __init__(self, publisher: Any, convert: Callable[..., Any]) -> None:
        self._publisher, self._convert = publisher, convert

    def has_subscribers(self) -> bool:
        """Whether the topic has some."""
        return self._publisher.get_num_connections() > 0

    def send(self, time: float, *values: Any) -> None:
        """Publish for a simulated time [s]."""
        self._publisher.publish(self._convert(time, *values))


@sends(outputs.JointStatesOutput)
def _joint_states(part: Any, output: outputs.JointStatesOutput) -> PackedJointState:
    efforts, velocities = (name in output.parts for name in ("effort", "velocity"))
    pub = part.publisher(output.topic, JointState)
    return PackedJointState(pub, output.names, efforts, velocities, output.frame_id)


@sends(outputs.OdometryOutput)
def _odometry(part: Any, output: outputs.OdometryOutput) -> PackedOdometry:
    return PackedOdometry(
        part.publisher(output.topic, Odometry),
        output.frame_id,
        output.child_frame_id,
        output.pose_covariance,
        output.twist_covariance,
    )


@sends(outputs.BaseOutput)
def _base(part: Any, output: outputs.BaseOutput) -> PackedBase:
    odometry = part.publisher(output.topic, Odometry) if output.topic else None
    has_tf = output.advertises or output.with_transform
    transforms = part.publisher("/tf", TFMessage) if has_tf else None
    return PackedBase(
        odometry if output.with_odometry else None,
        transforms if output.with_transform else None,
        output,
        (output.frame_id, output.child_frame_id),
    )


@sends(outputs.TransformsOutput)
def _transforms(part: Any, output: outputs.TransformsOutput) -> Converted:
    def convert(time: float, transforms: Any) -> TFMessage:
        return TFMessage([conversions.transform_to_msg(time, *each) for each in transforms])

    return Converted(part.publisher(output.topic, TFMessage, relayed=output.relayed), convert)


@sends(outputs.ContactsOutput)
def _contacts(part: Any, output: outputs.ContactsOutput) -> PackedContacts:
    return PackedContacts(part.publisher(output.topic, ContactsState), output.frame_id)


@sends(outputs.ScanOutput)
def _scan(part: Any, output: outputs.ScanOutput) -> PackedScan:
    pub = part.publisher(output.topic, LaserScan)
    return PackedScan(pub, output.spec, output.increment, output.count)


@sends(outputs.ImuOutput)
def _imu(part: Any, output: outputs.ImuOutput) -> PackedImu:
    return PackedImu(part.publisher(output.topic, Imu), output.frame_id, output.variance)


@sends(outputs.ImageOutput)
def _image(part: Any, output: outputs.ImageOutput) -> Any:
    pub = part.publisher(output.topic, Image, relayed=False)
    return PackedImage(pub, output.frame_id, output.encoding)


def _fix(output: Any, time: float, place: Any, status: Any, errors: Any) -> NavSatFix:
    """Of a latitude, longitude [degrees] and altitude [m]; status and services; an ErrorModel."""
    fix = NavSatFix(header=conversions.header(time, output.frame_id))
    fix.status.status, fix.status.service = status
    fix.latitude, fix.longitude, fix.altitude = place
    variances = [n**2 + d**2 for n, d in zip(errors.noise, errors.drift)]
    fix.position_covariance[::4] = variances
    fix.position_covariance_type = NavSatFix.COVARIANCE_TYPE_DIAGONAL_KNOWN
    return fix


def _field(kind: type, name: str) -> tuple[Any, str, Callable[[Any], Any]]:
    """What has a field of a message of a type, named with dots: a function of the message, None for
    itself; the field's own name; what makes its value of numbers, or of a text."""
    path, _, last = name.rpartition(".")
    owner = operator.attrgetter(path) if path else None
    value_type = type(operator.attrgetter(name)(kind()))
    if value_type in (bool, int, float):
        return owner, last, lambda values: value_type(values[0])
    return owner, last, str if value_type is str else lambda values: value_type(*values)


@sends(outputs.NumbersOutput)
def _numbers(part: Any, output: outputs.NumbersOutput) -> Converted:
    kind = message_class(output.message)
    pub = part.publisher(output.topic, kind)
    if kind is NavSatFix:
        return Converted(pub, lambda *values: _fix(output, *values))
    fields = [_field(kind, name) for name in output.sizes]
    constant, has_header = dict(output.constant), "header" in kind.__slots__

    def convert(time: float, *values: Any) -> Any:
        if has_header:
            constant["header"] = conversions.header(time, output.frame_id)
        message = kind(**constant)
        for (owner, name, convert), value in zip(fields, values):
            setattr(message if owner is None else owner(message), name, convert(value))
        return message

    return Converted(pub, convert)
