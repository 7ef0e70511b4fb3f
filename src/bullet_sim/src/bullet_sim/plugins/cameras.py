"""Cameras and depth cameras: their specifications and lenses, read from SDF and plugins."""

import math
from dataclasses import dataclass

from bullet_sim.plugins.xml import ZERO_POSE, PoseTuple, SensorElement, noise_of, plugin_label
from bullet_sim.pose import Pose
from bullet_sim.xml_reader import (
    child_flag,
    child_number,
    child_text,
    child_whole,
    is_true,
    sdf_pose,
    warn_replaced,
)

FUNCTIONS = ("tan", "sin", "id")
# Names of <type> -> (c1, c2, function).
TYPES = {
    "gnomonical": (1.0, 1.0, "tan"),
    "stereographic": (2.0, 2.0, "tan"),
    "equidistant": (1.0, 1.0, "id"),
    "equisolid_angle": (2.0, 2.0, "sin"),
    "orthographic": (1.0, 1.0, "sin"),
}


@dataclass(frozen=True)
class Lens:
    """r = c1 f function(theta / c2 + c3), with r = 1 at half the picture's width.

    Attributes:
        fov: horizontal angle of the picture [rad], up to a whole turn.
        function: 'tan', 'sin' or 'id'.
        scaled: f is chosen such that `fov` fills the width.
        cutoff: nothing is seen further from the axis [rad].
    """

    fov: float
    c1: float = 1.0
    c2: float = 1.0
    c3: float = 0.0
    f: float = 1.0
    function: str = "id"
    scaled: bool = True
    cutoff: float = math.pi


@dataclass(frozen=True)
class CameraSpec:
    """A colour camera that looks along +x of its sensor frame, z up.

    Attributes:
        name: sensor name.
        link: link that carries it.
        pose: (xyz [m], rpy [rad]) of the sensor frame in the link frame.
        width, height: picture size [px].
        horizontal_fov: [rad].
        near, far: clip distances [m].
        rate: pictures per simulated second [Hz].
        topic, info_topic: resolved topic names.
        frame_id: frame written into the headers.
        noise_stddev, noise_mean: of Gaussian noise on intensities in 0..1.
        encoding: of the messages: rgb8, bgr8 or mono8.
        baseline: of a stereo pair's right camera [m], as <hackBaseline> gives it.
        distortion: (k1, k2, p1, p2, k3) of its lens, as CameraInfo's plumb_bob; (): a pinhole.
        lens: of a wide-angle camera; horizontal_fov is then that of a pinhole, for camera_info.
    """

    name: str
    link: str
    pose: PoseTuple = ZERO_POSE
    width: int = 640
    height: int = 480
    horizontal_fov: float = 1.047
    near: float = 0.02
    far: float = 100.0
    rate: float = 30.0
    topic: str = "/camera/image_raw"
    info_topic: str = "/camera/camera_info"
    frame_id: str = "camera_link"
    noise_stddev: float = 0.0
    noise_mean: float = 0.0
    encoding: str = "rgb8"
    baseline: float = 0.0
    distortion: tuple[float, ...] = ()
    lens: Lens | None = None


@dataclass(frozen=True)
class DepthCameraSpec(CameraSpec):
    """A colour camera that also measures distances along its optical axis.

    Attributes:
        depth_topic, depth_info_topic, points_topic: resolved topic names.
        cutoff, cutoff_max: depths outside are unknown: NaN [m].
        millimetres: depth pictures are 16UC1 [mm] with 0 for unknown, instead of 32FC1 [m].
    """

    depth_topic: str = "/camera/depth/image_raw"
    depth_info_topic: str = "/camera/depth/camera_info"
    points_topic: str = "/camera/points"
    cutoff: float = 0.4
    cutoff_max: float = 5.0
    millimetres: bool = False


@dataclass(frozen=True)
class RangeCameraSpec(DepthCameraSpec):
    """The depth camera of a RealSense, without a colour picture: 16UC1 [mm], 0 for unknown.

    Attributes:
        range_min, range_max: depths outside are unknown in the picture [m].
        points_topic: of the point cloud; empty: none. The cutoffs are those of the points.
    """

    range_min: float = 0.0
    range_max: float = 65.535


