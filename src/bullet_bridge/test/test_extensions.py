"""Extensions of users' packages: read from package.xml, loaded, and refused with a reason."""

import pytest
import rospkg
from bullet_bridge.extensions import Extensions
from bullet_sim.controllers import CONTROLLERS
from bullet_sim.errors import ControllerError, SimError
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.plugins.registry import PLUGINS, SENSOR_PLUGINS

from bullet_bridge import extensions as module

pytestmark = pytest.mark.usefixtures("sketches")

MANIFEST = (
    '<package format="2"><name>{}</name><version>1.0.0</version><description>d</description>'
    '<maintainer email="a@b.org">m</maintainer><license>BSD</license>'
    "<buildtool_depend>catkin</buildtool_depend><export>{}</export></package>"
)
CODE = """
from bullet_bridge.plugins.base import ModelPlugin, Sensor
from bullet_sim.controllers import Controller

class Push(Controller):
    pass

class Belt(ModelPlugin):
    pass

class Nose(Sensor):
    pass
"""
LINES = (
    '<bullet_bridge controller="my/Push" class="my_code:Push"/>'
    '<bullet_bridge plugin="libbelt.so" class="my_code:Belt"/>'
    '<bullet_bridge sensor="nose" class="my_code:Nose" type="gas"/>'
)


@pytest.fixture(name="make")
def _make(tmp_path, monkeypatch):
    """Function: packages by name with their exports -> Extensions; and the log."""
    (tmp_path / "my_code.py").write_text(CODE)
    monkeypatch.syspath_prepend(str(tmp_path))
    log = []
    monkeypatch.setattr(module.rospy, "logerr", lambda text, *rest: log.append(text % rest))

    def make(**packages):
        for name, lines in packages.items():
            folder = tmp_path / "packages" / name
            folder.mkdir(parents=True)
            (folder / "package.xml").write_text(MANIFEST.format(name, lines))
        return Extensions(rospkg.RosPack([str(tmp_path / "packages")])), log

    return make


@pytest.fixture(name="entered")
def _entered(make, monkeypatch):
    """Extensions that the registries ask, for one test."""
    for registry in (CONTROLLERS, PLUGINS, SENSOR_PLUGINS):
        monkeypatch.setattr(registry, "_sources", [])
    found, _ = make(mine=LINES)
    found.enter()
    return found


def test_classes_are_looked_up_by_type_and_library(make):
    found, log = make(mine=LINES, other="<gazebo_ros plugin_path='x'/>")
    assert found.get("controller", "my/Push").load().__name__ == "Push"
    assert found.get("plugin", "belt").load().__name__ == "Belt"
    assert found.get("sensor", "nose").sensor_type == "gas"
    assert found.get("plugin", "nose") is None and log == []
    assert str(found.get("plugin", "belt")) == "plugin 'belt' is my_code:Belt of package mine"


def test_the_registries_know_them_after_what_is_built_in(entered):
    assert CONTROLLERS.names()[-1] == "my/Push" and not CONTROLLERS.is_built_in("my/Push")
    assert CONTROLLERS.find("my/Push").__name__ == "Push"
    text = (
        '<robot name="r"><link name="base"/><gazebo><plugin name="b" filename="libbelt.so">'
        '<speed>2</speed></plugin></gazebo><gazebo reference="base"><sensor name="s" type="gas">'
        '<update_rate>5</update_rate><plugin name="n" filename="libnose.so"/></sensor></gazebo>'
        "</robot>"
    )
    model = parse_urdf(text, str, "r")
    assert model.warnings == []
    belt, nose = sorted(model.sensors, key=lambda spec: spec.library)
    assert (belt.library, belt.rate, belt.xml.number("speed")) == ("belt", 0.0, 2.0)
    assert (nose.library, nose.rate, nose.link) == ("nose", 5.0, "base")
    assert entered.plugin(belt).__name__ == "Belt" and entered.plugin(nose).__name__ == "Nose"


def test_a_model_without_them_reads_no_manifest(entered, monkeypatch):
    monkeypatch.setattr(Extensions, "_read", lambda _: pytest.fail("manifests were read"))
    text = '<robot name="r"><link name="l"/><gazebo><plugin name="c" filename="libgazebo_ros_control.so"/></gazebo></robot>'  # noqa: E501
    assert parse_urdf(text, str, "r").warnings == []
    assert CONTROLLERS.find("effort_controllers/JointEffortController")


@pytest.mark.parametrize(
    "line, words",
    [
        ('<bullet_bridge class="a:B"/>', "has <bullet_bridge> with class, must have one of contr"),
        ('<bullet_bridge plugin="p" sensor="s" class="a:B"/>', "must have one of controller"),
        ('<bullet_bridge plugin="libp.so" class="a.B"/>', "'libp.so' with class 'a.B', must be M"),
        ('<bullet_bridge controller="a/B"/>', "'a/B' with class '', must be MODULE:CLASS"),
    ],
)
def test_a_line_that_is_wrong_is_named_and_the_others_count(make, line, words):
    found, log = make(mine=line + LINES)
    assert len(found.all()) == 3
    assert len(log) == 1 and "mine/package.xml" in log[0] and words in log[0]


def test_two_packages_of_one_name_are_both_named(make):
    found, log = make(mine=LINES, yours='<bullet_bridge plugin="belt" class="b:C"/>')
    assert found.get("plugin", "belt").package == "mine"
    assert log == [
        "plugin 'belt' is exported by the packages mine and yours, must be by one; that of mine is "
        "used"
    ]


@pytest.mark.parametrize(
    "target, words",
    [
        ("nowhere:A", "cannot be imported: ModuleNotFoundError"),
        ("my_code:A", "cannot be imported: AttributeError"),
        ("my_code:Belt", "is no subclass of bullet_sim.controllers.base.Controller"),
        ("math:pi", "is no subclass of"),
    ],
)
def test_a_class_that_cannot_be_had_is_an_error_with_its_place(make, target, words):
    found, _ = make(mine=f'<bullet_bridge controller="my/Push" class="{target}"/>')
    with pytest.raises(SimError, match=words) as error:
        found.get("controller", "my/Push").load()
    assert "mine/package.xml" in str(error.value) and target in str(error.value)
    with pytest.raises(ControllerError, match=words):
        found.controller("my/Push")
