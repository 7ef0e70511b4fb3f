"""Cameras and depth cameras: images requested from a renderer, sent when they are there."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from dataclasses import replace
from typing import Any, ClassVar

from bullet_sim.parts.base import Sensor, part_of
from bullet_sim.parts.outputs import DepthPointsOutput, ImageOutput
from bullet_sim.parts.schedule import is_late_enough, passed_rate, whole_rate
from bullet_sim.plugins import cameras as specs
from bullet_sim.pose import Array, Pose
from bullet_sim.render.request import CameraRequest, Frame
from bullet_sim.sensors import camera

NEVER_TAKEN = -math.inf  # [s]


@part_of(specs.CameraSpec)
class CameraSensor(Sensor):
    """sensor_msgs/Image; images come from a renderer.

    Attributes:
        number: of the camera among those that were made.
    """

    STATE: ClassVar[tuple[str, ...]] = ("_taken",)
    CACHE: ClassVar[tuple[str, ...]] = ("_is_free",)
    takes_images = True
    number = 0

    def __init__(self, context: Any) -> None:
        spec, model = context.spec, context.model
        camera.check(spec.width, spec.height, spec.horizontal_fov, spec.near, spec.far)
        self._is_free = spec.is_free
        self._taken = NEVER_TAKEN
        super().__init__(context)
        self._image = self.output(self._image_output())
        part, offset = model.link_in_body(spec.link)
        pose = offset * Pose.from_xyz_rpy(*spec.pose)
        request = CameraRequest.from_spec(spec, model.source.key, model.row(part), context.seed)
        name = f"{model.name}/{spec.link}/{spec.name}/{context.number}"
        self._request = replace(request, pose=(pose.position, pose.rpy), name=name)
        context.cameras.add(self)

    def _image_output(self) -> ImageOutput:
        spec = self.spec
        return ImageOutput(spec.topic, spec.frame_id, spec.encoding, spec.height, spec.width)

    def set_rate(self, rate: float) -> None:
        """Change the sensor's rate [Hz] (simulation thread)."""
        self._is_free = False
        super().set_rate(rate)

    def _rate(self) -> float:
        rate = super()._rate()
        return whole_rate(rate, self.world.time_step) if self._is_free else rate

    @property
    def nominal_rate(self) -> float:
        """Images a second [Hz] of simulated time that the rates of sensor and plugin leave."""
        rate, limit = self._rate(), self.spec.plugin_rate
        return rate if limit <= 0.0 else passed_rate(rate, limit, self.world.time_step)

    def restart(self, time: float) -> None:
        """The next image is soon enough."""
        super().restart(time)
        self._taken = NEVER_TAKEN

    def _passes(self, time: float) -> bool:
        """Whether the plugin's period has passed since the last time that it had."""
        limit = self.spec.plugin_rate
        if limit > 0.0 and not is_late_enough(time - self._taken, limit):
            return False
        self._taken = time
        return True

    def update(self, time: float, period: float) -> None:
        """Have an image rendered, which publish_frame gets later."""
        if self._passes(time):
            self.context.cameras.request(self.request)

    @property
    def request(self) -> CameraRequest:
        """CameraRequest of the images that have subscribers."""
        return self._request

    def publish_frame(self, frame: Frame) -> None:
        """Send a finished image with the snapshot's stamp."""
        self.publish_info(frame.time)
        self.send_pixels(frame.time, camera.pixels(frame.rgb, self.spec.encoding))

    def publish_info(self, time: float) -> None:
        """Tell what the camera is like, before an image of a simulated time [s]."""

    def send_pixels(self, time: float, pixels: Array) -> None:
        """Send an image's pixels in the encoding of the specification."""
        self._image.send(time, pixels)

    def close(self) -> None:
        """Nothing is rendered any more."""
        self.context.cameras.remove(self)
        super().close()


