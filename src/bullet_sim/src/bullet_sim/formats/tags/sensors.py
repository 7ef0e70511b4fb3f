"""<sensor> elements of URDF and SDF with their gazebo_ros plugins -> specifications."""

import math
from dataclasses import dataclass

from bullet_sim.description.specs import CameraSpec, ContactSpec, DepthCameraSpec, ImuSpec, RaySpec
from bullet_sim.errors import ModelError
from bullet_sim.formats.plugin_names import Names, library
from bullet_sim.formats.tags import lenses, rays
from bullet_sim.formats.xml_read import (
    child_floats,
    child_number,
    child_text,
    child_whole,
    is_true,
    sdf_pose,
)

# Model plugins that read no <sensor>: with these alone, a sensor without a plugin has no topic.
_READ_NO_SENSOR = {
    "gazebo_ros_control",
    "gazebo_ros_diff_drive",
    "gazebo_ros_joint_state_publisher",
    "gazebo_ros_p3d",
    "gazebo_ros_skid_steer_drive",
}
WIDE = "wideanglecamera"
DEFAULT_RATE = 30.0  # [Hz] of cameras and lidars that name none: Gazebo goes as fast as it can


@dataclass(frozen=True)
class _Sensor:
    """Input of all readers: the elements, names and the pose."""

    element: object
    plugin: object
    names: Names
    name: str
    link: str
    pose: tuple
    model: object

    def rate(self, tag="updateRate", default=0.0):
        """The lower of the sensor's and the plugin's rate [Hz]; 0: neither gives one."""
        what = f"sensor '{self.name}'"
        rates = [
            child_number(self.element, "update_rate", what, 0.0),
            child_number(self.plugin, tag, what, default),
        ]
        return min((rate for rate in rates if rate > 0), default=0.0)

    def drawn_rate(self, tag="updateRate"):
        """As rate, for cameras and lidars: DEFAULT_RATE where none is given."""
        rate = self.rate(tag)
        if not rate:
            self.model.warn(
                f"sensor '{self.name}' has no update rate; it runs at {DEFAULT_RATE:g} Hz",
                f"sensors have no update rate and run at {DEFAULT_RATE:g} Hz",
                f"'{self.name}'",
            )
        return rate or DEFAULT_RATE


def parse_sensor(element, link, model):
    """Specifications of one <sensor>, which go into the model's list.

    Args:
        element: the <sensor>.
        link: name of the link that carries it.
        model: ModelDescription; gets warnings, too.
    """
    kind, name = element.get("type"), element.get("name") or "sensor"
    readers = _READERS.get(kind)
    if readers is None:
        model.warn(
            f"sensor '{name}' has type '{kind}', known are {', '.join(_READERS)}; it is left out",
            "sensors have a type that is not known here and are left out",
            f"'{name}' ({kind})",
        )
        return
    plugins = element.findall("plugin")
    if not plugins and not _is_for_a_plugin(element):
        model.warn(
            f"sensor '{name}' has no ROS plugin and so no topic; it is left out",
            "sensors have no ROS plugin and so no topic and are left out",
            f"'{name}'",
        )
    pose = sdf_pose(element, f"sensor '{name}'")
    for plugin in plugins:
        reader = readers.get(library(plugin))
        if reader is None:
            model.warn(
                f"plugin '{plugin.get('filename')}' of sensor '{name}' is not known here "
                f"and is ignored; a sensor of type {kind} takes "
                f"{', '.join(f'lib{known}.so' for known in readers)}",
                "plugins of sensors are not known here and are ignored",
                f"'{plugin.get('filename')}'",
            )
            continue
        place = (pose.position, pose.rpy)
        sensor = _Sensor(element, plugin, Names(plugin, model.name), name, link, place, model)
        try:
            model.sensors.append(reader(sensor))
        except ModelError as error:
            model.warn(f"{error}; sensor '{name}' is left out", "sensors are left out", f"'{name}'")


def _is_for_a_plugin(sensor):
    """Whether a sensor without a plugin may be one that a plugin of its model reads."""
    holders = [node for node in sensor.document.root.iter() if node.tag in ("model", "gazebo")]
    plugins = {library(plugin) for holder in holders for plugin in holder.findall("plugin")}
    return bool(plugins - _READ_NO_SENSOR)


def _noise(element, path, what):
    """(mean, standard deviation) of a Gaussian <noise>; zeros where there is none."""
    noise = element.find(path)
    if noise is None:
        return 0.0, 0.0
    return (child_number(noise, "mean", what, 0.0), abs(child_number(noise, "stddev", what, 0.0)))


def _camera_values(sensor):
    what = f"camera '{sensor.name}'"
    camera = sensor.element.find("camera")
    camera = sensor.element if camera is None else camera
    group = child_text(sensor.plugin, "cameraName", "")
    mean, stddev = _noise(camera, "noise", what)
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
        baseline=child_number(sensor.plugin, "hackBaseline", what, 0.0),
    )


def _camera(sensor):
    return CameraSpec(**_camera_values(sensor))


def _wide_angle_camera(sensor):
    """A pinhole of the same angle, as far as a pinhole goes; lenses are not modelled."""
    sensor.model.warn(
        f"camera '{sensor.name}' has a wide-angle lens, which is not modelled here; a pinhole of "
        f"its angle, at most {math.degrees(lenses.WIDEST):g} degrees, takes its place",
        "cameras have a wide-angle lens, which is not modelled here, and become pinholes",
        f"'{sensor.name}'",
    )
    return _camera(sensor)


def _depth_camera(sensor, cutoff_max=float("inf")):
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


def _kinect(sensor):
    return _depth_camera(sensor, cutoff_max=5.0)


