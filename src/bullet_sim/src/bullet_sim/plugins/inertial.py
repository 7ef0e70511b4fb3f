"""IMUs and ground truth."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, ClassVar

import numpy as np

from bullet_sim.errors import SimError
from bullet_sim.parts.base import Sensor, part_of
from bullet_sim.parts.outputs import ImuOutput, OdometryOutput
from bullet_sim.plugins.errors import TunedSensor, sensor_errors
from bullet_sim.plugins.registry import model_plugin, sensor_plugin
from bullet_sim.plugins.rules import MODEL, PLAIN, ROOT, Rule
from bullet_sim.plugins.spec import SensorSpec, read
from bullet_sim.plugins.xml import (
    PluginXml,
    SensorXml,
    Values,
    offset_of_merged,
)
from bullet_sim.pose import (
    ZERO,
    ZERO_POSE,
    Pose,
    PoseTuple,
    Quat,
    Vec3,
    multiply,
    quaternion_from_rpy,
    quaternion_from_yaw,
)
from bullet_sim.sensors import inertial
from bullet_sim.sensors.errors import Bias, BiasModel, ErrorModel, SensorErrors
from bullet_sim.xml_reader import document_root

OLD_YAW = "headingGaussianNoise"  # of older versions of hector's IMU, with its like


def timer_rate(xml: PluginXml, default: float = 0.0) -> float:
    """Rate [Hz] of hector's UpdateTimer: <updatePeriod>, seconds and nanoseconds, wins."""
    rate = xml.number("updateRate", default)
    seconds, _, rest = xml.text("updatePeriod").partition(" ")
    if xml.element.find("updatePeriod") is None:
        return max(0.0, rate)
    try:
        period = int(seconds) + int(rest or "0") * 1e-9
    except ValueError:
        period = 0.0
    return 1.0 / period if period > 0.0 else 0.0


def body_link(xml: PluginXml) -> str:
    """Link <bodyName>; the root link without one."""
    return xml.link("bodyName", xml.model.root)


def body_frame(xml: PluginXml) -> str:
    """Frame <frameId>; without one the link."""
    return xml.frame("frameId", xml.merged(body_link(xml)))


@dataclass(frozen=True)
class ImuSpec(SensorSpec):
    """An inertial measurement unit; rates [rad/s] and accelerations [m/s^2] in its own frame.

    Attributes:
        rate: messages per simulated second [Hz]; 0: every physics step.
        gyro_noise_mean, accel_noise_mean, and their like: one for all axes, or one for each.
        gyro_bias, accel_bias: their biases.
        variance: on the diagonals of the covariances.
        service: name of its std_srvs/Empty; "": none.
        turn: quaternion that is multiplied with the orientation from the left.
        relative: the orientation is relative to that at the start.
        orientation_noise: standard deviation on each number of the quaternion.
    """

    NAME, INTERFACE = "imu", "imu"
    rate: float = 100.0
    topic: str = "/imu"
    frame_id: str = "imu_link"
    gyro_noise_stddev: float | Vec3 = 0.0
    accel_noise_stddev: float | Vec3 = 0.0
    gyro_noise_mean: float | Vec3 = 0.0
    accel_noise_mean: float | Vec3 = 0.0
    variance: float = 0.0
    gyro_bias: BiasModel = BiasModel()
    accel_bias: BiasModel = BiasModel()
    service: str = ""
    turn: Quat = (0.0, 0.0, 0.0, 1.0)
    relative: bool = False
    orientation_noise: float = 0.0


@dataclass(frozen=True)
class ModelImuSpec(ImuSpec):
    """libgazebo_ros_imu.so's, which measures no gravity.

    Attributes:
        pose: xyz has no effect; rpy is multiplied with the link's orientation from the left.
    """


@dataclass(frozen=True)
class BiasedImuSpec(ImuSpec):
    """hector's IMU, whose present biases can be set.

    Attributes:
        bias_topic: of sensor_msgs/Imu with the biases; "": none.
        gyro, accel: errors of the rates [rad/s] and of the acceleration [m/s^2]. The squares of
            their noise are on the diagonals of these covariances; the orientation's are those of
            the acceleration over gravity squared, and of the heading.
        heading: errors of the heading [rad], all three alike.
    """

    bias_topic: str = ""
    gyro: ErrorModel = ErrorModel()
    accel: ErrorModel = ErrorModel()
    heading: ErrorModel = ErrorModel()


