"""Depth cameras: colour and depth pictures, their camera_info, and the point cloud."""

import numpy as np
from bullet_sim.sensors import camera
from sensor_msgs.msg import CameraInfo, Image, PointCloud2, PointField

from bullet_bridge.outputs.sensors import CameraOutput
from bullet_bridge.transport import conversions
from bullet_bridge.transport.publishing import publisher

# PCL's layout of a point: x y z, 4 unused bytes, colour (blue, green, red, 0).
_POINT = np.dtype(
    {"names": ["xyz", "bgr"], "formats": ["(3,)<f4", "(3,)u1"], "offsets": [0, 16], "itemsize": 32}
)
_FIELDS = [
    PointField(name=name, offset=offset, datatype=PointField.FLOAT32, count=1)
    for name, offset in (("x", 0), ("y", 4), ("z", 8), ("rgb", 16))
]


def depth_image(time, spec, depth):
    """sensor_msgs/Image of depths (H, W) float32 [m], NaN: unknown.

    32FC1 [m] or, with spec.millimetres, 16UC1 [mm] and 0 for unknown.
    """
    height, width = depth.shape
    if spec.millimetres:
        data = np.nan_to_num(np.rint(depth * 1000.0), nan=0.0, posinf=0.0, neginf=0.0)
        data, encoding, size = np.clip(data, 0, 65535).astype("<u2"), "16UC1", 2
    else:
        data, encoding, size = depth.astype("<f4"), "32FC1", 4
    message = Image(
        height=height, width=width, encoding=encoding, step=size * width, data=data.tobytes()
    )
    message.header.stamp, message.header.frame_id = conversions.stamp(time), spec.frame_id
    return message


def point_cloud(time, spec, depth, rgb, k):
    """sensor_msgs/PointCloud2, organised like the picture, in the optical frame.

    Args:
        depth: (H, W) float32 [m], NaN: unknown.
        rgb: (H, W, 3) uint8.
        k: (3, 3) [px].
    """
    data = np.zeros(depth.shape, _POINT)
    data["xyz"] = camera.points(depth, k)
    data["bgr"] = rgb[:, :, ::-1]
    message = conversions.cloud(data, _FIELDS, bool(np.isfinite(depth).all()))
    message.header.stamp, message.header.frame_id = conversions.stamp(time), spec.frame_id
    return message


class DepthCameraOutput(CameraOutput):
    """A colour camera's topics, depth pictures with their camera_info, and points."""

    def __init__(self, world, model, spec, seed):
        super().__init__(world, model, spec, seed)
        self._k = camera.intrinsics(spec.width, spec.height, spec.horizontal_fov)
        self._depth = publisher(spec.depth_topic, Image, relayed=False)
        self._depth_info = publisher(spec.depth_info_topic, CameraInfo, relayed=False)
        self._points = publisher(spec.points_topic, PointCloud2, relayed=False)

    def has_subscribers(self):
        return super().has_subscribers() or any(
            out.get_num_connections() > 0 for out in (self._depth, self._depth_info, self._points)
        )

    def publish_frame(self, frame):
        """Publish a finished picture, its depths and its points with the snapshot's stamp."""
        super().publish_frame(frame)
        self._depth_info.publish(self.info_message(frame.time))
        deep, cloud = (out.get_num_connections() > 0 for out in (self._depth, self._points))
        if frame.depth is None or not (deep or cloud):
            return
        depth = camera.within(frame.depth, self.spec.cutoff, self.spec.cutoff_max)
        if deep:
            self._depth.publish(depth_image(frame.time, self.spec, depth))
        if cloud:
            self._points.publish(point_cloud(frame.time, self.spec, depth, frame.rgb, self._k))

    def close(self):
        super().close()
        for out in (self._depth, self._depth_info, self._points):
            out.unregister()


class RangeCameraOutput(CameraOutput):
    """The depth camera of a RealSense: depths as 16UC1, their camera_info, and points."""

    def __init__(self, world, model, spec, seed):
        super().__init__(world, model, spec, seed)
        self._k = camera.intrinsics(spec.width, spec.height, spec.horizontal_fov)
        self._points = None
        if spec.points_topic:
            self._points = publisher(spec.points_topic, PointCloud2, relayed=False)

    def _has_points(self):
        return self._points is not None and self._points.get_num_connections() > 0

    def has_subscribers(self):
        return super().has_subscribers() or self._has_points()

    def publish_frame(self, frame):
        """Publish depths and points with the snapshot's stamp."""
        self._info_publisher.publish(self.info_message(frame.time))
        if frame.depth is None:
            return
        spec = self.spec
        depth = camera.within(frame.depth, spec.range_min, min(spec.range_max, 65.535))
        self.publisher.publish(depth_image(frame.time, spec, depth))
        if self._has_points():
            near = camera.within(frame.depth, spec.cutoff, spec.cutoff_max)
            self._points.publish(point_cloud(frame.time, spec, near, frame.rgb, self._k))

    def close(self):
        super().close()
        if self._points is not None:
            self._points.unregister()
