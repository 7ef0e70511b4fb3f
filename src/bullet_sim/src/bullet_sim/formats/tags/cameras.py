"""<sensor>s with pictures, and their plugins -> specifications."""

from bullet_sim.description.specs import CameraSpec, DepthCameraSpec, RangeCameraSpec
from bullet_sim.formats.tags import lenses
from bullet_sim.formats.tags.sensor_element import SensorElement, noise_of
from bullet_sim.formats.xml_read import child_number, child_text, child_whole, is_true, sdf_pose
from bullet_sim.pose import Pose

WIDE = "wideanglecamera"


def _camera_values(sensor, camera=None, side=""):
    """Values of a CameraSpec.

    Args:
        sensor: SensorElement.
        camera: its <camera>; None: the only one.
        side: appended to the topics' namespace.
    """
    what = f"camera '{sensor.name}'"
    camera = sensor.part("camera") if camera is None else camera
    group = child_text(sensor.plugin, "cameraName", "") + side
    mean, stddev = noise_of(camera, "noise", what)
    near, far = lenses.clip(camera, what)
    return dict(
        name=sensor.name,
        link=sensor.link,
        pose=_place(sensor, camera, what),
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


def _place(sensor, camera, what):
    """Pose of a <camera> in its link: that of its <sensor>, and within that its own."""
    if camera is sensor.element or camera.find("pose") is None:
        return sensor.pose
    pose = Pose.from_xyz_rpy(*sensor.pose) * sdf_pose(camera, what)
    return pose.position, pose.rpy


def camera(sensor):
    """CameraSpec of libgazebo_ros_camera.so."""
    return CameraSpec(**_camera_values(sensor))


def multicamera(sensor):
    """CameraSpecs of libgazebo_ros_multicamera.so: a left and a right one, told by their names."""
    found = []
    for camera in sensor.element.findall("camera"):
        name = camera.get("name", "")
        side = next((side for side in ("left", "right") if side in name), None)
        if side is None:
            sensor.model.warn(
                f"sensor '{sensor.name}': camera '{name}' is left out; its name must hold 'left' "
                "or 'right'"
            )
            continue
        values = dict(_camera_values(sensor, camera, f"/{side}"), name=f"{sensor.name}/{name}")
        if side == "left":
            values["baseline"] = 0.0
        found.append(CameraSpec(**values))
    return found


def wide_angle_camera(sensor):
    """CameraSpec of libgazebo_ros_camera.so with a wide-angle lens."""
    what = f"camera '{sensor.name}'"
    lens = lenses.wide_lens(sensor.part("camera"), what, sensor.model)
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


# RealSense ----------------------------------------------------------------------------------------
_STREAMS = {  # sensor's name -> the start of its tags, and the default topic
    "color": ("color", "color/image_raw"),
    "ired1": ("infrared1", "infra1/image_raw"),
    "ired2": ("infrared2", "infra2/image_raw"),
    "depth": ("depth", "depth/image_raw"),
}


def realsense(element, model, names):
    """librealsense_gazebo_plugin.so: the four cameras of a model, found by their names.

    Topics are below the plugin's own name; camera_info is beside each picture.
    """
    what, prefix = f"plugin '{element.get('filename')}'", child_text(element, "prefix", "")
    found = _sensors_by_name(element, model)
    for stream, (tag, default) in _STREAMS.items():
        if prefix + stream not in found:
            model.warn(
                f"{what} needs a camera sensor '{prefix + stream}', which the model has not; it is "
                "left out"
            )
            continue
        camera_element, link = found[prefix + stream]
        pose = sdf_pose(camera_element, f"sensor '{prefix + stream}'")
        place = (pose.position, pose.rpy)
        sensor = SensorElement(camera_element, element, names, prefix + stream, link, place, model)
        handle = element.get("name") or "realsense"
        topic = names.topic(f"/{handle}/{child_text(element, f'{tag}TopicName', default)}")
        values = dict(
            _camera_values(sensor),
            topic=topic,
            info_topic=topic.rsplit("/", 1)[0] + "/camera_info",
            frame_id=child_text(element, f"{tag}OpticalframeName", link).lstrip("/"),
        )
        if values["encoding"] == "mono8":
            values["encoding"] = "8UC1"  # as the plugin names it
        if stream != "depth":
            model.sensors.append(CameraSpec(**values))
            continue
        cloud = is_true(child_text(element, "pointCloud", "false"))
        points = child_text(element, "pointCloudTopicName", "depth/color/points")
        values.update(noise_mean=0.0, noise_stddev=0.0)
        model.sensors.append(
            RangeCameraSpec(
                **values,
                depth_topic=topic,
                depth_info_topic=values["info_topic"],
                millimetres=True,
                range_min=child_number(element, "rangeMinDepth", what, 0.0),
                range_max=child_number(element, "rangeMaxDepth", what, 65.535),
                points_topic=names.topic(f"/{handle}/{points}") if cloud else "",
                cutoff=child_number(element, "pointCloudCutoff", what, 0.0),
                cutoff_max=child_number(element, "pointCloudCutoffMax", what, 5.0),
            )
        )


def _sensors_by_name(element, model):
    """Name -> (<sensor>, link) of the sensors in a plugin's document."""
    found = {}
    for holder in element.document.root.iter():
        link = holder.get("reference") if holder.tag == "gazebo" else holder.get("name")
        if holder.tag in ("gazebo", "link") and link in model.links:
            for sensor in holder.findall("sensor"):
                found.setdefault(sensor.get("name"), (sensor, link))
    return found
