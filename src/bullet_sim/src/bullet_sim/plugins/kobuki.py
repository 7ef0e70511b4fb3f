"""The base of a TurtleBot 2: drive, odometry, and events of its bumper, cliff and wheel sensors."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar
from xml.etree.ElementTree import Element

import numpy as np

from bullet_sim.component import Stateful
from bullet_sim.description.collisions import merged
from bullet_sim.parts.base import PARTS, part_of
from bullet_sim.parts.outputs import ImuOutput, JointStatesOutput, NumbersOutput
from bullet_sim.parts.schedule import is_late_enough
from bullet_sim.plugins.contacts import ContactPair, ContactSpec
from bullet_sim.plugins.drives import BaseSpec, DrivenBase, read_log_level, with_wheels
from bullet_sim.plugins.inertial import ImuSpec
from bullet_sim.plugins.lidars import RaySpec, rays
from bullet_sim.plugins.registry import model_plugin
from bullet_sim.plugins.rules import UTILS_OF_MODELS, FrameName
from bullet_sim.plugins.spec import (
    PluginSpec,
    not_negative,
    number,
    read,
    reading,
    switch,
)
from bullet_sim.plugins.xml import PluginXml, SensorXml
from bullet_sim.pose import ZERO, quaternion_from_yaw, rpy_from_quaternion
from bullet_sim.xml_reader import sdf_pose

SIDES, PLACES = ("left", "right"), ("left", "center", "right")  # in the order of their numbers
BITS = {"left": 4, "center": 2, "right": 1}  # of SensorState's bumper and cliff
DROP_BITS = {"left": 2, "right": 1}  # of its wheel_drop
IMU_LINK = "base_footprint"  # the only one whose IMU upstream finds
PREFIX = "mobile_base"  # of topics; upstream's default of the parameter base_prefix
BUMPER = "bumper"
TAGS = {
    **{f"cliff {place}": (f"cliff_sensor_{place}_name", "ray") for place in PLACES},
    BUMPER: ("bumper_name", "contact"),
    **{f"drop {side}": (f"wheel_drop_{side}_sensor_name", "contact") for side in SIDES},
    "imu": ("imu_name", "imu"),
}  # sensor -> tag with its name, its type
BUMPER_HEIGHTS = (0.01, 0.13)  # of contacts above the model's origin that count [m]
SECTOR = math.pi / 6.0  # half of the middle one of the three bumpers [rad]
# Of an infrared sensor: its reading is SCALE * atan2(NEAR, range [m]), of 32 bits as upstream's.
SCALE, NEAR = 76123.0, float(np.float32(0.995))
MOTORS_OFF, MOTORS_ON = 0, 1  # states of kobuki_msgs/MotorPower
NONE: frozenset[str] = frozenset()
UNTURNED = (0.0, 0.0, 0.0, 1.0)


def _topic(path: str) -> Any:
    """Full name of a topic."""
    return reading(lambda xml: xml.names.topic(path), f"/{path}")


def _frame(name: str) -> Any:
    """Name of a frame."""
    return reading(lambda xml: FrameName(name, xml.names.prefix()), name)


@dataclass(frozen=True)
class KobukiSpec(BaseSpec):
    """libgazebo_ros_kobuki: the base of a TurtleBot 2.

    Attributes:
        left, right: the wheels' joints, one of each side.
        separation, diameter: of the wheels [m].
        publish_tf: publish the odometry's transform on /tf.
        timeout: without a command after which it stops [s].
        rate: of all that it publishes [Hz]; 0: every physics step.
        threshold: range from which on a cliff sensor tells of a cliff [m].
        sensors: a key of TAGS -> specification of that sensor, which has no topic.
        states_topic, imu_topic: of sensor_msgs/JointState and sensor_msgs/Imu.
        base_frame: of these.
        power_topic, restart_topic: switch the motors, put the odometry to zero.
        bumper_topic, cliff_topic, drop_topic, core_topic: of messages of kobuki_msgs.
    """

    NAME = "kobuki"
    command_topic: str = _topic(f"{PREFIX}/commands/velocity")
    topic: str = _topic("odom")
    frame_id: str = _frame("odom")
    child_frame_id: str = _frame(IMU_LINK)
    pose_covariance: tuple[float, ...] = (0.1, 0.1, 1e6, 1e6, 1e6, 0.05)
    left: tuple[str, ...] = ()
    right: tuple[str, ...] = ()
    separation: float = number("wheel_separation", 0.23)
    diameter: float = number("wheel_diameter", 0.07)
    rate: float = number("update_rate", 0.0, not_negative)
    publish_tf: bool = switch("publish_tf")
    timeout: float = number("velocity_command_timeout", 0.6)
    threshold: float = number("cliff_detection_threshold", 0.04)
    sensors: Mapping[str, PluginSpec] = field(default_factory=dict)
    states_topic: str = _topic("joint_states")
    imu_topic: str = _topic(f"{PREFIX}/sensors/imu_data")
    base_frame: str = _frame("base_link")
    power_topic: str = _topic(f"{PREFIX}/commands/motor_power")
    restart_topic: str = _topic(f"{PREFIX}/commands/reset_odometry")
    bumper_topic: str = _topic(f"{PREFIX}/events/bumper")
    cliff_topic: str = _topic(f"{PREFIX}/events/cliff")
    drop_topic: str = _topic(f"{PREFIX}/events/wheel_drop")
    core_topic: str = _topic(f"{PREFIX}/sensors/core")


@model_plugin("gazebo_ros_kobuki", rule=UTILS_OF_MODELS, reads_sensors=True)
def kobuki(xml: PluginXml) -> KobukiSpec | None:
    """KobukiSpec; None, with a warning, without a wheel's joint or with wheels of no size.

    <torque> has to be there, and upstream uses it nowhere.

    Raises:
        MissingPart: a tag is missing, or names no sensor of its type.
    """
    read_log_level(xml)
    for tag in ("wheel_separation", "wheel_diameter", "torque", "velocity_command_timeout",
                "cliff_detection_threshold"):  # fmt: skip
        if xml.element.find(tag) is None:
            raise xml.lacks(tag)
    left, right = ((xml.in_scope(xml.text(f"{side}_wheel_joint_name")),) for side in SIDES)
    sensors = {key: _sensor(xml, *tag) for key, tag in TAGS.items()}
    return with_wheels(KobukiSpec, xml, left, right, sensors=sensors)


def _sensor(xml: PluginXml, tag: str, kind: str) -> PluginSpec:
    """Specification of the sensor that a tag names."""
    if not (name := xml.text(tag)):
        raise xml.lacks(tag)
    known: dict[str, tuple[str, Element]] = {}
    for link, _, element in xml.model.sensor_elements:
        if element.get("type") == kind and (kind != "imu" or xml.merged(link) == IMU_LINK):
            known.setdefault(element.get("name") or "", (link, element))
    if name not in known:
        place = f" in {IMU_LINK}" if kind == "imu" else ""
        raise xml.names_no(tag, name, known, f"sensor of type {kind}{place}")
    link, element = known[name]
    pose = sdf_pose(element, f"sensor '{name}'")
    own = SensorXml(xml.element, xml.model, element, link, pose)
    if kind == "ray":
        return read(RaySpec, own, **rays(own), rate=own.rate(None), topic="", frame_id="")
    if kind == "contact":
        return read(ContactSpec, own, topic="", frame_id="")
    return read(ImuSpec, own, rate=own.rate(None), topic="", relative=True)


class Kept(Stateful):
    """Keeps what a sensor without a topic measured last."""

    STATE = ("values",)

    def __init__(self) -> None:
        self.values: tuple[Any, ...] = ()

    def has_subscribers(self) -> bool:
        """Always: its plugin reads it."""
        return True

    def send(self, _time: float, *values: Any) -> None:
        """Keep the values of a measurement."""
        self.values = values


@part_of(KobukiSpec)
class KobukiPlugin(DrivenBase):
    """Drives two wheels; publishes what the base of a TurtleBot 2 tells.

    The way of its odometry is that of the wheels' speeds, the heading that of its IMU's yaw rate.
    """

    STATE: ClassVar[tuple[str, ...]] = (
        "_sensors", "_kept", "_since", "_motors", "_pose2d", "_pressed", "_cliffs", "_dropped",
    )  # fmt: skip
    CACHE: ClassVar[tuple[str, ...]] = ("_numbers",)
    COMMANDS: ClassVar[Mapping[str, tuple[Any, str]]] = {
        **DrivenBase.COMMANDS,
        "power_topic": ("kobuki_msgs/MotorPower", "_on_power"),
        "restart_topic": ("std_msgs/Empty", "_on_restart"),
    }
    every_step, resets = True, False

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        spec, model = self.spec, self.model
        self._kept = {key: Kept() for key in spec.sensors}
        self._sensors = {key: self._make_sensor(key) for key in spec.sensors}
        self._wheels = (*spec.left, *spec.right)
        self._numbers = [model.joints.names.index(name) for name in self._wheels]
        self._threshold = float(np.float32(spec.threshold))  # as upstream's
        self._bumper_link = f"{model.name}::{merged(model.description)[spec.sensors[BUMPER].link]}"
        base = spec.base_frame
        self._states = self.output(
            JointStatesOutput(spec.states_topic, self._wheels, frame_id=base)
        )
        self._imu = self.output(ImuOutput(spec.imu_topic, base))
        self._imu.set_variances([1e6, 1e6, 0.05], [1e6, 1e6, 0.05], [0.0] * 3)
        self._bumper = self._messages(spec.bumper_topic, "BumperEvent", "bumper", "state")
        self._cliff = self._messages(spec.cliff_topic, "CliffEvent", "sensor", "state", "bottom")
        self._drop = self._messages(spec.drop_topic, "WheelDropEvent", "wheel", "state")
        self._core = self._messages(
            spec.core_topic, "SensorState", "bumper", "cliff", "wheel_drop", frame=base
        )

    def _make_sensor(self, key: str) -> Any:
        spec, seed = self.spec.sensors[key], self.context.seed + list(TAGS).index(key)
        context = replace(self.context, spec=spec, seed=seed, connect=lambda _: self._kept[key])
        return PARTS.of(spec)(context)

    def _messages(self, topic: str, kind: str, *fields: str, frame: str = "") -> Any:
        """What sends numbers as a message of kobuki_msgs."""
        sizes = dict.fromkeys(fields, 1)
        return self.output(NumbersOutput(topic, f"kobuki_msgs/{kind}", sizes, frame))

    def _sends(self) -> tuple[bool, bool]:
        return True, self.spec.publish_tf

    def reset(self, time: float) -> None:
        """As loaded: without a command, motors on, odometry at zero, no event told."""
        self._since, self._motors, self._pose2d = time, True, (0.0, 0.0, 0.0)
        self._pressed = self._cliffs = self._dropped = NONE
        super().reset(time)

    def start(self, time: float) -> None:
        """Its sensors start, too."""
        super().start(time)
        for sensor in self._sensors.values():
            sensor.restart(time)
            sensor.schedule.check_subscribers(self.world.step_count)

    def on_time_step(self) -> None:
        """As a Part; and its sensors'."""
        super().on_time_step()
        for sensor in self._sensors.values():
            sensor.on_time_step()

    def _on_command(self, message: Any) -> None:
        self._since = self.world.time
        super()._on_command(message)

    def _on_power(self, message: Any) -> None:
        self._motors = {MOTORS_OFF: False, MOTORS_ON: True}.get(message.state, self._motors)

    def _on_restart(self, _message: Any) -> None:
        self._pose2d = (0.0, 0.0, 0.0)

    def update(self, time: float, period: float) -> None:
        for sensor in self._sensors.values():
            if sensor.schedule.due(self.world.step_count):
                sensor.update(time, time - sensor.updated)
                sensor.updated = time
        if time - self._since > self.spec.timeout or not self._motors:
            self._command = self.standing
        self._turn()
        elapsed = time - self._before
        if self.spec.rate > 0.0 and not is_late_enough(elapsed, self.spec.rate):
            return
        self._before = time
        self._publish(time, elapsed)

    def _turn(self) -> None:
        spec, (forward, yaw_rate) = self.spec, self._command
        half, radius = yaw_rate * spec.separation / 2.0, spec.diameter / 2.0
        speeds = [(forward - half) / radius, (forward + half) / radius]
        self.model.joints.impose_velocities(self._wheels, speeds)

    def _publish(self, time: float, elapsed: float) -> None:
        positions, speeds, _ = self.model.joints.columns(self._numbers)
        measured: Any = self._kept["imu"].values or (UNTURNED, ZERO, ZERO)
        if self._states.has_subscribers():
            self._states.send(time, positions, speeds, (0.0, 0.0))
        self._add_way(time, elapsed, sum(speeds) / 2.0 * self.spec.diameter / 2.0, measured[1][2])
        if self._imu.has_subscribers():
            self._imu.send(time, *measured)
        ranges = {place: self._range(place) for place in PLACES}
        far = {place for place in PLACES if ranges[place] >= self._threshold}
        self._cliffs = _send_changes(time, self._cliff, self._cliffs, far, PLACES, ranges)
        pressed = self._pressed_now()
        self._pressed = _send_changes(time, self._bumper, self._pressed, pressed, PLACES)
        dropped = {side for side in SIDES if not self._contacts(f"drop {side}")}
        self._dropped = _send_changes(time, self._drop, self._dropped, dropped, SIDES)
        if self._core.has_subscribers():
            states = (pressed, BITS), (far, BITS), (dropped, DROP_BITS)
            self._core.send(time, *((sum(bits[n] for n in names),) for names, bits in states))

    def _add_way(self, time: float, elapsed: float, speed: float, yaw_rate: float) -> None:
        """Go on by a speed [m/s] and a yaw rate [rad/s], and publish the odometry."""
        x, y, yaw = self._pose2d
        x, y = x + elapsed * speed * math.cos(yaw), y + elapsed * speed * math.sin(yaw)
        self._pose2d = x, y, yaw + yaw_rate * elapsed
        if self._sender.has_subscribers():
            orientation = quaternion_from_yaw(self._pose2d[2])
            twist = (speed, 0.0, 0.0), (0.0, 0.0, yaw_rate)
            self._sender.send(time, (x, y, 0.0), orientation, *twist)

    def _range(self, place: str) -> float:
        """Of the first ray of a cliff sensor [m]; 0 before its first scan."""
        values = self._kept[f"cliff {place}"].values
        return float(values[0][0]) if values else 0.0

    def _contacts(self, key: str) -> Sequence[ContactPair]:
        """Of a contact sensor, since its update before the last one."""
        values = self._kept[key].values
        return values[0] if values else ()

    def _pressed_now(self) -> set[str]:
        """Which bumpers the contacts are on, by the directions of their normals."""
        pressed = set()
        pairs = self._contacts(BUMPER)
        if pairs:
            pose = self.model.pose
            heading = rpy_from_quaternion(pose.orientation)[2]
        for pair in pairs:
            lowest, highest = BUMPER_HEIGHTS
            if lowest <= pair.positions[0, 2] - pose.position[2] <= highest:
                sign = -1.0 if pair.first.startswith(self._bumper_link) else 1.0
                x, y = (sign * pair.normals[0, :2]).tolist()
                angle = math.atan2(y, x) - heading
                if abs(angle) <= SECTOR:
                    pressed.add("center")
                elif SECTOR < angle <= 3.0 * SECTOR:
                    pressed.add("left")
                elif -3.0 * SECTOR <= angle < -SECTOR:
                    pressed.add("right")
        return pressed


def _send_changes(
    time: float,
    sender: Any,
    before: frozenset[str],
    now: set[str],
    names: Sequence[str],
    ranges: Mapping[str, float] | None = None,
) -> frozenset[str]:
    """Send an event of each name that has come or gone; returns those that are there."""
    for place, name in enumerate(names):
        if (name in before) != (name in now):
            infrared = () if ranges is None else ((_reading(ranges[name]),),)
            sender.send(time, (place,), (int(name in now),), *infrared)
    return frozenset(now)


def _reading(distance: float) -> int:
    """Of an infrared sensor at a range [m], as uint16."""
    return int(SCALE * math.atan2(NEAR, distance)) & 0xFFFF