WIDEST = math.radians(175.0)  # [rad] of a pinhole; at 180 degrees its picture has no end
FULL_TURN = 2.0 * math.pi
FIELD_OF_VIEW = 1.047  # [rad] where none is given
INVISIBLE = 1e-6  # of a coefficient of a lens
CLIP = (0.1, 100.0)  # [m] nearest and furthest that is drawn, where none is given
FURTHEST = 100.0  # [m] that a lidar sees whose file gives nothing usable
ENCODINGS = {
    "R8G8B8": "rgb8",
    "RGB8": "rgb8",
    "RGB_INT8": "rgb8",
    "B8G8R8": "bgr8",
    "BGR8": "bgr8",
    "BGR_INT8": "bgr8",
    "L8": "mono8",
    "MONO8": "mono8",
    "L_INT8": "mono8",
}


def encoding(camera, what, model):
    """Encoding of a camera's messages: rgb8, bgr8 or mono8."""
    form = child_text(camera, "image/format", "R8G8B8")
    found = ENCODINGS.get(form.upper())
    if found is None:
        model.warn(
            f"{what} has image format '{form}', known are {', '.join(ENCODINGS)}; "
            "it becomes R8G8B8",
            "cameras have an image format that is not known here and get R8G8B8",
            f"{what} '{form}'",
        )
    return found or "rgb8"


def field_of_view(camera, what, wide=False):
    """Horizontal angle of a camera [rad], below 180 degrees.

    Args:
        camera: the <camera>.
        what: for the message.
        wide: it has a wide-angle lens, for which a pinhole stands in: too wide is no mistake.
    """
    angle = child_number(camera, "horizontal_fov", what, FIELD_OF_VIEW)
    if 0.0 < angle <= WIDEST:
        return angle
    if wide and angle > 0.0:
        return WIDEST
    used = WIDEST if angle > 0.0 else FIELD_OF_VIEW
    sentence = (
        f"{what} <horizontal_fov> is {angle:g}, a pinhole's is above 0 and at most {WIDEST:.3f}"
    )
    warn_replaced(
        camera.find("horizontal_fov"), f"{what} <horizontal_fov>", f"{angle:g}", sentence, used
    )
    return used


def wide_lens(camera, what, model):
    """Lens of a wide-angle camera; where it names none, Gazebo's stereographic one."""
    fov = child_number(camera, "horizontal_fov", what, FIELD_OF_VIEW)
    fov = min(fov, FULL_TURN) if fov > 0.0 else FIELD_OF_VIEW
    kind = child_text(camera, "lens/type", "stereographic")
    scaled = child_flag(camera, "lens/scale_to_hfov", what, True)
    cutoff = child_number(camera, "lens/cutoff_angle", what, math.pi)
    if kind == "custom":
        c1, c2, c3, f = (
            child_number(camera, f"lens/custom_function/{name}", what, default)
            for name, default in (("c1", 1.0), ("c2", 1.0), ("c3", 0.0), ("f", 1.0))
        )
        function = child_text(camera, "lens/custom_function/fun", "tan")
    else:
        if kind not in TYPES:
            model.warn(
                f"{what} has a lens of type '{kind}', known are {', '.join(TYPES)}, custom; it "
                "becomes stereographic",
                "lenses have a type that is not known here and become stereographic",
                f"{what} '{kind}'",
            )
        c1, c2, function = TYPES.get(kind, TYPES["stereographic"])
        c3, f = 0.0, 1.0
    lens = Lens(fov, c1, c2, c3, f, function, scaled, cutoff)
    if function in FUNCTIONS and c1 * f > 0.0 and c2 > 0.0 and _fills(lens):
        return lens
    model.warn(
        f"{what} has a lens that shows nothing (c1 {c1:g}, c2 {c2:g}, c3 {c3:g}, f {f:g}, function "
        f"'{function}', {fov:g} rad); it becomes equidistant",
        "lenses show nothing and become equidistant",
        what,
    )
    return Lens(fov, cutoff=cutoff)


