"""Plugins of users' own packages, found by a source of the registries, and what they read."""

import math

import pytest
from bullet_sim.errors import ModelError
from bullet_sim.formats.sdf.world import parse_model
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.plugins import PLUGINS, SENSOR_PLUGINS
from bullet_sim.plugins.custom import CustomSpec, custom_plugin, custom_sensor
from bullet_sim.pose import ZERO_POSE
from bullet_sim.registry import Registry

pytestmark = pytest.mark.usefixtures("sketches")

LINKS = (
    '<link name="base"/><link name="arm"/><joint name="elbow" type="continuous">'
    '<parent link="base"/><child link="arm"/></joint>'
)


@pytest.fixture(name="sources")
def _sources():
    """Dictionaries with readers of libraries: of models, and of sensors."""
    readers, removers = ({}, {}), []
    for registry, entries in zip((PLUGINS, SENSOR_PLUGINS), readers):
        removers.append(registry.add_source(entries.get, lambda entries=entries: tuple(entries)))
    yield readers
    for remove in removers:
        remove()


def read(text):
    """ModelDescription of a two-link robot."""
    return parse_urdf(f'<robot name="r">{LINKS}{text}</robot>', str, "car")


def gas(tags="", inside="", kind="gas", library="libgas.so"):
    """A sensor with a plugin."""
    return (
        f'<gazebo reference="arm"><sensor type="{kind}" name="nose"><pose>1 0 0 0 0 0</pose>'
        f'{inside}<plugin name="sniffer" filename="{library}">{tags}</plugin></sensor></gazebo>'
    )


def conveyor(tags="", name=' name="belt"'):
    """A plugin of the model."""
    return f'<gazebo><plugin{name} filename="/opt/libconveyor.so">{tags}</plugin></gazebo>'


def test_a_source_can_be_removed():
    registry = Registry("thing")
    remove = registry.add_source({"a": 1}.get, lambda: ("a",))
    assert registry.find("a") == 1 and registry.names() == ("a",)
    remove()
    with pytest.raises(KeyError):
        registry.find("a")
    assert registry.names() == ()


def test_without_a_source_they_are_not_known():
    model = read(conveyor() + gas())
    assert model.sensors == []
    assert model.warnings == [
        "plugin '/opt/libconveyor.so' is not known here and is ignored",
        "sensor 'nose' has type 'gas', known are camera, depth, depth_camera, wideanglecamera, "
        "multicamera, contact, imu, ray, gpu_ray; it is left out",
    ]


@pytest.mark.parametrize("library, meant", [
    ("libgazebo_ros_diff_drve.so", "libgazebo_ros_diff_drive.so"),
    ("gazebo_ros_contol", "libgazebo_ros_control.so"),
    ("/opt/libgazebo_ros_planarmove.so", "libgazebo_ros_planar_move.so"),
    ("hector_gazebo_ros_magnetc", "libhector_gazebo_ros_magnetic.so"),
    ("libgazebo_ros_steer_drive.so", None),  # other plugins
    ("libhector_gazebo_ros_baro.so", None),
    ("libhector_gazebo_ros_sonar.so", None),  # is known, in a <sensor>
    ("libcontroller.so", None),
    ("libgazebo_ros_f4.so", None),
])  # fmt: skip
def test_a_misspelled_library_is_told_which_one_is_near(library, meant):
    (warning,) = read(f'<gazebo><plugin name="it" filename="{library}"/></gazebo>').warnings
    text = f"plugin '{library}' is not known here and is ignored"
    assert warning == (f"{text}; did you mean '{meant}'?" if meant else text)


