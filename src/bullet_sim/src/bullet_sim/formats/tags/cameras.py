"""<sensor>s with pictures, and their plugins -> specifications."""

from bullet_sim.description.specs import CameraSpec, DepthCameraSpec
from bullet_sim.formats.tags import lenses
from bullet_sim.formats.tags.sensor_element import noise_of
from bullet_sim.formats.xml_read import child_number, child_text, child_whole, is_true

WIDE = "wideanglecamera"


def _camera_values(sensor):
    what = f"camera '{sensor.name}'"
    camera = sensor.element.find("camera")
    camera = sensor.element if camera is None else camera
    group = child_text(sensor.plugin, "cameraName", "")
    mean, stddev = noise_of(camera, "noise", what)
    near, far = lenses.clip(camera, what)
    return dict(
        name=sensor.name,
        link=sensor.link,
        pose=sensor.pose,
        width=child_whole(camera, "image/width", what, 320),
        height=child_whole(camera, "image/height", what, 240),
        horizontal_fov=lenses.field_of_view(camera, what, sensor.element.get("type") == WIDE),
        near=near,
        far=far,
        rate=sensor.drawn_rate(),
        topic=sensor.names.text_topic("imageTopicName", "image_raw", group),
        info_topic=sensor.names.text_topic("cameraInfoTopicName", "camera_info", group),
        frame_id=sensor.names.frame(child_text(sensor.plugin, "frameName", "/world")),
        noise_stddev=stddev,
        noise_mean=mean,
        encoding=lenses.encoding(camera, what, sensor.model),
        distortion=lenses.distortion(camera, sensor.plugin, what),
        baseline=child_number(sensor.plugin, "hackBaseline", what, 0.0),
    )


def camera(sensor):
    """CameraSpec of libgazebo_ros_camera.so."""
    return CameraSpec(**_camera_values(sensor))


def wide_angle_camera(sensor):
    """CameraSpec of libgazebo_ros_camera.so with a wide-angle lens."""
    found = sensor.element.find("camera")
    found = sensor.element if found is None else found
    lens = lenses.wide_lens(found, f"camera '{sensor.name}'", sensor.model)
    return CameraSpec(**dict(_camera_values(sensor), lens=lens, distortion=()))


def depth_camera(sensor, cutoff_max=float("inf")):
    """DepthCameraSpec of libgazebo_ros_depth_camera.so."""
    what = f"depth camera '{sensor.name}'"
    group = child_text(sensor.plugin, "cameraName", "")
    values = dict(_camera_values(sensor), noise_mean=0.0, noise_stddev=0.0)

    def topic(tag, default):
        return sensor.names.text_topic(tag, default, group)

    return DepthCameraSpec(
        **values,
        depth_topic=topic("depthImageTopicName", "depth/image_raw"),
        depth_info_topic=topic("depthImageCameraInfoTopicName", "depth/camera_info"),
        points_topic=topic("pointCloudTopicName", "points"),
        cutoff=child_number(sensor.plugin, "pointCloudCutoff", what, 0.4),
        cutoff_max=child_number(sensor.plugin, "pointCloudCutoffMax", what, cutoff_max),
        millimetres=is_true(child_text(sensor.plugin, "useDepth16UC1Format", "false")),
    )


def kinect(sensor):
    """DepthCameraSpec of libgazebo_ros_openni_kinect.so."""
    return depth_camera(sensor, cutoff_max=5.0)
