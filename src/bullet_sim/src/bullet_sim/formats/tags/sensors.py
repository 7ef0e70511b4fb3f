"""<sensor> elements of URDF and SDF with their gazebo_ros plugins -> specifications."""

from dataclasses import dataclass

from bullet_sim.description.specs import CameraSpec, ContactSpec, DepthCameraSpec, ImuSpec, RaySpec
from bullet_sim.formats.plugin_names import Names, library
from bullet_sim.formats.tags import rays
from bullet_sim.formats.xml_read import child_number, child_text, floats, is_true, sdf_pose, whole

DEFAULT_RATE = (
    30.0  # [Hz] of cameras and lidars without a rate, which Gazebo updates as fast as it can
)
_ENCODINGS = {
    "R8G8B8": "rgb8",
    "RGB_INT8": "rgb8",
    "B8G8R8": "bgr8",
    "BGR_INT8": "bgr8",
    "L8": "mono8",
    "L_INT8": "mono8",
}


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
                f"sensor '{self.name}' has no update rate; it runs at {DEFAULT_RATE:g} Hz"
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
            f"sensor '{name}' has type '{kind}', known are {', '.join(_READERS)}; it is left out"
        )
        return
    plugins = element.findall("plugin")
    if not plugins:
        model.warn(f"sensor '{name}' has no ROS plugin and so no topic; it is left out")
    pose = sdf_pose(element, f"sensor '{name}'")
    for plugin in plugins:
        reader = readers.get(library(plugin))
        if reader is None:
            model.warn(
                f"plugin '{plugin.get('filename')}' of sensor '{name}' is not known here "
                f"and is ignored; a sensor of type {kind} takes "
                f"{', '.join(f'lib{known}.so' for known in readers)}"
            )
            continue
        model.sensors.append(
            reader(
                _Sensor(
                    element,
                    plugin,
                    Names(plugin, model.name),
                    name,
                    link,
                    (pose.position, pose.rpy),
                    model,
                )
            )
        )


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
    form = child_text(camera, "image/format", "R8G8B8")
    if form not in _ENCODINGS:
        sensor.model.warn(
            f"{what} has image format '{form}', known are "
            f"{', '.join(_ENCODINGS)}; it becomes R8G8B8"
        )
    return dict(
        name=sensor.name,
        link=sensor.link,
        pose=sensor.pose,
        width=whole(child_number(camera, "image/width", what, 320), f"{what} width"),
        height=whole(child_number(camera, "image/height", what, 240), f"{what} height"),
        horizontal_fov=child_number(camera, "horizontal_fov", what, 1.047),
        near=child_number(camera, "clip/near", what, 0.1),
        far=child_number(camera, "clip/far", what, 100.0),
        rate=sensor.drawn_rate(),
        topic=sensor.names.text_topic("imageTopicName", "image_raw", group),
        info_topic=sensor.names.text_topic("cameraInfoTopicName", "camera_info", group),
        frame_id=sensor.names.frame(child_text(sensor.plugin, "frameName", "/world")),
        noise_stddev=stddev,
        noise_mean=mean,
        encoding=_ENCODINGS.get(form, "rgb8"),
        baseline=child_number(sensor.plugin, "hackBaseline", what, 0.0),
    )


def _camera(sensor):
    return CameraSpec(**_camera_values(sensor))


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
    return RaySpec(
        name=sensor.name,
        link=sensor.link,
        pose=sensor.pose,
        samples=whole(child_number(ray, "scan/horizontal/samples", what, 640), f"{what} samples"),
        min_angle=child_number(ray, "scan/horizontal/min_angle", what, 0.0),
        max_angle=child_number(ray, "scan/horizontal/max_angle", what, 0.0),
        range_min=child_number(ray, "range/min", what, 0.0),
        range_max=child_number(ray, "range/max", what, 0.0),
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
    turn = child_text(sensor.plugin, "rpyOffset")
    if turn is not None and any(floats(turn, 3, f"{what} rpyOffset")):
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
    "depth": _DEPTH | _CAMERAS,
    "depth_camera": _DEPTH | _CAMERAS,
    "ray": _LASERS,
    "gpu_ray": _LASERS,
    "imu": {"gazebo_ros_imu_sensor": _imu_sensor, "gazebo_ros_imu": _imu},
    "contact": {"gazebo_ros_bumper": _bumper},
}
