"""Cameras and depth cameras: images requested from the renderer, published when they arrive."""

from __future__ import annotations

import copy
import json
import threading
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
import rospy
from bullet_sim.errors import RenderError
from bullet_sim.parts.outputs import DepthPointsOutput
from bullet_sim.plugins import cameras as core
from bullet_sim.plugins import depth_cameras
from bullet_sim.pose import Array
from bullet_sim.render.client import RenderClient
from bullet_sim.render.request import DEFAULT, CameraRequest, Frame, Quality
from bullet_sim.sensors import camera
from paddock_common.reconfigure import describe
from sensor_msgs.msg import CameraInfo, Image, PointCloud2
from sensor_msgs.srv import SetCameraInfo, SetCameraInfoResponse
from std_msgs.msg import String

from bullet_bridge.plugins.base import ModelPlugin, PluginContext, has_subscribers, ros_side
from bullet_bridge.plugins.compressed import CompressedImages, SavedImages
from bullet_bridge.transport import conversions
from bullet_bridge.transport.packed import PackedImage
from bullet_bridge.transport.publishing import publisher
from bullet_bridge.transport.senders import Converted, sends

if TYPE_CHECKING:
    from bullet_sim.description.world import Scene
    from bullet_sim.snapshot import BodySource
    from bullet_sim.world import World


class Cameras:
    """All camera sensors and the worker that renders their images.

    Args:
        renderer: auto, gl or tiny.
        wait: True: wait for each due image, as in lockstep: none is skipped, and the physics
            waits for the renderer.
        scene: function without arguments that returns the world's Scene.
    """

    def __init__(
        self,
        renderer: str,
        wait: bool,
        quality: Quality = DEFAULT,
        scene: Callable[[], Scene | None] = lambda: None,
    ) -> None:
        self._renderer, self._wait, self._quality = renderer, wait, quality
        self._scene = scene
        self._client: Any = None  # RenderClient, once start() was called
        self._sensors: dict[str, CameraSensor] = {}
        self._count = 0  # of the cameras that were there
        self._due: list[CameraRequest] = []
        self._starter: Any = None
        self._starting, self._sending = threading.Lock(), threading.Lock()
        self._publishing = threading.Lock()
        self._ready = False
        self._sources: list[BodySource] = []
        self._failures: list[str] = []
        self._names: Any = None
        self._legend: Any = None

    def start(self) -> None:
        """Start the worker unless that was done; called outside the simulation thread.

        Where each image is waited for this returns when the worker is up or has failed;
        elsewhere immediately, and images come when it is up.
        """
        with self._starting:
            if self._starter is None:
                self._client = RenderClient(
                    on_frame=self._publish_late,
                    on_error=rospy.logerr,
                    zero_copy=True,
                    quality=self._quality,
                )
                self._starter = threading.Thread(
                    target=self._start, name="render-start", daemon=True
                )
                self._starter.start()
        if self._wait:
            self._starter.join()

    def _start(self) -> None:
        try:
            chosen = self._client.start(self._renderer)
        except RenderError as error:
            rospy.logerr("cameras publish no images: %s", error)
            return
        rospy.loginfo(
            "cameras are rendered by '%s' (%s)%s",
            chosen.kind,
            chosen.details,
            f", since {chosen.reason}" if chosen.reason else "",
        )
        with self._sending:
            self._client.set_sources(self._sources, self._scene())
            self._ready = True

    def publish_labels(self, names: Callable[[], dict[int, str]]) -> None:
        """Publish a label image for each camera, and the latched topic ~labels: what labels mean,
        as JSON {"label": "model's name"}.

        Args:
            names: function without arguments that returns them by label.
        """
        self._names = names
        self._legend = publisher(rospy.resolve_name("~labels"), String, latch=True)

    def add(self, sensor: CameraSensor) -> None:
        self.start()
        self._count += 1
        sensor.number = self._count
        if self._legend is not None:
            sensor.add_labels()
        self._sensors[sensor.request.name] = sensor

    def remove(self, sensor: CameraSensor) -> None:
        if self._sensors.get(sensor.request.name) is sensor:  # not a later one of the same name
            del self._sensors[sensor.request.name]

    def set_sources(self, sources: list[BodySource]) -> None:
        """Send the worker the present bodies."""
        if self._legend is not None:
            self._legend.publish(json.dumps(self._names()))
        with self._sending:
            self._sources = sources
            if self._ready:
                self._client.set_sources(sources, self._scene())

    def restart(self) -> None:
        """Discard images requested before a reset: none is published once this has returned."""
        client = self._client
        if client is not None:
            with self._publishing:
                client.discard()

    def request(self, request: CameraRequest) -> None:
        """Have an image rendered with the next flush() (simulation thread)."""
        self._due.append(request)

    def flush(self, world: World, waits: bool = False) -> None:
        """Have what was requested rendered, all from one snapshot (simulation thread).

        Args:
            waits: wait for a renderer that is being started.
        """
        requests, self._due = self._due, []
        if not requests:
            return
        if waits and not self._ready and self._starter is not None:
            self._starter.join()
        if not self._ready:
            self._failures = ["there is no renderer, images are missing"]
            return
        if not self._wait:
            requests = self._client.needing_snapshot(requests)
            if requests:
                self._client.submit(world.snapshot(), requests)
            return
        try:
            for frame in self._client.render_sync(world.snapshot(), requests):
                self._publish(frame)
        except RenderError as error:
            text = f"images at {world.time:.3f} s are missing: {error}"
            rospy.logerr_throttle(5.0, text)
            self._failures = self._failures[-2:] + [text]

    def take_failures(self) -> list[str]:
        """Failures in lockstep since the last call, at most three messages."""
        failures, self._failures = self._failures, []
        return failures

    def _publish_late(self, frame: Frame) -> None:
        """Publish an image of the worker, unless there was a reset since it was requested."""
        with self._publishing:
            if frame.epoch == self._client.epoch:
                self._publish(frame)

    def _publish(self, frame: Frame) -> None:
        sensor = self._sensors.get(frame.camera)
        if sensor is not None and not rospy.is_shutdown():
            try:
                sensor.publish_frame(frame)
                if frame.labels is not None:
                    sensor.publish_labels(frame.time, frame.labels)
            except rospy.ROSException:
                pass  # the topic was just unregistered

    def close(self) -> None:
        """Shut the worker down."""
        self._ready = False
        if self._client is not None:
            self._client.close()


