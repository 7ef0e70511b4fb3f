"""Sensors and plugins with bad values: what is used, one warning each; and what is no mistake."""

import math

import pytest
from bullet_sim.formats.sdf.world import parse_model
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.plugins.cameras import MAX_FOV
from bullet_sim.sensors import camera
from bullet_sim.sensors.lidar import Lidar

pytestmark = pytest.mark.usefixtures("sketches")

PLUGINS = {
    "camera": "libgazebo_ros_camera.so",
    "wideanglecamera": "libgazebo_ros_camera.so",
    "ray": "libgazebo_ros_laser.so",
    "depth": "libgazebo_ros_openni_kinect.so",
    "imu": "libgazebo_ros_imu_sensor.so",
}


def sensor(inside, kind="camera", tags="", rate="<update_rate>20</update_rate>"):
    """The model of a robot with one sensor."""
    plugin = f'<plugin name="p" filename="{PLUGINS[kind]}">{tags}</plugin>'
    return parse_urdf(
        f'<robot name="r"><link name="head"/><gazebo reference="head"><sensor type="{kind}" '
        f'name="eye">{rate}{inside}{plugin}</sensor></gazebo></robot>',
        str,
        "car",
    )


def picture(tags):
    """A camera with an <image>."""
    return f"<camera><image>{tags}</image></camera>"


def fov(angle):
    """A camera of an angle."""
    return f"<camera><horizontal_fov>{angle}</horizontal_fov></camera>"


def clip(near, far):
    """A camera with a <clip>."""
    return f"<camera><clip><near>{near}</near><far>{far}</far></clip></camera>"


CAMERAS = {
    "RGB_INT8": (picture("<format>RGB_INT8</format>"), "encoding", "rgb8", ""),
    "RGB8": (picture("<format>RGB8</format>"), "encoding", "bgr8", "'RGB8'"),
    "small letters": (picture("<format>r8g8b8</format>"), "encoding", "bgr8", "'r8g8b8'"),
    "mono8": (picture("<format>mono8</format>"), "encoding", "bgr8", "'mono8'"),
    "16 bits": (picture("<format>L16</format>"), "encoding", "mono16", ""),
    "Bayer": (picture("<format>BAYER_GBRG8</format>"), "encoding", "bayer_gbrg8", ""),
    "an unknown format": (picture("<format>PAL</format>"), "encoding", "bgr8", "'PAL'"),
    "a width of a fraction": (picture("<width>64.5</width>"), "width", 64, ""),
    "no width": (picture("<width>0</width>"), "width", 320, "<image/width> is 0"),
    "a negative height": (picture("<height>-48</height>"), "height", 240, "must be at least 1"),
    "a height of a word": (picture("<height>low</height>"), "height", 240, "'low'"),
    "left by xacro": (picture("<height>${h}</height>"), "height", 240, "process the file"),
    "half a circle": (fov("3.14159"), "horizontal_fov", MAX_FOV, "at most 3.054"),
    "a negative angle": (fov("-1"), "horizontal_fov", 1.047, "is -1"),
    "an angle of a word": (fov("wide"), "horizontal_fov", 1.047, "'wide'"),
    "nearest 0": (clip(0, 50), "near", 0.1, "<clip>"),
    "furthest nearer": (clip(5, 2), "far", 100, "<clip>"),
    "endless sight": (clip(0.1, "inf"), "far", 100, "'inf'"),
    "a pose of five": ("<pose>1 2 3 0 0</pose>", "pose", ((1, 2, 3), (0, 0, 0)), "'1 2 3 0 0'"),
}


@pytest.mark.parametrize("inside, field, expected, words", CAMERAS.values(), ids=CAMERAS)
def test_cameras(inside, field, expected, words):
    model = sensor(inside)
    (spec,) = model.sensors
    assert getattr(spec, field) == expected
    assert len(model.warnings) == bool(words) and words in "".join(model.warnings)
    camera.check(spec.width, spec.height, spec.horizontal_fov, spec.near, spec.far)