@pytest.mark.parametrize(
    "tags, name, expected",
    [
        ("", ' name="belt"', ("belt", "base", "conveyor", 0.0, "/belt", "base")),
        ("", "", ("conveyor", "base", "conveyor", 0.0, "/conveyor", "base")),
        (
            "<bodyName>car::arm</bodyName><updateRate>20</updateRate><topicName>t</topicName>"
            "<frameName>/f</frameName><robotNamespace>n</robotNamespace>",
            ' name="belt"',
            ("belt", "arm", "conveyor", 20.0, "/n/t", "f"),
        ),
    ],
)
def test_a_plugin_of_a_model(sources, tags, name, expected):
    sources[0]["conveyor"] = custom_plugin
    model = read(conveyor(tags, name))
    assert model.warnings == []
    (spec,) = model.sensors
    assert spec == CustomSpec(*expected, ZERO_POSE, spec.xml)


def test_a_plugin_on_a_link_that_does_not_exist(sources):
    sources[0]["conveyor"] = custom_plugin
    model = read(conveyor("<bodyName>leg</bodyName>"))
    assert model.sensors == [] and "'leg', which is no link" in model.warnings[0]


@pytest.mark.parametrize(
    "tags, inside, topic, rate",
    [
        ("", "", "/sniffer", 0.0),
        ("<updateRate>5</updateRate>", "<update_rate>20</update_rate>", "/sniffer", 5.0),
        ("<updateRate>50</updateRate>", "<update_rate>20</update_rate>", "/sniffer", 20.0),
        ("<topicName>smell</topicName><robotNamespace>n</robotNamespace>", "", "/n/smell", 0.0),
    ],
)
@pytest.mark.parametrize("kind", ["gas", "imu"])
def test_a_plugin_of_a_sensor_of_any_type(sources, tags, inside, topic, rate, kind):
    sources[1]["gas"] = custom_sensor
    model = read(gas(tags, inside, kind))
    assert model.warnings == []
    (spec,) = model.sensors
    pose = ((1.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    assert spec == CustomSpec("nose", "arm", "gas", rate, topic, "arm", pose, spec.xml)
    assert (spec.xml.type, spec.xml.plugin_name) == (kind, "sniffer")


def test_a_reader_that_says_its_types(sources):
    def reader(xml):
        return [custom_sensor(xml)]

    reader.types = ("gas",)
    sources[1]["gas"] = reader
    assert len(read(gas()).sensors) == 1
    (warning,) = read(gas(kind="sound")).warnings
    assert "type 'sound', known are" in warning
    (warning,) = read(gas(kind="contact")).warnings
    assert "a sensor of type contact takes libgazebo_ros_bumper.so" in warning
    assert "libgas.so' of sensor 'nose' is not known here" in warning


def test_another_plugin_beside_that_of_a_type_of_its_own(sources):
    sources[1]["gas"] = custom_sensor
    model = read(gas(inside='<plugin name="x" filename="libgazebo_ros_camera.so"/>'))
    assert [spec.library for spec in model.sensors] == ["gas"]
    (warning,) = model.warnings
    assert warning.endswith("is ignored; a sensor of type gas takes libgas.so")


def test_a_built_in_reader_cannot_be_replaced(sources):
    sources[1]["gazebo_ros_bumper"] = custom_sensor
    (spec,) = read(gas(kind="contact", library="libgazebo_ros_bumper.so")).sensors
    assert type(spec).__name__ == "ContactSpec"


def test_a_plugin_of_ones_own_may_read_sensors(sources):
    sources[0]["conveyor"] = custom_plugin
    text = (
        '<sdf version="1.6"><model name="m"><link name="a"><sensor name="s" type="imu"/></link>'
        '<plugin name="p" filename="libconveyor.so"/></model></sdf>'
    )
    assert parse_model(text, str)[0].warnings == []


@pytest.fixture(name="xml")
def _xml(sources):
    """The PluginXml of a plugin with the tags given."""
    sources[0]["conveyor"] = custom_plugin

    def make(tags):
        (spec,) = read(conveyor(tags)).sensors
        return spec.xml

    return make


VALUES = {
    "a number": ("<a>1.5</a>", lambda xml: xml.number("a", 2.0), 1.5),
    "no number": ("", lambda xml: xml.number("a", 2.0), 2.0),
    "an empty tag": ("<a> </a>", lambda xml: xml.number("a", 2.0), 0.0),
    "a whole number": ("<a>7</a>", lambda xml: xml.whole("a", 1), 7),
    "three numbers": ("<a>1 2 3</a>", lambda xml: xml.vector("a", 3), (1.0, 2.0, 3.0)),
    "two numbers": ("<a>1 2</a>", lambda xml: xml.vector("a", 2), (1.0, 2.0)),
    "no vector": ("", lambda xml: xml.vector("a", 2), (0.0, 0.0)),
    "a default": ("", lambda xml: xml.vector("a", 2, (5.0, 6.0)), (5.0, 6.0)),
    "one for all": ("<a>4</a>", lambda xml: xml.vector("a", 3, broadcast=True), (4.0,) * 3),
    "true": ("<a>Yes</a>", lambda xml: xml.flag("a"), True),
    "false": ("<a>0</a>", lambda xml: xml.flag("a", True), False),
    "no flag": ("", lambda xml: xml.flag("a", True), True),
    "a text": ("<a> some words </a>", lambda xml: xml.text("a"), "some words"),
    "no text": ("", lambda xml: xml.text("a", "none"), "none"),
    "a tag below another": ("<a><b>3</b></a>", lambda xml: xml.number("a/b"), 3.0),
    "a topic": ("", lambda xml: xml.topic("topicName", "conveyor/speed"), "/conveyor/speed"),
    "a topic below the namespace": (
        "<robotNamespace>n</robotNamespace><a>t</a>",
        lambda xml: xml.topic("a", "speed"),
        "/n/t",
    ),
    "a frame": ("<a>/map</a>", lambda xml: xml.frame("a", "world"), "map"),
    "no link": ("", lambda xml: xml.link("a", "base"), "base"),
    "a link": ("<a>/arm</a>", lambda xml: xml.link("a"), "arm"),
    "a joint": ("<a>elbow</a>", lambda xml: xml.joint("a"), "elbow"),
}


@pytest.mark.parametrize("tags, method, expected", VALUES.values(), ids=VALUES)
def test_what_a_plugin_reads(xml, tags, method, expected):
    assert method(xml(tags)) == expected


PLUGIN = "plugin '/opt/libconveyor.so'"
BAD = {
    "number": ("fast", f"{PLUGIN} <a> is 'fast', must be 1 finite number(s)"),
    "whole": ("0", f"{PLUGIN} <a> is 0, must be at least 1"),
    "vector": ("1 2", f"{PLUGIN} <a> is '1 2', must be 3 finite number(s)"),
    "flag": ("maybe", f"{PLUGIN} <a> is 'maybe', must be true or false"),
    "link": ("leg", f"{PLUGIN} has a 'leg', which is no link; links are base, arm; it is left out"),
    "joint": (
        "knee",
        f"{PLUGIN} has a 'knee', which is no joint; joints are elbow; it is left out",
    ),
}


@pytest.mark.parametrize("method", BAD)
def test_a_bad_value_is_an_error(xml, method):
    text, words = BAD[method]
    arguments = {"whole": (1,), "vector": (3,)}.get(method, ())
    with pytest.raises(ModelError) as error:
        getattr(xml(f"<a>{text}</a>"), method)("a", *arguments)
    assert str(error.value) == words


def test_a_bad_value_of_a_sensor_is_an_error(sources):
    sources[1]["gas"] = custom_sensor
    (spec,) = read(gas("<speed>fast</speed>", "<range><far>x</far></range>")).sensors
    with pytest.raises(ModelError, match="plugin 'libgas.so' <speed> is 'fast'"):
        spec.xml.number("speed")
    with pytest.raises(ModelError, match="nose 'nose' <far> is 'x'"):
        spec.xml.part("range", "nose").number("far", math.inf)