IMAGER_RATES = (1.0, 50.0)  # [Hz] range of imager_rate
IMAGER = describe(  # gazebo_plugins/GazeboRosCamera.cfg
    [
        (
            "imager_rate",
            "double",
            2.0,
            *IMAGER_RATES,
            "Rate of the sensor [Hz]. It acts from the first change on; the rate of the "
            "file holds before.",
        )
    ]
)


@ros_side(core.CameraSpec)
class CameraSensor(ModelPlugin, core.CameraSensor):
    """sensor_msgs/Image, CompressedImage and CameraInfo; images come from the render worker.

    Attributes:
        compresses: it has the compressed topic, too.
    """

    CACHE: ClassVar[tuple[str, ...]] = ("_labels", "_label_sender", "_assigned")
    compresses: ClassVar[bool] = True

    def __init__(self, context: PluginContext) -> None:
        spec = context.spec
        self._labels: Any = None
        super().__init__(context)
        self._info_publisher = self.publisher(spec.info_topic, CameraInfo, relayed=False)
        self._compressed = (
            CompressedImages(self, spec.topic, spec.frame_id, spec.encoding)
            if self.compresses
            else None
        )
        self._info = camera.camera_info_arrays(
            spec.width,
            spec.height,
            spec.horizontal_fov,
            spec.coefficients,
            spec.focal_length,
            (spec.center_x, spec.center_y),
        )
        self._assigned: CameraInfo | None = None  # by set_camera_info
        if spec.namespace:
            name = f"{spec.namespace.rstrip('/')}/set_camera_info"
            self.service(name, SetCameraInfo, self._on_set_info)
        if spec.tunable:
            self.reconfigure(spec.namespace, IMAGER, dict(IMAGER.defaults), self._on_rate)
        self._saved = self._saved_images()

    def _saved_images(self) -> SavedImages | None:
        """What writes the images of a camera with <save> to files."""
        spec, model = self.spec, self.model
        if not spec.save:
            return None
        link = spec.link if spec.link in model.bodies else model.link_in_body(spec.link)[0]
        name = f"{self.world.name}::{model.name}::{link}::{spec.name}({self.number})"
        return SavedImages(spec.save, name.replace("::", "_"))

    def _on_set_info(self, request: Any) -> SetCameraInfoResponse:
        """From now on camera_info is the request's, as of upstream's camera_info_manager."""
        self._assigned = request.camera_info
        return SetCameraInfoResponse(success=True)

    def _on_rate(self, config: Any, _level: int) -> Any:
        """Change the sensor's rate; that of the plugin stays a limit."""
        self.call(lambda: self.set_rate(config["imager_rate"]))
        return config

    @property
    def request(self) -> CameraRequest:
        """CameraRequest of the images that have subscribers."""
        return replace(self._request, labels=True) if self._has_labels() else self._request

    def add_labels(self) -> None:
        """Publish label images, too: labels/image_raw next to camera_info."""
        namespace = self.spec.info_topic.rsplit("/", 1)[0]
        self._labels = self.publisher(f"{namespace}/labels/image_raw", Image, relayed=False)
        self._label_sender = PackedImage(self._labels, self.spec.frame_id, "32SC1")

    def _has_labels(self) -> bool:
        return has_subscribers(self._labels)

    def publish_labels(self, time: float, labels: Array) -> None:
        """Publish a finished label image with the snapshot's stamp."""
        self._label_sender.send(time, labels)

    def publish_frame(self, frame: Frame) -> None:
        """Publish a finished image and its camera_info with the snapshot's stamp; write it to a
        file where the camera has <save>."""
        if self._saved is not None:
            self._saved.write(frame.rgb)
        super().publish_frame(frame)

    def send_pixels(self, time: float, pixels: Array) -> None:
        """Publish an image's pixels, compressed ones, too."""
        super().send_pixels(time, pixels)
        if self._compressed is not None:
            self._compressed.publish(time, pixels)

    def publish_info(self, time: float) -> None:
        """Publish camera_info for an image of a simulated time [s]."""
        self._info_publisher.publish(self.info_message(time))

    def info_message(self, time: float) -> CameraInfo:
        """camera_info for a simulated time [s]."""
        info = copy.deepcopy(self._assigned) or conversions.camera_info(self.spec, self._info)
        info.header.stamp = conversions.stamp(time)
        return info


