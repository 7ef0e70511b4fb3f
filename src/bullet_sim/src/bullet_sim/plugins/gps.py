"""GPS and magnetometer."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import Any, ClassVar

from bullet_sim.description.world import Place
from bullet_sim.errors import SimError
from bullet_sim.parts.base import part_of
from bullet_sim.parts.outputs import NumbersOutput
from bullet_sim.plugins.errors import TunedSensor, errors_of
from bullet_sim.plugins.inertial import body_frame, body_link, timer_rate
from bullet_sim.plugins.registry import model_plugin
from bullet_sim.plugins.spec import SensorSpec, number, reading, switch, topic_of
from bullet_sim.plugins.xml import (
    PluginXml,
)
from bullet_sim.pose import (
    ZERO_POSE,
    Pose,
    PoseTuple,
)
from bullet_sim.sensors import inertial
from bullet_sim.sensors.errors import ErrorModel, SensorErrors

OF_WORLD = "useWorldSphericalCoordinates"


def _of_place(tag: str, default: float = 0.0, then: Callable[[float], float] = float) -> Any:
    """A number of the place on the earth; None: that of the world counts."""

    def of(xml: PluginXml) -> float | None:
        if xml.switch(OF_WORLD) and xml.element.find(tag) is None:
            return None
        return then(xml.number(tag, default))

    return reading(of, then(default))


@model_plugin("hector_gazebo_ros_gps")
@dataclass(frozen=True)
class GpsSpec(SensorSpec):
    """A GPS receiver; x of the world points along reference_heading, y to the left of it.

    Attributes:
        rate: fixes per simulated second [Hz]; 0: every physics step.
        topic, velocity_topic: NavSatFix and Vector3Stamped.
        latitude, longitude: of the world's origin [degrees]; altitude [m].
        heading: of the world's x axis [rad], clockwise from north. None of these: the world's own.
        status, service: of NavSatStatus.
        errors, velocity_errors: of x, y, z [m] and of the velocities [m/s].
    """

    NAME = "gps"
    link: str = reading(body_link)
    pose: PoseTuple = ZERO_POSE
    rate: float = reading(lambda xml: timer_rate(xml, 4.0), 4.0)
    topic: str = topic_of("topicName", "fix")
    velocity_topic: str = topic_of("velocityTopicName", "fix_velocity")
    frame_id: str = reading(lambda xml: xml.frame("frameId", "/world"), "world")
    latitude: float | None = _of_place("referenceLatitude", 49.9)
    longitude: float | None = _of_place("referenceLongitude", 8.9)
    altitude: float | None = _of_place("referenceAltitude")
    heading: float | None = _of_place("referenceHeading", 0.0, math.radians)
    status: int = number("status", 0.0, int)
    service: int = number("service", 0.0, int)
    errors: ErrorModel = errors_of()
    velocity_errors: ErrorModel = errors_of("velocity")


@model_plugin("hector_gazebo_ros_magnetic")
@dataclass(frozen=True)
class MagneticSpec(SensorSpec):
    """A magnetometer in the earth's field.

    Attributes:
        rate: messages per simulated second [Hz]; 0: every physics step.
        magnitude: of the field, in the message's unit.
        heading: of the world's x axis [rad], clockwise from north; None: the world's own.
        declination, inclination: of the field [rad]; inclination positive downwards.
        field_message: MagneticField instead of Vector3Stamped.
        errors: along the sensor's axes.
    """

    NAME = "magnetic"
    link: str = reading(body_link)
    pose: PoseTuple = ZERO_POSE
    rate: float = reading(timer_rate, 0.0)
    topic: str = topic_of("topicName", "magnetic")
    frame_id: str = reading(body_frame, "base_link")
    magnitude: float = number("magnitude", 1.0)
    heading: float | None = _of_place("referenceHeading", 0.0, math.radians)
    declination: float = number("declination", 0.0, math.radians)
    inclination: float = number("inclination", 60.0, math.radians)
    field_message: bool = switch("useMagneticFieldMsgs")
    errors: ErrorModel = errors_of()


_SERVICES = {"SERVICE_GPS": 1, "SERVICE_GLONASS": 2, "SERVICE_COMPASS": 4, "SERVICE_GALILEO": 8}


_GNSS = tuple(  # hector_gazebo_plugins/GNSS.cfg
    (name, "bool", default, False, True, text)
    for name, default, text in (
        ("STATUS_FIX", True, "unaugmented fix"),
        ("STATUS_SBAS_FIX", False, "fix with satellite-based augmentation"),
        ("STATUS_GBAS_FIX", False, "with ground-based augmentation"),
        *((name, True, name.partition("_")[2]) for name in _SERVICES),
    )
)


def _gnss_values(status: int, service: int) -> dict[str, bool]:
    return {
        "STATUS_FIX": status != -1,
        "STATUS_SBAS_FIX": bool(status & 1),
        "STATUS_GBAS_FIX": bool(status & 2),
        **{name: bool(service & bit) for name, bit in _SERVICES.items()},
    }


@part_of(GpsSpec)
class GpsSensor(TunedSensor):
    """sensor_msgs/NavSatFix, and the velocity as geometry_msgs/Vector3Stamped.

    The velocity's axes point to the north, to the west and up.
    """

    STATE: ClassVar[tuple[str, ...]] = ("_reference", "_status")
    MESSAGE, FIELDS = "sensor_msgs/NavSatFix", {"fix": 3}
    resets = watches = True

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        spec = self.spec
        given = {field.name: getattr(spec, field.name) for field in fields(Place)}
        given = {name: value for name, value in given.items() if value is not None}
        self._reference: Place = replace(self.world.place, **given)
        self._meters = inertial.radii(self._reference.latitude)  # they stay, as upstream
        self.errors = SensorErrors(spec.errors), SensorErrors(spec.velocity_errors)
        self._status = (spec.status, spec.service)
        topic, message = spec.velocity_topic, "geometry_msgs/Vector3Stamped"
        self._velocities = self.output(NumbersOutput(topic, message, {"vector": 3}, spec.frame_id))

    def tuned(self) -> dict[str, SensorErrors]:
        names = (f"{self.spec.topic}/{name}" for name in ("position", "velocity"))
        return dict(zip(names, self.errors))

    def offer(self) -> None:
        super().offer()
        spec, kind = self.spec, "hector_gazebo_plugins/SetReferenceGeoPose"
        self.service(f"{spec.topic}/set_reference_geopose", kind, self._on_reference)
        values = _gnss_values(spec.status, spec.service)
        self.reconfigure(f"{spec.topic}/status", _GNSS, values, self._on_status)

    def _on_status(self, config: Any, _level: int) -> Any:
        status = -1
        if config["STATUS_FIX"]:
            status = config["STATUS_SBAS_FIX"] | 2 * config["STATUS_GBAS_FIX"]
        service = sum(bit for name, bit in _SERVICES.items() if config[name])
        self.call(lambda: setattr(self, "_status", (status, service)))
        return config

    def _on_reference(self, request: Any) -> None:
        position, q = request.geo_pose.position, request.geo_pose.orientation
        yaw = Pose(orientation=(q.x, q.y, q.z, q.w)).rpy[2]  # counter-clockwise from east
        numbers = (position.latitude, position.longitude, position.altitude, math.pi / 2.0 - yaw)
        if not (all(map(math.isfinite, numbers)) and abs(position.latitude) < 90.0):
            raise SimError(
                f"reference is {numbers[0]:g} degrees north, {numbers[1]:g} east, "
                f"{numbers[2]:g} m, must be finite, the latitude between -90 and 90"
            )

        def change() -> None:
            self._reference = Place(*numbers)
            self.restart_errors()

        self.call(change)

    def update(self, time: float, period: float) -> None:
        period, times = self.elapsed(time)
        position, _, linear, _ = self.sensor_motion()
        of_position, of_velocity = self.errors
        u, v, w = of_velocity.measured(linear, period, times, self.rng)
        fix = of_position.measured(position, period, times, self.rng)
        a, b, c = of_velocity.drift  # which the position's drift adds up
        x, y, z = of_position.drift
        elapsed = period * times
        of_position.drift = x + elapsed * a, y + elapsed * b, z + elapsed * c
        place = inertial.fix(fix, self._reference, self._meters)
        self._sender.send(time, place, self._status, of_position.spec)
        self._velocities.send(time, (*inertial.to_north_west(self._reference.heading, u, v), w))


@part_of(MagneticSpec)
class MagneticSensor(TunedSensor):
    """The earth's field in the sensor frame: Vector3Stamped or MagneticField."""

    resets = watches = True

    def __init__(self, context: Any) -> None:
        spec = context.spec
        self.errors = (SensorErrors(spec.errors),)
        super().__init__(context)
        heading = self.world.place.heading if spec.heading is None else spec.heading
        self._field = inertial.field(spec.magnitude, heading, spec.declination, spec.inclination)

    def make_output(self) -> NumbersOutput:
        message, field = "geometry_msgs/Vector3Stamped", "vector"
        if self.spec.field_message:
            message, field = "sensor_msgs/MagneticField", "magnetic_field"
        return NumbersOutput(self.spec.topic, message, {field: 3}, self.spec.frame_id)

    def tuned(self) -> dict[str, SensorErrors]:
        return {self.spec.topic: self.errors[0]}

    def measure(self, time: float) -> Any:
        pose, _, _ = self.sensor_state()
        true = (pose.matrix.T @ self._field).tolist()
        period, times = self.elapsed(time)
        return (self.errors[0].measured((true[0], true[1], true[2]), period, times, self.rng),)