def _ray(sensor):
    what = f"lidar '{sensor.name}'"
    ray = sensor.element.find("ray")
    ray = sensor.element if ray is None else ray
    if child_number(ray, "scan/vertical/samples", what, 1) > 1:
        sensor.model.warn(f"{what} has several layers (<vertical>); only the level one is scanned")
    mean, stddev = _noise(ray, "noise", what)
    first, last = lenses.sweep(ray, what)
    near, far = lenses.reach(ray, what)
    return RaySpec(
        name=sensor.name,
        link=sensor.link,
        pose=sensor.pose,
        samples=child_whole(ray, "scan/horizontal/samples", what, 640),
        min_angle=first,
        max_angle=last,
        range_min=near,
        range_max=far,
        rate=sensor.drawn_rate(tag="-"),  # the laser plugins ignore <updateRate>
        noise_stddev=stddev or child_number(sensor.plugin, "gaussianNoise", what, 0.0),
        noise_mean=mean,
        topic=sensor.names.text_topic("topicName", "/world"),
        frame_id=sensor.names.frame(child_text(sensor.plugin, "frameName", "/world")),
        visualize=is_true(child_text(sensor.element, "visualize", "false")),
    )


def imu_spec(names, plugin, name, link, pose, **values):
    """ImuSpec of a plugin with <gaussianNoise>; values: what differs between plugins."""
    noise = abs(child_number(plugin, "gaussianNoise", f"imu '{name}'", 0.0))
    values.setdefault("gyro_noise_stddev", noise)
    values.setdefault("accel_noise_stddev", noise)
    return ImuSpec(name=name, link=link, pose=pose, variance=noise**2, **values)


def _imu(sensor):
    """libgazebo_ros_imu.so in a <sensor>: it belongs into <gazebo>, but is often found here."""
    frame = child_text(sensor.plugin, "frameName") or child_text(
        sensor.plugin, "bodyName", sensor.link
    )
    return imu_spec(
        sensor.names,
        sensor.plugin,
        sensor.name,
        sensor.link,
        sensor.pose,
        rate=sensor.rate(),
        frame_id=sensor.names.frame(frame, prefixed=False),
        topic=sensor.names.text_topic("topicName", "/default_imu"),
    )


def _imu_sensor(sensor):
    what = f"imu '{sensor.name}'"
    names = sensor.names
    if sensor.plugin.find("robotNamespace") is None and not names.namespace:
        names = Names(sensor.plugin, sensor.model.name, sensor.model.name)
    mean, stddev = {}, {}
    plugin_noise = abs(child_number(sensor.plugin, "gaussianNoise", what, 0.0))
    for key, paths in (
        ("gyro", ("imu/angular_velocity/x/noise", "imu/noise/rate")),
        ("accel", ("imu/linear_acceleration/x/noise", "imu/noise/accel")),
    ):
        values = [_noise(sensor.element, path, what) for path in paths]
        mean[key] = sum(value[0] for value in values)
        stddev[key] = (plugin_noise**2 + sum(value[1] ** 2 for value in values)) ** 0.5
    turn = child_floats(sensor.plugin, "rpyOffset", 3, what, (0.0, 0.0, 0.0))
    if any(turn):
        sensor.model.warn(
            f"{what} has <rpyOffset> {turn}, which is ignored: give the sensor a <pose>"
        )
    if is_true(child_text(sensor.plugin, "initialOrientationAsReference", "false")):
        sensor.model.warn(
            f"{what} wants <initialOrientationAsReference>; its orientation is "
            "in the world all the same (REP 145)"
        )
    return imu_spec(
        names,
        sensor.plugin,
        sensor.name,
        sensor.link,
        sensor.pose,
        rate=sensor.rate("updateRateHZ", 1.0),
        frame_id=names.frame(child_text(sensor.plugin, "frameName", sensor.link), False),
        topic=names.topic(child_text(sensor.plugin, "topicName", "imu_data"), absolute=False),
        gyro_noise_mean=mean["gyro"],
        accel_noise_mean=mean["accel"],
        gyro_noise_stddev=stddev["gyro"],
        accel_noise_stddev=stddev["accel"],
    )


def _bumper(sensor):
    collisions = tuple(
        found.text.strip()
        for found in sensor.element.findall("contact/collision")
        if found.text and found.text.strip()
    )
    return ContactSpec(
        name=sensor.name,
        link=sensor.link,
        collisions=collisions,
        rate=sensor.rate(tag="-"),
        topic=sensor.names.text_topic("bumperTopicName", "bumper_states"),
        frame_id=sensor.names.frame(child_text(sensor.plugin, "frameName", "world"), False),
    )


_CAMERAS = {"gazebo_ros_camera": _camera}
_DEPTH = {"gazebo_ros_depth_camera": _depth_camera, "gazebo_ros_openni_kinect": _kinect}
_LASERS = {
    "gazebo_ros_laser": _ray,
    "gazebo_ros_gpu_laser": _ray,
    "gazebo_ros_velodyne_laser": rays.velodyne,
    "gazebo_ros_velodyne_gpu_laser": rays.velodyne,
    "gazebo_ros_block_laser": rays.block_laser,
    "gazebo_ros_range": rays.range_sensor,
    "hector_gazebo_ros_sonar": rays.sonar,
}
_READERS = {
    "camera": _CAMERAS | _DEPTH,
    WIDE: {"gazebo_ros_camera": _wide_angle_camera},
    "depth": _DEPTH | _CAMERAS,
    "depth_camera": _DEPTH | _CAMERAS,
    "ray": _LASERS,
    "gpu_ray": _LASERS,
    "imu": {"gazebo_ros_imu_sensor": _imu_sensor, "gazebo_ros_imu": _imu},
    "contact": {"gazebo_ros_bumper": _bumper},
}