@dataclass(frozen=True)
class GroundTruthSpec:
    """Pose and velocity of a link without error, as libgazebo_ros_p3d publishes it.

    Attributes:
        link: link whose frame is reported.
        frame_id: of the header, <frameName> unless <headerFrame> says another.
        rate: messages per simulated second [Hz]; 0: every physics step.
        reference: link that pose and twist are relative to; "": the world; None: a link that does
            not exist, nothing is published.
        child_frame_id: the link's name in the message.
        twist_in_child: True: twist in the child frame, as nav_msgs/Odometry asks; False: along
            the world's axes, as upstream's plugin gives it.
        offset: (xyz [m], rpy [rad]), in the reference frame: added to the position, multiplied from
            the left with the orientation.
    """

    link: str
    topic: str
    frame_id: str = "world"
    rate: float = 50.0
    twist_in_child: bool = False
    child_frame_id: str = "base_link"
    noise_stddev: float = 0.0
    reference: str | None = ""
    offset: PoseTuple = ZERO_POSE


def _offset(xml: PluginXml, *tags: str) -> PoseTuple:
    """Pose of <xyzOffset> and <rpyOffset>.

    Args:
        tags: of links; where sdformat writes those that they are merged into, it moves the pose.
    """
    xyz, rpy = xml.vector("xyzOffset"), xml.vector("rpyOffset")
    robot = document_root(xml.element)
    names = [name for name in (xml.text(tag) for tag in tags) if name in xml.model.links]
    if robot.tag != "robot" or all(xml.merged(name) == name for name in names):
        return xyz, rpy
    return offset_of_merged(xml.model, names, xyz, rpy)


NANO = 1e-9  # of a ratio of rates, by which it may be off
WORLD_FRAMES = ("/world", "world", "/map", "map")  # values of <frameName> that are no link


@model_plugin("gazebo_ros_p3d", rule=PLAIN)
def ground_truth(xml: PluginXml) -> GroundTruthSpec:
    """GroundTruthSpec; <headerFrame> and <twistFrame> are Paddock's own, see there."""
    link = xml.merged(xml.link("bodyName"))
    frame = xml.merged(xml.text("frameName", "world"))
    reference: str | None = "" if frame in WORLD_FRAMES else frame
    if reference and reference not in xml.model.links:
        xml.warn(
            f"{xml.label} has frameName '{frame}', which is neither world nor map nor a link; "
            f"links are {', '.join(xml.model.links)}; it publishes nothing, as in Gazebo",
            "ground truth plugins have a frameName that is no link and publish nothing",
            f"'{frame}'",
        )
        reference = None
    return GroundTruthSpec(
        link=link,
        topic=xml.given_topic(),
        frame_id=xml.frame("headerFrame", frame),
        reference=reference,
        rate=xml.number("updateRate"),
        twist_in_child=xml.text("twistFrame", "world") == "child",
        child_frame_id=link,
        noise_stddev=abs(xml.number("gaussianNoise")),
        offset=_offset(xml, "bodyName", "frameName"),
    )


def _imu_spec(xml: PluginXml, kind: type[ImuSpec], **values: Any) -> ImuSpec:
    """Specification of a plugin with <gaussianNoise>; values: what differs between plugins."""
    name = xml.name or kind.NAME
    noise = abs(Values(xml.element, f"imu '{name}'").number("gaussianNoise"))
    values = {"gyro_noise_stddev": noise, "accel_noise_stddev": noise, **values}
    return read(kind, xml, variance=noise**2, **values)


def _of_imu(xml: PluginXml) -> dict[str, str]:
    """Topic and service of libgazebo_ros_imu.so."""
    return {
        name: xml.topic(tag, "/default_imu")
        for name, tag in (("topic", "topicName"), ("service", "serviceName"))
    }


@model_plugin("gazebo_ros_imu")
def model_imu(xml: PluginXml) -> ImuSpec:
    link = xml.merged(xml.link("bodyName"))
    return _imu_spec(
        xml,
        ModelImuSpec,
        link=link,
        pose=_offset(xml, "bodyName", "frameName"),
        rate=xml.number("updateRate"),
        frame_id=xml.frame("frameName", link, merge=True),
        **_of_imu(xml),
    )


