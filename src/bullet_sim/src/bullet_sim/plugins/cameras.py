"""Cameras: read from SDF and plugins, their images requested from a renderer."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, ClassVar
from xml.etree.ElementTree import Element

from bullet_sim.description.model import EVERYWHERE, VISIBLE, ModelDescription
from bullet_sim.parts.base import Sensor, part_of
from bullet_sim.parts.outputs import ImageOutput
from bullet_sim.parts.schedule import is_late_enough, passed_rate, whole_rate
from bullet_sim.plugins.registry import sensor_plugin
from bullet_sim.plugins.rules import UTILS_OF_SENSORS
from bullet_sim.plugins.spec import SensorSpec
from bullet_sim.plugins.xml import SensorXml, Values
from bullet_sim.pose import Array, Pose, PoseTuple
from bullet_sim.render.request import CameraRequest, Distortion, Frame, Intrinsics, Lens
from bullet_sim.sensors import camera as pinhole
from bullet_sim.xml_reader import is_true, sdf_pose, warn_replaced

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
class CameraSpec(SensorSpec):
    """A color camera that points along +x of its sensor frame, z up.

    Attributes:
        pose: (xyz [m], rpy [rad]) of the sensor frame in the link frame.
        width, height: image size [px].
        horizontal_fov: [rad].
        near, far: clip distances [m].
        rate: of the sensor, images per simulated second [Hz].
        topic, info_topic: resolved topic names.
        frame_id: frame written into the headers.
        noise_stddev, noise_mean: of Gaussian noise on intensities in 0..1.
        encoding: of the messages, one of those of ENCODINGS.
        baseline: of a stereo pair's right camera [m], as <hackBaseline> gives it.
        distortion: of its image; None: a pinhole.
        coefficients: (k1, k2, p1, p2, k3) of camera_info's plumb_bob; (): zeros.
        focal_length, center_x, center_y: of camera_info [px]; 0: see sensors.camera.
        bare_info: camera_info has no coefficients and a rectification of zeros.
        lens: of a wide-angle camera; horizontal_fov is then that of a pinhole, for camera_info.
        namespace: of its service set_camera_info; "": it has none.
        tunable: its rate can be changed by dynamic_reconfigure in that namespace.
        plugin_rate: images of the sensor are left out that come sooner after the last than this
            says [Hz]; 0: none.
        is_free: the sensor has no rate: the periods are those of the plugin.
        visibility: it sees what has one of these bits in its visibility_flags.
        samples: a pixel, for smooth edges.
        intrinsics: of the image, which replace horizontal_fov there; camera_info has none of them.
        depth: its requests are for depths, too.
        save: folder to which each image is written; "": none is.
        waits: after simulated time went back there is no image, of a Kinect no camera_info, until
            its time of before has passed again.
    """

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
    distortion: Distortion | None = None
    coefficients: tuple[float, ...] = ()
    focal_length: float = 0.0
    center_x: float = 0.0
    center_y: float = 0.0
    bare_info: bool = False
    lens: Lens | None = None
    namespace: str = ""
    tunable: bool = False
    plugin_rate: float = 0.0
    is_free: bool = False
    visibility: int = VISIBLE
    samples: int = 4
    intrinsics: Intrinsics | None = None
    save: str = ""
    waits: bool = False
    depth: ClassVar[bool] = False


@dataclass(frozen=True)
class TriggeredCameraSpec(CameraSpec):
    """A camera that takes one image for each message on its trigger's topics.

    Attributes:
        trigger_topics: of std_msgs/Empty; those of both cameras of a stereo pair.
    """

    trigger_topics: tuple[str, ...] = ()


MAX_FOV = math.radians(175.0)  # [rad] of a pinhole; at 180 degrees its image is infinite
FULL_TURN = 2.0 * math.pi
FIELD_OF_VIEW = 1.047  # [rad] where none is given
MIN_DISTORTION = 1e-6  # coefficients below are ignored
TEXTURES = (4, 2048)  # [px] smallest and largest Lens.texture
WIDE = "wideanglecamera"  # type of <sensor>
CLIP = (0.1, 100.0)  # [m] near and far clip distance where none is given
ENCODINGS = {
    "R8G8B8": "rgb8",
    "RGB_INT8": "rgb8",
    "B8G8R8": "bgr8",
    "BGR_INT8": "bgr8",
    "L8": "mono8",
    "L_INT8": "mono8",
    "L16": "mono16",
    "L_INT16": "mono16",
    "R16G16B16": "rgb16",
    "RGB_INT16": "rgb16",
    "BAYER_RGGB8": "bayer_rggb8",
    "BAYER_BGGR8": "bayer_bggr8",
    "BAYER_GBRG8": "bayer_gbrg8",
    "BAYER_GRBG8": "bayer_grbg8",
}


def encoding(camera: Values, model: ModelDescription) -> str:
    """Encoding of a camera's messages, as gazebo_ros_camera_utils chooses it: of others bgr8."""
    image_format = camera.text("image/format", "R8G8B8")
    known = ENCODINGS.get(image_format)
    if known is None:
        model.warn(
            f"{camera.label} has image format '{image_format}', known are {', '.join(ENCODINGS)}; "
            "its encoding becomes bgr8",
            "cameras have an image format that is not known and get the encoding bgr8",
            f"{camera.label} '{image_format}'",
        )
    return known or "bgr8"


