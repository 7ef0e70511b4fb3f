"""What IMU, GPS and magnetometer have in ROS beside their messages: services, parameters."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import rospy
from bullet_sim.description.world import Place
from bullet_sim.parts import inertial as parts
from bullet_sim.plugins import inertial as specs
from bullet_sim.pose import Pose, Vec3
from hector_gazebo_plugins.srv import (
    SetBias,
    SetBiasResponse,
    SetReferenceGeoPose,
    SetReferenceGeoPoseResponse,
)
from paddock_common.reconfigure import describe
from std_srvs.srv import Empty as EmptyService
from std_srvs.srv import EmptyResponse

from bullet_bridge.plugins.base import ModelPlugin, PluginContext, ros_side
from bullet_bridge.plugins.errors import Tuned

_SERVICES = {"SERVICE_GPS": 1, "SERVICE_GLONASS": 2, "SERVICE_COMPASS": 4, "SERVICE_GALILEO": 8}
GNSS = describe(  # hector_gazebo_plugins/GNSS.cfg
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


class Calibrated(ModelPlugin):
    """An IMU with the service that calibrates it."""

    def __init__(self, context: PluginContext) -> None:
        super().__init__(context)
        if self.spec.service:
            self.service(self.spec.service, EmptyService, self._on_calibrate)

    def _on_calibrate(self, _request: Any) -> EmptyResponse:
        """A simulated IMU is calibrated."""
        return EmptyResponse()


@ros_side(specs.ImuSpec)
class ImuSensor(Calibrated, parts.ImuSensor):
    """sensor_msgs/Imu, with its service."""


@ros_side(specs.ModelImuSpec)
class ModelImuSensor(Calibrated, parts.ModelImuSensor):
    """That of libgazebo_ros_imu.so, with its service."""


@ros_side(specs.BiasedImuSpec)
class BiasedImuSensor(Calibrated, Tuned, parts.BiasedImuSensor):
    """An IMU with biases that services set."""

    def __init__(self, context: PluginContext) -> None:
        super().__init__(context)
        for name, set_bias in (
            ("set_accel_bias", self._set_force_bias),
            ("set_rate_bias", self._set_rate_bias),
        ):
            self.service(f"{self.spec.topic}/{name}", SetBias, self._handler(set_bias))

    def _handler(self, set_bias: Callable[[Vec3], None]) -> Callable[[Any], SetBiasResponse]:
        def handle(request: Any) -> SetBiasResponse:
            bias = float(request.bias.x), float(request.bias.y), float(request.bias.z)
            if not all(map(math.isfinite, bias)):
                raise rospy.ServiceException(f"bias is {list(bias)}, must be finite numbers")
            self.call(lambda: set_bias(bias))
            return SetBiasResponse()

        return handle

    def _set_force_bias(self, bias: Vec3) -> None:
        self.errors[0].drift = bias

    def _set_rate_bias(self, bias: Vec3) -> None:
        self.errors[1].drift = bias

    def _on_calibrate(self, request: Any) -> EmptyResponse:
        """The gyroscopes lose their bias."""
        self.call(lambda: self._set_rate_bias(parts.NO_BIAS))
        return super()._on_calibrate(request)


@ros_side(specs.GpsSpec)
class GpsSensor(Tuned, parts.GpsSensor):
    """Fixes and velocities, with services and parameters."""

    def __init__(self, context: PluginContext) -> None:
        super().__init__(context)
        spec = self.spec
        name = f"{spec.topic}/set_reference_geopose"
        self.service(name, SetReferenceGeoPose, self._on_reference)
        values = _gnss_values(spec.status, spec.service)
        self.reconfigure(f"{spec.topic}/status", GNSS, values, self._on_status)

    def _on_status(self, config: Any, _level: int) -> Any:
        status = -1
        if config["STATUS_FIX"]:
            status = config["STATUS_SBAS_FIX"] | 2 * config["STATUS_GBAS_FIX"]
        service = sum(bit for name, bit in _SERVICES.items() if config[name])

        self.call(lambda: setattr(self, "_status", (status, service)))
        return config

    def _on_reference(self, request: Any) -> SetReferenceGeoPoseResponse:
        position, q = request.geo_pose.position, request.geo_pose.orientation
        yaw = Pose(orientation=(q.x, q.y, q.z, q.w)).rpy[2]  # counter-clockwise from east
        numbers = (position.latitude, position.longitude, position.altitude, math.pi / 2.0 - yaw)
        if not (all(map(math.isfinite, numbers)) and abs(position.latitude) < 90.0):
            raise rospy.ServiceException(
                f"reference is {numbers[0]:g} degrees north, {numbers[1]:g} east, "
                f"{numbers[2]:g} m, must be finite, the latitude between -90 and 90"
            )

        def change() -> None:
            self._reference = Place(*numbers)
            self.restart_errors()

        self.call(change)
        return SetReferenceGeoPoseResponse()


@ros_side(specs.MagneticSpec)
class MagneticSensor(Tuned, parts.MagneticSensor):
    """The earth's field, with errors that can be changed."""