@sensor_plugin("gazebo_ros_imu", types=("imu",))
def imu(xml: SensorXml) -> ImuSpec:
    """ImuSpec of a plugin that belongs into <gazebo>, but is often in a <sensor>."""
    frame = xml.frame("frameName", xml.text("bodyName", xml.parent))
    return _imu_spec(xml, ImuSpec, rate=xml.rate(), frame_id=frame, **_of_imu(xml))


def _alike(values: list[float]) -> float | Vec3:
    """A number for all axes, or three."""
    x, y, z = values
    return x if x == y == z else (x, y, z)


def _bias(sensor: Values, paths: list[str]) -> BiasModel:
    """Bias of three axes, each with the path of its <noise>."""

    def of(tag: str) -> Vec3:
        x, y, z = (sensor.number(f"{path}/{tag}") for path in paths)
        return x, y, z

    return BiasModel(
        of("bias_mean"),
        of("bias_stddev"),
        of("dynamic_bias_stddev"),
        of("dynamic_bias_correlation_time"),
        of("precision"),
    )


@sensor_plugin("gazebo_ros_imu_sensor", types=("imu",), rule=Rule(MODEL, ROOT))
def imu_sensor(xml: SensorXml) -> ImuSpec:
    """ImuSpec of a plugin that needs a <frameName>.

    Raises:
        MissingPart: there is none.
    """
    if xml.element.find("frameName") is None:
        raise xml.lacks("frameName")
    plugin, sensor = xml.plugin("imu"), Values(xml.sensor, f"imu '{xml.name}'")
    own, wanted = sensor.number("update_rate"), plugin.number("updateRateHZ", 1.0)
    rate = xml.rate("updateRateHZ", 1.0)
    if 0.0 < wanted < own:  # the first measurement that is late enough
        rate = own / math.ceil(own / wanted - NANO)
    mean, stddev, bias = {}, {}, {}
    plugin_noise = abs(plugin.number("gaussianNoise"))
    for key, tag in (("gyro", "angular_velocity"), ("accel", "linear_acceleration")):
        paths = [f"imu/{tag}/{axis}/noise" for axis in "xyz"]
        values = [sensor.noise(path) for path in paths]
        mean[key] = _alike([value[0] for value in values])
        stddev[key] = _alike([math.hypot(plugin_noise, value[1]) for value in values])
        bias[key] = _bias(sensor, paths)
    return _imu_spec(
        xml,
        ImuSpec,
        rate=rate,
        frame_id=xml.frame("frameName", xml.parent),
        topic=xml.topic("topicName", "imu_data"),
        gyro_noise_mean=mean["gyro"],
        accel_noise_mean=mean["accel"],
        gyro_noise_stddev=stddev["gyro"],
        accel_noise_stddev=stddev["accel"],
        gyro_bias=bias["gyro"],
        accel_bias=bias["accel"],
        orientation_noise=plugin_noise,
        turn=quaternion_from_rpy(*plugin.vector("rpyOffset")),
        relative=xml.switch("initialOrientationAsReference"),
    )


@model_plugin("hector_gazebo_ros_imu")
def hector_imu(xml: PluginXml) -> BiasedImuSpec:
    noise, topic = abs(xml.number("gaussianNoise")), xml.topic("topicName", "imu")
    return read(
        BiasedImuSpec,
        xml,
        link=body_link(xml),
        pose=(ZERO, xml.vector("rpyOffset", broadcast=True)),
        rate=timer_rate(xml),
        topic=topic,
        bias_topic=xml.topic("biasTopicName", f"{topic}/bias"),
        service=xml.topic("serviceName", f"{topic}/calibrate"),
        frame_id=body_frame(xml),
        gyro=sensor_errors(xml, "rate", noise),
        accel=sensor_errors(xml, "accel", noise),
        heading=sensor_errors(xml, "yaw" if xml.element.find(OLD_YAW) is None else "heading"),
    )