def field_of_view(camera: Values, wide: bool = False) -> float:
    """Horizontal angle of a camera [rad], below 180 degrees.

    Args:
        wide: it has a wide-angle lens, replaced by a pinhole here: a wider angle is no error.
    """
    angle = camera.number("horizontal_fov", FIELD_OF_VIEW)
    if 0.0 < angle <= MAX_FOV:
        return angle
    if wide and angle > 0.0:
        return MAX_FOV
    used, label = MAX_FOV if angle > 0.0 else FIELD_OF_VIEW, f"{camera.label} <horizontal_fov>"
    message = f"{label} is {angle:g}, a pinhole's is above 0 and at most {MAX_FOV:.3f}"
    warn_replaced(camera.element.find("horizontal_fov"), label, f"{angle:g}", message, used)
    return used


def wide_lens(camera: Values, model: ModelDescription) -> Lens:
    """Lens of a wide-angle camera; where it names none, Gazebo's stereographic one."""
    fov = camera.number("horizontal_fov", FIELD_OF_VIEW)
    fov = min(fov, FULL_TURN) if fov > 0.0 else FIELD_OF_VIEW
    lens_type = camera.text("lens/type", "stereographic")
    scaled = camera.flag("lens/scale_to_hfov", True)
    cutoff = camera.number("lens/cutoff_angle", math.pi)
    texture = min(max(camera.whole("lens/env_texture_size", 256), TEXTURES[0]), TEXTURES[1])
    if lens_type == "custom":
        c1, c2, c3, f = (
            camera.number(f"lens/custom_function/{name}", default)
            for name, default in (("c1", 1.0), ("c2", 1.0), ("c3", 0.0), ("f", 1.0))
        )
        function = camera.text("lens/custom_function/fun", "tan")
    else:
        if lens_type not in TYPES:
            model.warn(
                f"{camera.label} has a lens of type '{lens_type}', known are {', '.join(TYPES)}, "
                "custom; it becomes stereographic",
                "lenses have a type that is not known here and become stereographic",
                f"{camera.label} '{lens_type}'",
            )
        c1, c2, function = TYPES.get(lens_type, TYPES["stereographic"])
        c3, f = 0.0, 1.0
    lens = Lens(fov, c1, c2, c3, f, function, scaled, cutoff, texture)
    if function in FUNCTIONS and c1 * f > 0.0 and c2 > 0.0 and _fills(lens):
        return lens
    model.warn(
        f"{camera.label} has a lens that shows nothing (c1 {c1:g}, c2 {c2:g}, c3 {c3:g}, f {f:g}, "
        f"function '{function}', {fov:g} rad); it becomes equidistant",
        "lenses show nothing and become equidistant",
        camera.label,
    )
    return Lens(fov, cutoff=cutoff, texture=texture)


def intrinsics(camera: Values) -> Intrinsics | None:
    """<intrinsics> of a camera's <lens>; None: it has none, or its focal lengths make no image."""
    element = camera.element.find("lens/intrinsics")
    if element is None:
        return None
    values = {
        name: camera.number(f"lens/intrinsics/{name}", default)
        for name, default in vars(Intrinsics()).items()
    }
    if values["fx"] > 0.0 and values["fy"] > 0.0:
        return Intrinsics(**values)
    label, text = f"{camera.label} <intrinsics>", f"{values['fx']:g} {values['fy']:g}"
    warn_replaced(element, label, text, f"{label} fx, fy are {text}, must be above 0", "no effect")
    return None


def _fills(lens: Lens) -> bool:
    """Whether the field of view of a lens fits on its image."""
    edge = lens.fov / 2.0 / lens.c2 + lens.c3
    limit = {"tan": math.pi / 2.0 - 1e-3, "sin": math.pi / 2.0 + 1e-9, "id": math.inf}
    return not lens.scaled or 0.0 < edge < limit[lens.function]