@pytest.mark.parametrize("angle, used", [(3.6, MAX_FOV), (6.28, MAX_FOV), (1.5, 1.5)])
def test_a_wide_angle_camera_has_its_angle_and_a_pinholes_camera_info(angle, used):
    lens = "<lens><type>equidistant</type></lens>"
    model = sensor(fov(angle).replace("</camera>", f"{lens}</camera>"), "wideanglecamera")
    (spec,) = model.sensors
    assert spec.horizontal_fov == used < math.pi and spec.topic == "/image_raw"
    assert model.warnings == [] and spec.lens.fov == angle
    camera.check(spec.width, spec.height, spec.horizontal_fov, spec.near, spec.far)


def scan(tags="", near=0.1, far=8, low=-1, high=1):
    """A <ray>."""
    angles = f"<min_angle>{low}</min_angle><max_angle>{high}</max_angle>"
    reach = f"<range><min>{near}</min><max>{far}</max></range>"
    return f"<ray><scan><horizontal>{tags}{angles}</horizontal></scan>{reach}</ray>"


LIDARS = {
    "no samples": (scan("<samples>0</samples>"), "samples", 640, "samples> is 0"),
    "samples of a fraction": (scan("<samples>181.5</samples>"), "samples", 181, ""),
    "samples of a word": (scan("<samples>many</samples>"), "samples", 640, "'many'"),
    "angles the other way round": (scan(low=2, high=-2), "min_angle", 2, ""),
    "a bias": (
        scan().replace(
            "</ray>", "<noise><bias_mean>1</bias_mean><bias_stddev>-2</bias_stddev></noise></ray>"
        ),
        "bias",
        (1.0, 2.0),
        "",
    ),
    "a bias of noise that is none": (
        scan().replace("</ray>", "<noise><type>none</type><bias_mean>1</bias_mean></noise></ray>"),
        "bias",
        (0.0, 0.0),
        "",
    ),
    "a precision": (
        scan().replace("</ray>", "<noise><precision>0.1</precision></noise></ray>"),
        "precision",
        0.1,
        "",
    ),
    "a negative range": (scan(near=-1), "range_min", 0, "<range> is -1 to 8"),
    "no range": (scan(near=0, far=0), "range_max", 100, "<range> is 0 to 0"),
    "endless range": (scan(far="inf"), "range_max", 100, "'inf'"),
    "noise of a word": (
        scan().replace("</ray>", "<noise><stddev>some</stddev></noise></ray>"),
        "noise_stddev",
        0,
        "'some'",
    ),
}


@pytest.mark.parametrize("inside, field, expected, words", LIDARS.values(), ids=LIDARS)
def test_lidars(inside, field, expected, words):
    model = sensor(inside, "ray")
    (spec,) = model.sensors
    assert getattr(spec, field) == expected
    assert len(model.warnings) == bool(words) and words in "".join(model.warnings)
    assert len(Lidar(spec).directions) == spec.samples


FRAME, TOPIC = "<frameName>f</frameName>", "<topicName>t</topicName>"  # without which none


def test_other_numbers_of_sensors():
    model = sensor("", "imu", f"{FRAME}<gaussianNoise>x</gaussianNoise><rpyOffset>0 0</rpyOffset>")
    assert model.sensors[0].variance == 0 and len(model.warnings) == 2
    model = sensor("", rate="<update_rate>fast</update_rate>")
    assert model.sensors[0].rate == 30 and "'fast'" in model.warnings[0]


def plugin(name, tags):
    """Model of a base and a wheel on each side with a plugin."""
    wheels = "".join(
        f'<link name="{side}"/><joint name="{side}_joint" type="continuous"><parent link="base"/>'
        f'<child link="{side}"/></joint>'
        for side in ("left", "right")
    )
    text = f'<gazebo><plugin name="p" filename="lib{name}.so">{tags}</plugin></gazebo>'
    return parse_urdf(f'<robot name="r"><link name="base"/>{wheels}{text}</robot>', str, "car")


