"""Depth cameras, also those of a RealSense."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any
from xml.etree.ElementTree import Element

from bullet_sim.parts.base import part_of
from bullet_sim.parts.outputs import DepthPointsOutput, ImageOutput
from bullet_sim.plugins.cameras import (
    CameraSensor,
    CameraSpec,
    camera_values,
)
from bullet_sim.plugins.registry import model_plugin, sensor_plugin
from bullet_sim.plugins.rules import UTILS_OF_SENSORS
from bullet_sim.plugins.xml import PluginXml, SensorXml, library
from bullet_sim.pose import Array
from bullet_sim.render.request import Frame
from bullet_sim.sensors import camera as pinhole
from bullet_sim.xml_reader import document_root, is_true, sdf_pose


@dataclass(frozen=True)
class DepthCameraSpec(CameraSpec):
    """A color camera that also measures distances along its optical axis.

    Attributes:
        depth_topic, depth_info_topic, points_topic: resolved topic names.
        cutoff, cutoff_max: depths outside are unknown: NaN [m].
        organized: whether the points have the rows and columns of the image, instead of one row.
        tells_info: it publishes camera_info, at most plugin_rate times a second.
        millimeters: depth images are 16UC1 [mm] with 0 for unknown, instead of 32FC1 [m].
    """

    depth_topic: str = "/camera/depth/image_raw"
    depth_info_topic: str = "/camera/depth/camera_info"
    points_topic: str = "/camera/points"
    cutoff: float = 0.4
    cutoff_max: float = 5.0
    millimeters: bool = False
    organized: bool = True
    tells_info: bool = True
    depth = True


@dataclass(frozen=True)
class RangeCameraSpec(DepthCameraSpec):
    """The depth camera of a RealSense, without a color image: 16UC1 [mm], 0 for unknown.

    Attributes:
        range_min, range_max: depths outside are unknown in the image [m].
        points_topic: of the point cloud; empty: none. The cutoffs are those of the points.
    """

    range_min: float = 0.0
    range_max: float = 65.535


@sensor_plugin(
    "gazebo_ros_depth_camera",
    "gazebo_ros_openni_kinect",
    types=("camera", "depth", "depth_camera"),
    rule=UTILS_OF_SENSORS,
)
def depth_camera(xml: SensorXml) -> DepthCameraSpec:
    """DepthCameraSpec; as in Gazebo only openni_kinect has a pointCloudCutoffMax.

    Upstream depth_camera advertises camera_info and never publishes it, and openni_kinect's
    updateRate limits camera_info alone; it is used where the sensor has none.
    """
    plugin, group = xml.plugin("depth camera"), xml.text("cameraName")
    is_kinect = library(xml.element) == "gazebo_ros_openni_kinect"
    values = camera_values(xml)
    if values["is_free"]:
        values.update(plugin_rate=0.0, is_free=False)
    return DepthCameraSpec(
        **dict(values, noise_mean=0.0, noise_stddev=0.0),
        depth_topic=xml.topic("depthImageTopicName", "depth/image_raw", group),
        depth_info_topic=xml.topic("depthImageCameraInfoTopicName", "depth/camera_info", group),
        points_topic=xml.topic("pointCloudTopicName", "points", group),
        cutoff=plugin.number("pointCloudCutoff", 0.4),
        cutoff_max=plugin.number("pointCloudCutoffMax", 5.0) if is_kinect else math.inf,
        organized=is_kinect,
        tells_info=is_kinect,
        waits=is_kinect,
        millimeters=is_true(xml.text("useDepth16UC1Format")),
    )


# RealSense ----------------------------------------------------------------------------------------
_STREAMS = {  # sensor's name -> the start of its tags, and the default topic
    "color": ("color", "color/image_raw"),
    "ired1": ("infrared1", "infra1/image_raw"),
    "ired2": ("infrared2", "infra2/image_raw"),
    "depth": ("depth", "depth/image_raw"),
}


@model_plugin("realsense_gazebo_plugin", reads_sensors=True)
def realsense(xml: PluginXml) -> list[CameraSpec]:
    """Specs of the four cameras of a model, identified by their names."""
    prefix, sensors, specs = xml.text("prefix"), _sensors_by_name(xml), []
    for stream in _STREAMS:
        name = prefix + stream
        if name in sensors:
            specs.append(_stream(xml, stream, *sensors[name]))
        else:
            xml.warn(
                f"{xml.label} needs a camera sensor '{name}', which the model lacks; it is left out"
            )
    return specs


def _stream(xml: PluginXml, stream: str, sensor: Element, link: str) -> CameraSpec:
    """One of the four cameras.

    Topics are below the plugin's own name; camera_info is in the namespace of each image, and has
    half the image's size as its center.
    """
    (tag, default), handle = _STREAMS[stream], xml.name or "realsense"
    pose = sdf_pose(sensor, f"sensor '{sensor.get('name')}'")
    topic = xml.names.topic(f"/{handle}/{xml.text(f'{tag}TopicName', default)}")
    values = dict(
        camera_values(SensorXml(xml.element, xml.model, sensor, link, pose)),
        topic=topic,
        info_topic=topic.rsplit("/", 1)[0] + "/camera_info",
        frame_id=xml.frame(f"{tag}OpticalframeName", link),
        namespace="",
        tunable=False,
        plugin_rate=0.0,
        is_free=False,
        focal_length=0.0,
        coefficients=(),
        baseline=0.0,
        bare_info=True,
    )
    values.update(center_x=values["width"] / 2.0, center_y=values["height"] / 2.0)
    if values["encoding"] == "mono8":
        values["encoding"] = "8UC1"  # as the plugin names it
    if stream != "depth":
        return CameraSpec(**values)
    values.update(noise_mean=0.0, noise_stddev=0.0)
    points = xml.names.topic(f"/{handle}/{xml.text('pointCloudTopicName', 'depth/color/points')}")
    return RangeCameraSpec(
        **values,
        depth_topic=topic,
        depth_info_topic=values["info_topic"],
        millimeters=True,
        range_min=xml.number("rangeMinDepth"),
        range_max=xml.number("rangeMaxDepth", 65.535),
        points_topic=points if is_true(xml.text("pointCloud")) else "",
        cutoff=xml.number("pointCloudCutoff"),
        cutoff_max=xml.number("pointCloudCutoffMax", 5.0),
    )


def _sensors_by_name(xml: PluginXml) -> dict[str | None, tuple[Element, str]]:
    """Name -> (<sensor>, link) of the sensors in a plugin's document."""
    sensors: dict[str | None, tuple[Element, str]] = {}
    for holder in document_root(xml.element).iter():
        link = holder.get("reference") if holder.tag == "gazebo" else holder.get("name")
        if holder.tag in ("gazebo", "link") and link in xml.model.links:
            for sensor in holder.findall("sensor"):
                sensors.setdefault(sensor.get("name"), (sensor, link))
    return sensors