def distortion(camera: Values, plugin: Values) -> Distortion | None:
    """Distortion of a camera's image; None: a pinhole.

    As in Gazebo, the coefficients of the plugin do not count, and only barrels (k1 below 0) are
    cropped, unless the plugin's borderCrop is false.
    """
    element = camera.element.find("distortion")
    if element is None:
        return None
    values = {name: camera.number(f"distortion/{name}") for name in ("k1", "k2", "k3", "p1", "p2")}
    if max(abs(value) for value in values.values()) <= MIN_DISTORTION:
        return None
    x, y = camera.vector("distortion/center", 2, (0.5, 0.5))
    mode = next((child for child in element if child.tag == "ignition:legacy_mode"), None)
    legacy = mode is None or is_true(mode.text)
    crop = legacy and values["k1"] < 0.0 and plugin.flag("borderCrop", True)
    return Distortion(**values, center=(x, y), crop=crop, legacy=legacy)


def coefficients(camera: Values, plugin: Values) -> tuple[float, ...]:
    """(k1, k2, p1, p2, k3) of camera_info: the plugin's, or the camera's with autoDistortion."""
    values = [plugin.number(f"distortion{name}") for name in ("K1", "K2", "T1", "T2", "K3")]
    if plugin.flag("autoDistortion"):
        values = [camera.number(f"distortion/{name}") for name in ("k1", "k2", "p1", "p2", "k3")]
    return tuple(values) if any(values) else ()


def clip(camera: Values) -> tuple[float, float]:
    """(near, far) clip distance of a camera [m]."""
    near, far = camera.number("clip/near", CLIP[0]), camera.number("clip/far", CLIP[1])
    if 0.0 < near < far:
        return near, far
    used, label = (near if near > 0.0 else CLIP[0], CLIP[1]), f"{camera.label} <clip>"
    used = used if used[0] < used[1] else CLIP
    message = f"{label} is {near:g} to {far:g}, must be above 0, the smaller first"
    warn_replaced(camera.element.find("clip"), label, f"{near:g} {far:g}", message, used)
    return used


def save_folder(camera: Values) -> str:
    """<path> of a camera whose images are to be saved; "": they are not."""
    element = camera.element.find("save")
    if element is None or not is_true(element.get("enabled", "false")):
        return ""
    return camera.text("save/path", "__default__") or "."


def camera_values(
    xml: SensorXml, element: Element | None = None, side: str = "", triggered: bool = False
) -> dict[str, Any]:
    """Values of a CameraSpec.

    Args:
        element: its <camera>; None: the only one.
        side: appended to the topics' namespace.
        triggered: it has no rate of its own.
    """
    plugin = xml.plugin("camera")
    camera = Values(element, plugin.label) if element is not None else xml.part("camera", "camera")
    group = xml.text("cameraName") + side
    mean, stddev = camera.noise("noise")
    near, far = clip(camera)
    rate = xml.rate(None)
    return dict(
        name=xml.name,
        link=xml.parent,
        pose=_pose_in_link(xml, camera),
        width=camera.whole("image/width", 320),
        height=camera.whole("image/height", 240),
        horizontal_fov=field_of_view(camera, xml.type == WIDE),
        near=near,
        visibility=int(camera.number("visibility_mask", EVERYWHERE)) & VISIBLE,
        samples=int(camera.number("image/anti_aliasing", 4.0)),
        intrinsics=intrinsics(camera) if xml.type != WIDE else None,
        save=save_folder(camera),
        far=far,
        rate=0.0 if triggered else rate or xml.output_rate(),
        plugin_rate=0.0 if triggered else max(0.0, plugin.number("updateRate")),
        is_free=not rate,
        namespace=xml.names.topic("", group),
        tunable=bool(group.strip("/")),
        topic=xml.topic("imageTopicName", "image_raw", group),
        info_topic=xml.topic("cameraInfoTopicName", "camera_info", group),
        frame_id=xml.frame("frameName", "", group),  # camera_utils has no default
        noise_stddev=stddev,
        noise_mean=mean,
        encoding=encoding(camera, xml.model),
        distortion=distortion(camera, plugin),
        coefficients=coefficients(camera, plugin),
        focal_length=max(0.0, plugin.number("focalLength")),
        center_x=plugin.number("Cx"),
        center_y=plugin.number("Cy"),
        baseline=plugin.number("hackBaseline"),
    )


def _pose_in_link(xml: SensorXml, camera: Values) -> PoseTuple:
    """Pose of a <camera> in its link: that of its <sensor> times its <pose>."""
    if camera.element is xml.sensor or camera.element.find("pose") is None:
        return xml.pose
    pose = Pose.from_xyz_rpy(*xml.pose) * sdf_pose(camera.element, camera.label)
    return pose.position, pose.rpy


@sensor_plugin(
    "gazebo_ros_camera", types=("camera", "depth", "depth_camera", WIDE), rule=UTILS_OF_SENSORS
)
def color_camera(xml: SensorXml) -> CameraSpec:
    """CameraSpec; of a wide-angle camera with its lens."""
    if xml.type != WIDE:
        return CameraSpec(**camera_values(xml))
    lens = wide_lens(xml.part("camera", "camera"), xml.model)
    return CameraSpec(**dict(camera_values(xml), lens=lens, distortion=None))