def test_plugins_with_bad_values():
    model = plugin("gazebo_ros_diff_drive", "<wheelSeparation>0.3m</wheelSeparation>")
    assert model.sensors[0].separation == 0.3 and "'0.3m'" in model.warnings[0]
    model = plugin("gazebo_ros_p3d", f"{TOPIC}<bodyName>base</bodyName><xyzOffset>1 2</xyzOffset>")
    assert model.sensors[0].offset[0] == (0, 0, 0) and "'1 2'" in model.warnings[0]
    model = plugin("gazebo_ros_control", "<controlPeriod>often</controlPeriod>")
    assert model.control_period == 0 and "'often'" in model.warnings[0]


@pytest.mark.parametrize("text", ["strong", "", " ", "nan", "inf", "-"])
def test_a_number_of_a_plugin_that_is_none_is_0_as_sdformat_reads_it(text):
    model = plugin("gazebo_ros_diff_drive", f"<wheelTorque>{text}</wheelTorque>")
    assert model.sensors[0].torque == 0 and len(model.warnings) == bool(text.strip())
    assert all(f"'{text}'" in words and "0 is used" in words for words in model.warnings)
    model = sensor("", "depth", f"<pointCloudCutoff>{text}</pointCloudCutoff>")
    assert {each.cutoff for each in model.sensors if hasattr(each, "cutoff")} == {0}


@pytest.mark.parametrize(
    "frame, reference, header",
    [("world", "", "world"), ("/map", "", "map"), ("left", "left", "left"), ("odom", None, "odom")],
)
def test_the_frame_of_a_ground_truth_is_the_world_or_a_link(frame, reference, header):
    tags = f"{TOPIC}<bodyName>base</bodyName><frameName>{frame}</frameName>"
    model = plugin("gazebo_ros_p3d", tags)
    [spec] = model.sensors
    assert (spec.reference, spec.frame_id) == (reference, header)
    if reference is None:
        [warning] = model.warnings
        assert "'odom'" in warning and "base" in warning and "publishes nothing" in warning
    else:
        assert not model.warnings


def test_the_frame_of_a_header_may_differ_from_that_of_the_pose():
    tags = f"{TOPIC}<bodyName>base</bodyName><headerFrame>/odom</headerFrame>"
    [spec] = plugin("gazebo_ros_p3d", tags).sensors
    assert (spec.reference, spec.frame_id) == ("", "odom")


QUIET = {
    "legacyModeNS": ("gazebo_ros_control", "<legacyModeNS>true</legacyModeNS>"),
    "an empty namespace in front": ("gazebo_ros_p3d", f"{TOPIC}<bodyName>/base</bodyName>"),
    "model and link": ("gazebo_ros_p3d", f"{TOPIC}<bodyName>car::base</bodyName>"),
    "topics from the root": (
        "gazebo_ros_p3d",
        "<bodyName>base</bodyName><topicName>//odom</topicName>"
        "<robotNamespace>/</robotNamespace><frameName>/map</frameName>",
    ),
}


@pytest.mark.parametrize("name, tags", QUIET.values(), ids=QUIET)
def test_what_is_right_is_quiet(name, tags):
    assert plugin(name, tags).warnings == []


READ_NO_SENSOR = (
    "gazebo_ros_control",
    "gazebo_ros_imu",
    "gazebo_ros_p3d",
    "gazebo_ros_planar_move",
    "hector_gazebo_ros_gps",
    "hector_gazebo_ros_imu",
    "hector_gazebo_ros_magnetic",
    "paddock_state_publisher",
)


@pytest.mark.parametrize(
    "libraries, said",
    [
        ((), True),
        *(((name,), True) for name in READ_NO_SENSOR),
        (READ_NO_SENSOR, True),
        (("realsense_gazebo_plugin",), False),
        (("mine",), False),
        (("gazebo_ros_p3d", "mine"), False),
    ],
)
def test_a_sensor_that_a_plugin_of_the_model_reads(libraries, said):
    plugins = "".join(f'<plugin name="p" filename="lib{name}.so"/>' for name in libraries)
    model, _ = parse_model(
        '<sdf version="1.6"><model name="m"><link name="a"><sensor name="s" type="imu"/></link>'
        f"{plugins}</model></sdf>",
        str,
    )
    assert any("no ROS plugin" in warning for warning in model.warnings) == said