@part_of(GroundTruthSpec)
class GroundTruthSensor(Sensor):
    """nav_msgs/Odometry without error, in the world or relative to a link."""

    whole_periods = watches = True

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        self._shift: Pose | None = Pose.from_xyz_rpy(*self.spec.offset)
        if self._shift == Pose():
            self._shift = None

    def make_output(self) -> OdometryOutput:
        spec, variances = self.spec, [self.spec.noise_stddev**2] * 6
        frames = spec.frame_id, spec.child_frame_id
        return OdometryOutput(spec.topic, *frames, variances, variances)

    def needs_update(self) -> bool:
        """As ModelPlugin; never where the reference link does not exist."""
        return self.spec.reference is not None and super().needs_update()

    def measure(self, time: float) -> Any:
        linear: Any
        angular: Any
        position, orientation, linear, angular = self.model.link_motion(self.spec.link)
        if self.spec.reference:
            frame = self.model.link_motion(self.spec.reference)
            position, orientation, linear, angular = inertial.relative_motion(
                (position, orientation, linear, angular), frame
            )
        if self._shift is not None:
            x, y, z = np.add(position, self._shift.position).tolist()
            position, orientation = (x, y, z), multiply(self._shift.orientation, orientation)
        linear, angular = inertial.twist(orientation, linear, angular, self.spec.twist_in_child)
        if self.spec.noise_stddev > 0:
            linear = linear + self.rng.normal(0, self.spec.noise_stddev, 3)
            angular = angular + self.rng.normal(0, self.spec.noise_stddev, 3)
        return position, orientation, linear, angular

    def recorded(self) -> Any:
        """In the world."""
        return None if self.spec.reference else self.model.recorded_motion(self.spec.link)

    def measure_recorded(self, recorded: Any, steps: Sequence[int]) -> Any:
        chosen, spec = self.world.recorded(steps), self.spec
        position, orientation, linear, angular = (
            tuple(values[chosen] for values in part) for part in recorded
        )  # type: Any, Any, Any, Any
        if self._shift is not None:
            position = [a + b for a, b in zip(position, self._shift.position)]
            orientation = multiply(self._shift.orientation, orientation)
        linear, angular = inertial.twists(orientation, linear, angular, spec.twist_in_child)
        if spec.noise_stddev > 0:
            noise = self.rng.normal(0, spec.noise_stddev, (len(steps), 6)).T
            linear, angular = np.add(linear, noise[:3]), np.add(angular, noise[3:])
        return position, orientation, linear, angular