@part_of(specs.TriggeredCameraSpec)
class TriggeredCameraSensor(CameraSensor):
    """One image for each trigger that arrives while there are subscribers."""

    STATE: ClassVar[tuple[str, ...]] = ("_pending",)
    reports = False  # it has no rate

    def __init__(self, context: Any) -> None:
        self._pending = 0
        self._counting = threading.Lock()
        super().__init__(context)

    def commands(self) -> dict[str, tuple[Any, Callable[[Any], None]]]:
        """The triggers."""
        trigger = ("std_msgs/Empty", self._on_trigger)
        return dict.fromkeys(self.spec.trigger_topics, trigger)

    def reset(self, time: float) -> None:
        """Forget the triggers."""
        super().reset(time)
        self._pending = 0

    def _on_trigger(self, _message: Any) -> None:
        with self._counting:
            self._pending += super().needs_update()

    def needs_update(self) -> bool:
        """While there are triggers whose images were not requested."""
        return self._pending > 0 and super().needs_update()

    def update(self, time: float, period: float) -> None:
        """Have an image rendered, which counts for one trigger."""
        with self._counting:
            if self._pending == 0:
                return
            self._pending -= 1
        super().update(time, period)


class DepthSensor(CameraSensor):
    """A camera with depths, and their points."""

    def _depth_output(self, topic: str) -> ImageOutput:
        spec = self.spec
        encoding = "16UC1" if spec.millimeters else "32FC1"
        return ImageOutput(topic, spec.frame_id, encoding, spec.height, spec.width)

    def _points_output(self) -> Any:
        """What sends the points."""
        spec = self.spec
        k = camera.intrinsics(spec.width, spec.height, spec.horizontal_fov)
        return self.output(DepthPointsOutput(spec.points_topic, spec, k))

    def within_cutoffs(self, frame: Frame) -> Array:
        """Depths (H, W) [m] of an image; NaN outside the cutoffs."""
        return camera.within(frame.depth, self.spec.cutoff, self.spec.cutoff_max)


@part_of(specs.DepthCameraSpec)
class DepthCameraSensor(DepthSensor):
    """A color camera's topics, depth images, and points."""

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        self._depth = self.output(self._depth_output(self.spec.depth_topic))
        self._points = self._points_output()

    @property
    def nominal_rate(self) -> float:
        """That of the sensor: the plugin's is that of camera_info."""
        return self._rate()

    def update(self, time: float, period: float) -> None:
        """Have an image rendered; the plugin's rate is that of camera_info."""
        self.context.cameras.request(self.request)

    def publish_frame(self, frame: Frame) -> None:
        """Send a finished image, its depths and its points with the snapshot's stamp."""
        super().publish_frame(frame)
        deep, cloud = self._depth.has_subscribers(), self._points.has_subscribers()
        if frame.depth is None or not (deep or cloud):
            return
        depth = self.within_cutoffs(frame)
        if deep:
            self._depth.send(frame.time, camera.depth_pixels(depth, self.spec.millimeters))
        if cloud:  # as in Gazebo with the bytes of the image: red is blue unless it is bgr8
            self._points.send(frame.time, depth, camera.pixels(frame.rgb, self.spec.encoding))


@part_of(specs.RangeCameraSpec)
class RangeCameraSensor(DepthSensor):
    """The depth camera of a RealSense: depths as 16UC1, and points."""

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        self._points = self._points_output() if self.spec.points_topic else None

    def _image_output(self) -> ImageOutput:
        return self._depth_output(self.spec.topic)

    def publish_frame(self, frame: Frame) -> None:
        """Send depths and points with the snapshot's stamp."""
        self.publish_info(frame.time)
        if frame.depth is None:
            return
        spec = self.spec
        depth = camera.within(frame.depth, spec.range_min, min(spec.range_max, 65.535))
        self.send_pixels(frame.time, camera.depth_pixels(depth, spec.millimeters))
        if self._points is not None and self._points.has_subscribers():
            self._points.send(frame.time, self.within_cutoffs(frame), frame.rgb[:, :, ::-1])