def _fills(lens):
    """Whether the angle of a lens has a place on its picture."""
    edge = lens.fov / 2.0 / lens.c2 + lens.c3
    limit = {"tan": math.pi / 2.0 - 1e-3, "sin": math.pi / 2.0 + 1e-9, "id": math.inf}
    return not lens.scaled or 0.0 < edge < limit[lens.function]


def distortion(camera, plugin, what):
    """(k1, k2, p1, p2, k3) of a lens, () of a pinhole.

    Those of the <camera> count, else those of its plugin; values too small to be seen are none.
    """
    names = ("k1", "k2", "p1", "p2", "k3")
    found = [child_number(camera, f"distortion/{name}", what, 0.0) for name in names]
    if camera.find("distortion") is None:
        names = ("K1", "K2", "T1", "T2", "K3")
        found = [child_number(plugin, f"distortion{name}", what, 0.0) for name in names]
    return tuple(found) if max(map(abs, found)) > INVISIBLE else ()


def clip(camera, what):
    """(nearest, furthest) distance that a camera draws [m]."""
    near = child_number(camera, "clip/near", what, CLIP[0])
    far = child_number(camera, "clip/far", what, CLIP[1])
    if 0.0 < near < far:
        return near, far
    used = (near if near > 0.0 else CLIP[0], CLIP[1])
    used = used if used[0] < used[1] else CLIP
    sentence = f"{what} <clip> is {near:g} to {far:g}, must be above 0, the smaller first"
    warn_replaced(camera.find("clip"), f"{what} <clip>", f"{near:g} {far:g}", sentence, used)
    return used


def sweep(ray, what):
    """(first, last) angle of a lidar [rad], the smaller first."""
    angles = tuple(
        child_number(ray, f"scan/horizontal/{end}_angle", what, 0.0) for end in ("min", "max")
    )
    if angles[0] <= angles[1]:
        return angles
    used = angles[::-1]
    sentence = f"{what} has angles {angles[0]:g} to {angles[1]:g}, the smaller must come first"
    shown = f"{angles[0]:g} {angles[1]:g}"
    warn_replaced(ray.find("scan/horizontal"), f"{what} angles", shown, sentence, used)
    return used


def reach(ray, what):
    """(nearest, furthest) range of a lidar [m]."""
    near = child_number(ray, "range/min", what, 0.0)
    far = child_number(ray, "range/max", what, FURTHEST)
    if 0.0 <= near < far:
        return near, far
    used = (max(0.0, near), far if far > max(0.0, near) else max(0.0, near) + FURTHEST)
    sentence = f"{what} <range> is {near:g} to {far:g}, must be 0 or more, the smaller first"
    warn_replaced(ray.find("range"), f"{what} <range>", f"{near:g} {far:g}", sentence, used)
    return used


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
    near, far = clip(camera, what)
    return dict(
        name=sensor.name,
        link=sensor.link,
        pose=_place(sensor, camera, what),
        width=child_whole(camera, "image/width", what, 320),
        height=child_whole(camera, "image/height", what, 240),
        horizontal_fov=field_of_view(camera, what, sensor.element.get("type") == WIDE),
        near=near,
        far=far,
        rate=sensor.drawn_rate(),
        topic=sensor.names.text_topic("imageTopicName", "image_raw", group),
        info_topic=sensor.names.text_topic("cameraInfoTopicName", "camera_info", group),
        frame_id=sensor.names.frame(child_text(sensor.plugin, "frameName", "/world")),
        noise_stddev=stddev,
        noise_mean=mean,
        encoding=encoding(camera, what, sensor.model),
        distortion=distortion(camera, sensor.plugin, what),
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
    lens = wide_lens(sensor.part("camera"), what, sensor.model)
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
    what, prefix = plugin_label(element), child_text(element, "prefix", "")
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