@sensor_plugin("gazebo_ros_prosilica", types=("camera",))
def prosilica(xml: SensorXml) -> None:
    """Nothing: upstream its streaming mode publishes nothing either, since a function of Gazebo 1
    has the images, and its polled mode answers requests of the package polled_camera."""
    xml.warn(
        f"{xml.label} of sensor '{xml.name}' publishes no images, as in Gazebo, where it answers "
        "requests of polled_camera alone",
        "plugins of a Prosilica camera publish no images",
        f"'{xml.name}'",
    )


def _pair(xml: SensorXml, triggered: bool = False) -> dict[str, dict[str, Any]]:
    """Values of the CameraSpecs of a left and a right camera, distinguished by their names."""
    pair = {}
    for camera in xml.sensor.findall("camera"):
        name = camera.get("name", "")
        side = next((side for side in ("left", "right") if side in name), None)
        if side is None:
            xml.warn(
                f"sensor '{xml.name}': camera '{name}' is left out; its name must contain 'left' "
                "or 'right'"
            )
            continue
        values = camera_values(xml, camera, f"/{side}", triggered)
        values["name"] = f"{xml.name}/{name}"
        if side == "left":
            values["baseline"] = 0.0
        pair[side] = values
    return pair


@sensor_plugin("gazebo_ros_multicamera", types=("multicamera",), rule=UTILS_OF_SENSORS)
def multicamera(xml: SensorXml) -> list[CameraSpec]:
    """CameraSpecs; where the right camera comes first, each has the other's images, as upstream."""
    pair = _pair(xml)
    if list(pair) == ["right", "left"]:
        left, right = pair["left"]["pose"], pair["right"]["pose"]
        pair["left"]["pose"], pair["right"]["pose"] = right, left
    return [CameraSpec(**values, waits=True) for values in pair.values()]


@sensor_plugin("gazebo_ros_triggered_camera", types=("camera",), rule=UTILS_OF_SENSORS)
def triggered_camera(xml: SensorXml) -> CameraSpec:
    topic = xml.topic("triggerTopicName", "image_trigger", xml.text("cameraName"))
    return TriggeredCameraSpec(**camera_values(xml, triggered=True), trigger_topics=(topic,))


@sensor_plugin("gazebo_ros_triggered_multicamera", types=("multicamera",), rule=UTILS_OF_SENSORS)
def triggered_multicamera(xml: SensorXml) -> list[CameraSpec]:
    """TriggeredCameraSpecs; either trigger has both images taken, as upstream."""
    pair, name = _pair(xml, triggered=True), xml.text("cameraName")
    topics = tuple(
        xml.topic("triggerTopicName", "image_trigger", f"{name}/{side}") for side in pair
    )
    return [TriggeredCameraSpec(**values, trigger_topics=topics) for values in pair.values()]


NEVER_TAKEN = -math.inf  # [s]


@part_of(CameraSpec)
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
        pinhole.check(spec.width, spec.height, spec.horizontal_fov, spec.near, spec.far)
        self._is_free = spec.is_free
        self._taken = NEVER_TAKEN
        super().__init__(context)
        part, offset = model.link_in_body(spec.link)
        pose = offset * Pose.from_xyz_rpy(*spec.pose)
        request = CameraRequest.from_spec(spec, model.source.key, model.row(part), context.seed)
        name = f"{model.name}/{spec.link}/{spec.name}/{context.number}"
        self._request = replace(request, pose=(pose.position, pose.rpy), name=name)
        context.cameras.add(self)

    def make_output(self) -> ImageOutput:
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

    def go_back(self, time: float) -> None:
        """As restart(); one that waits keeps the time of its last image."""
        taken = self._taken
        super().go_back(time)
        if self.spec.waits:
            self._taken = taken

    def _passes(self, time: float) -> bool:
        """Whether the plugin's period has passed since the last time that it had."""
        limit, since = self.spec.plugin_rate, time - self._taken
        if since < 0.0 or (limit > 0.0 and not is_late_enough(since, limit)):
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
        self.send_pixels(frame.time, pinhole.pixels(frame.rgb, self.spec.encoding))

    def publish_info(self, time: float) -> None:
        """Tell what the camera is like, before an image of a simulated time [s]."""

    def send_pixels(self, time: float, pixels: Array) -> None:
        """Send an image's pixels in the encoding of the specification."""
        self._sender.send(time, pixels)

    def close(self) -> None:
        """Nothing is rendered any more."""
        self.context.cameras.remove(self)
        super().close()


@part_of(TriggeredCameraSpec)
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