class DepthSensor(CameraSensor):
    """A camera with depths, and their points."""

    def _depth_output(self, topic: str) -> ImageOutput:
        spec = self.spec
        encoding = "16UC1" if spec.millimeters else "32FC1"
        return ImageOutput(topic, spec.frame_id, encoding, spec.height, spec.width)

    def _points_output(self) -> Any:
        """What sends the points."""
        spec = self.spec
        k = pinhole.intrinsics(spec.width, spec.height, spec.horizontal_fov)
        return self.output(DepthPointsOutput(spec.points_topic, spec, k))

    def within_cutoffs(self, frame: Frame) -> Array:
        """Depths (H, W) [m] of an image; NaN outside the cutoffs."""
        return pinhole.within(frame.depth, self.spec.cutoff, self.spec.cutoff_max)


@part_of(DepthCameraSpec)
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
            self._depth.send(frame.time, pinhole.depth_pixels(depth, self.spec.millimeters))
        if cloud:  # as in Gazebo with the bytes of the image: red is blue unless it is bgr8
            self._points.send(frame.time, depth, pinhole.pixels(frame.rgb, self.spec.encoding))


@part_of(RangeCameraSpec)
class RangeCameraSensor(DepthSensor):
    """The depth camera of a RealSense: depths as 16UC1, and points."""

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        self._points = self._points_output() if self.spec.points_topic else None

    def make_output(self) -> ImageOutput:
        return self._depth_output(self.spec.topic)

    def publish_frame(self, frame: Frame) -> None:
        """Send depths and points with the snapshot's stamp."""
        self.publish_info(frame.time)
        if frame.depth is None:
            return
        spec = self.spec
        depth = pinhole.within(frame.depth, spec.range_min, min(spec.range_max, 65.535))
        self.send_pixels(frame.time, pinhole.depth_pixels(depth, spec.millimeters))
        if self._points is not None and self._points.has_subscribers():
            self._points.send(frame.time, self.within_cutoffs(frame), frame.rgb[:, :, ::-1])