@ros_side(core.TriggeredCameraSpec)
class TriggeredCameraSensor(CameraSensor, core.TriggeredCameraSensor):
    """One image for each trigger that arrives while there are subscribers."""

    def _on_rate(self, config: Any, _level: int) -> Any:
        """Has no effect on a camera without a rate."""
        return config


# PCL's layout of a point: x y z, 4 unused bytes, 3 bytes of color.
_POINT, _FIELDS = conversions.point_layout(32, ("rgb", 16, "(3,)u1"))


class PointClouds:
    """Makes the point clouds of one depth camera.

    Args:
        spec: of the camera.
        k: (3, 3) [px].
    """

    def __init__(self, spec: Any, k: Array) -> None:
        self._spec, self._k = spec, k
        self._data = np.zeros((0, 0), _POINT)  # the last cloud's: new memory each time is slow

    def message(self, time: float, depth: Array, colors: Array) -> PointCloud2:
        """sensor_msgs/PointCloud2 in the optical frame.

        Args:
            depth: (H, W) float32 [m], NaN: unknown.
            colors: (H, W, 3) or (H, W) uint8; PCL takes the first of three for blue. Of others
                points are black, as upstream.
        """
        spec = self._spec
        if self._data.shape != depth.shape:
            self._data = np.zeros(depth.shape, _POINT)
        data = self._data
        camera.points(depth, self._k, data["xyz"])
        data["rgb"] = colors.reshape(*depth.shape, -1) if colors.dtype == np.uint8 else 0
        if not spec.organized:
            data = data.reshape(1, -1)
        header = conversions.header(time, spec.frame_id)
        return conversions.cloud(header, data, _FIELDS, bool(np.isfinite(depth).all()))


@sends(DepthPointsOutput)
def _depth_points(part: Any, output: DepthPointsOutput) -> Converted:
    publisher = part.publisher(output.topic, PointCloud2, relayed=False)
    return Converted(publisher, PointClouds(output.spec, output.k).message)


@ros_side(depth_cameras.DepthCameraSpec)
class DepthCameraSensor(CameraSensor, depth_cameras.DepthCameraSensor):
    """A color camera's topics, depth images with their camera_info, and points."""

    def __init__(self, context: PluginContext) -> None:
        super().__init__(context)
        self._depth_info = self.publisher(self.spec.depth_info_topic, CameraInfo, relayed=False)

    def is_subscribed(self) -> bool:
        """While a topic but the depths' camera_info has subscribers, which activates no sensor."""
        endpoints = (endpoint for endpoint in self._publishers if endpoint is not self._depth_info)
        return any(map(has_subscribers, endpoints))

    def publish_info(self, time: float) -> None:
        """Publish camera_info of both images when it is due."""
        if self.spec.tells_info and self._passes(time):
            super().publish_info(time)
            self._depth_info.publish(self.info_message(time))


@ros_side(depth_cameras.RangeCameraSpec)
class RangeCameraSensor(CameraSensor, depth_cameras.RangeCameraSensor):
    """The depth camera of a RealSense: depths as 16UC1, their camera_info, and points."""

    compresses = False