@part_of(ImuSpec)
class ImuSensor(Sensor):
    """sensor_msgs/Imu: proper acceleration, mean over the sensor's period."""

    STATE: ClassVar[tuple[str, ...]] = ("_before", "_reference", "_gyro_bias", "_accel_bias")
    waits_for_time = watches = whole_periods = True

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        self._gyro_bias, self._accel_bias = Bias(self.spec.gyro_bias), Bias(self.spec.accel_bias)

    def make_output(self) -> ImuOutput:
        return ImuOutput(self.spec.topic, self.spec.frame_id, self.spec.variance)

    def start(self, time: float) -> None:
        """Measure from now on."""
        self._before: Any = None  # (velocity, time) at the last measurement
        x, y, z, w = self.pose().orientation if self.spec.relative else (0.0, 0.0, 0.0, 1.0)
        self._reference: Quat = (-x, -y, -z, w)  # from the left to an orientation in the world
        self._gyro_bias.restart(self.rng)
        self._accel_bias.restart(self.rng)

    def offer(self) -> None:
        super().offer()
        if self.spec.service:
            self.service(self.spec.service, "std_srvs/Empty", self._on_calibrate)

    def _on_calibrate(self, _request: Any) -> None:
        """A simulated IMU is calibrated."""

    def measure(self, time: float) -> tuple[Quat, Vec3, Vec3]:
        """Orientation, angular velocity [rad/s] and specific force [m/s^2] at a time [s]."""
        period = 0.0 if self._before is None else time - self._before[1]
        orientation, rate, force = self._ideal(time)
        spec = self.spec
        if spec.relative:
            orientation = multiply(self._reference, orientation)
        if spec.turn[:3] != (0.0, 0.0, 0.0):
            orientation = multiply(spec.turn, orientation)
        if spec.orientation_noise > 0.0:  # also of its length, as upstream
            a, b, c, d = self.rng.normal(0.0, spec.orientation_noise, 4).tolist()
            x, y, z, w = orientation
            orientation = x + a, y + b, z + c, w + d
        rate = self._noisy(rate, spec.gyro_noise_stddev, spec.gyro_noise_mean)
        force = self._noisy(force, spec.accel_noise_stddev, spec.accel_noise_mean)
        if not self._gyro_bias.is_none:
            rate = self._gyro_bias.measured(rate, period, self.rng)
        if not self._accel_bias.is_none:
            force = self._accel_bias.measured(force, period, self.rng)
        return orientation, rate, force

    def recorded(self) -> Any:
        """Of this class alone, without a bias."""
        own = type(self)
        simple = own.measure is ImuSensor.measure and own._ideal is ImuSensor._ideal
        if not (simple and self._gyro_bias.is_none and self._accel_bias.is_none):
            return None
        return self.model.recorded_motion(self.spec.link)

    def measure_recorded(self, recorded: Any, steps: Sequence[int]) -> Any:
        spec, times = self.spec, self.world.times(steps)
        _, orientation, linear, angular = self.recorded_motion(recorded, steps)
        force = inertial.specific_forces(linear, self._before, times, self.world.gravity)
        x, y, z = (float(values[-1]) for values in linear)
        self._before = ((x, y, z), times[-1])
        force, rate = inertial.twists(orientation, force, angular)
        if spec.relative:
            orientation = multiply(self._reference, orientation)
        if spec.turn[:3] != (0.0, 0.0, 0.0):
            orientation = multiply(spec.turn, orientation)
        values = np.array((*orientation, *rate, *force))
        means, drawn, deviations = self._noise
        if means is not None:
            values += means
        if len(drawn):
            values[drawn] += self.rng.normal(0.0, deviations, (len(steps), len(drawn))).T
        return (values,)

    @cached_property
    def _noise(self) -> tuple[Any, list[int], list[float]]:
        """Of the numbers of a message: means (10, 1) or None; which have noise in the order in
        which it is drawn, and its standard deviations."""
        spec = self.spec
        means = [0.0] * 4
        drawn: list[tuple[int, float]] = []
        if spec.orientation_noise > 0.0:
            drawn += [(row, spec.orientation_noise) for row in range(4)]
        for first, mean, stddev in (
            (4, spec.gyro_noise_mean, spec.gyro_noise_stddev),
            (7, spec.accel_noise_mean, spec.accel_noise_stddev),
        ):
            means += [mean] * 3 if isinstance(mean, float) else mean
            if _is_noisy(stddev):
                of_axes = stddev if isinstance(stddev, tuple) else (stddev,) * 3
                drawn += zip(range(first, first + 3), of_axes)
        rows, deviations = zip(*drawn) if drawn else ((), ())
        return np.array(means)[:, None] if any(means) else None, list(rows), list(deviations)

    def _ideal(self, time: float) -> tuple[Quat, Vec3, Vec3]:
        """As measure(), without errors."""
        _, orientation, linear, angular = self.sensor_motion()
        force = inertial.specific_force(linear, self._before, time, self.world.gravity)
        self._before = (linear, time)
        force, rate = inertial.twist(orientation, force, angular)
        return orientation, rate, force

    def _noisy(self, values: Vec3, stddev: float | Vec3, mean: float | Vec3) -> Vec3:
        """Values with white Gaussian noise of a mean and a standard deviation; 0: none."""
        x, y, z = values
        if mean:
            a, b, c = (mean, mean, mean) if isinstance(mean, float) else mean
            x, y, z = x + a, y + b, z + c
        if _is_noisy(stddev):
            a, b, c = self.rng.normal(0.0, stddev, 3).tolist()
            x, y, z = x + a, y + b, z + c
        return x, y, z


def _is_noisy(stddev: float | Vec3) -> bool:
    """Whether noise of a standard deviation is drawn."""
    return isinstance(stddev, tuple) or stddev > 0.0


@part_of(ModelImuSpec)
class ModelImuSensor(ImuSensor):
    """As libgazebo_ros_imu.so: without gravity, and turned as there.

    That plugin turns rates and accelerations from the world's axes by the orientation instead of by
    its inverse. So they are in the sensor's axes only while these are parallel to the world's.
    """

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        self._turn = Pose.from_xyz_rpy(*self.spec.pose).orientation

    def _ideal(self, time: float) -> tuple[Quat, Vec3, Vec3]:
        _, orientation, linear, angular = self.model.link_motion(self.spec.link)
        x, y, z, w = orientation = multiply(self._turn, orientation)
        acceleration = inertial.specific_force(linear, self._before, time, (0.0, 0.0, 0.0))
        self._before = (linear, time)
        turned = inertial.twist((-x, -y, -z, w), angular, acceleration)
        return orientation, *turned


@part_of(BiasedImuSpec)
class BiasedImuSensor(ImuSensor, TunedSensor):
    """An IMU with biases that drift and that services set.

    As upstream <rpyOffset> is multiplied with the link's orientation from the left, which gives the
    orientation and the axes of accelerations; rates are in the sensor's own axes.
    """

    CACHE: ClassVar[tuple[str, ...]] = ("_gravity", "_link")
    resets, whole_periods = True, False

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        spec = self.spec
        self.errors = tuple(map(SensorErrors, (spec.accel, spec.gyro, spec.heading)))
        self._gravity: float | None = None  # [m/s^2] that the sent variances are computed with
        self._bias_sender = None
        if spec.bias_topic:
            self._bias_sender = self.output(ImuOutput(spec.bias_topic, spec.frame_id))
        self._turn = Pose.from_xyz_rpy(*spec.pose).orientation

    def tuned(self) -> dict[str, SensorErrors]:
        names = (f"{self.spec.topic}/{name}" for name in ("accel", "rate", "yaw"))
        return dict(zip(names, self.errors))

    def offer(self) -> None:
        super().offer()
        for name, errors in zip(("set_accel_bias", "set_rate_bias"), self.errors):
            service = f"{self.spec.topic}/{name}"
            self.service(service, "hector_gazebo_plugins/SetBias", partial(self._on_bias, errors))

    def _on_bias(self, errors: SensorErrors, request: Any) -> None:
        bias = float(request.bias.x), float(request.bias.y), float(request.bias.z)
        if not all(map(math.isfinite, bias)):
            raise SimError(f"bias is {list(bias)}, must be finite numbers")
        self.call(lambda: setattr(errors, "drift", bias))

    def _on_calibrate(self, _request: Any) -> None:
        """The gyroscopes lose their bias."""
        self.call(lambda: setattr(self.errors[1], "drift", ZERO))

    def _ideal(self, time: float) -> tuple[Quat, Vec3, Vec3]:
        _, self._link, linear, angular = self.model.link_motion(self.spec.link)
        orientation = multiply(self._turn, self._link)
        force = inertial.specific_force(linear, self._before, time, self.world.gravity)
        self._before = (linear, time)
        force, _ = inertial.twist(orientation, force, angular)
        rate, _ = inertial.twist(multiply(self._link, self._turn), angular, angular)
        return orientation, rate, force

    def measure(self, time: float) -> tuple[Quat, Vec3, Vec3]:
        """As an ImuSensor, with the biases, which also tilt and turn the orientation."""
        spec, (period, times) = self.spec, self.elapsed(time)
        orientation, rate, force = self._ideal(time)
        of_force, of_rate, of_heading = self.errors
        force = of_force.measured(force, period, times, self.rng)
        rate = of_rate.measured(rate, period, times, self.rng)
        of_heading.measured(ZERO, period, times, self.rng)
        tilting = of_force.bias
        gravity = math.hypot(*self.world.gravity)
        if gravity != self._gravity:
            self._gravity = gravity
            rates, forces = ([n * n for n in of.noise] for of in (spec.gyro, spec.accel))
            tilt = [v / gravity**2 if gravity > 0.0 else -1.0 for v in forces[:2]]
            self._sender.set_variances([*tilt, spec.heading.noise[0] ** 2], rates, forces)
        if gravity > 0.0 and any(tilting):
            orientation = inertial.tilt_error(orientation, tilting, gravity, self._link)
        if yaw := of_heading.bias[0]:
            orientation = multiply(quaternion_from_yaw(yaw), orientation)
        if self._bias_sender is not None:
            self._bias_sender.send(time, (0.0, 0.0, 0.0, 1.0), of_rate.bias, tilting)
        return orientation, rate, force
