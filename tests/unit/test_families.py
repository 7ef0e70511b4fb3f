"""Each file that enters classes in a registry is loaded, and each plugin is in the documents."""

import re
import subprocess
import sys
from pathlib import Path

import bullet_bridge.plugins  # noqa: F401  enters its own
import pytest
from bullet_sim.plugins import PLUGINS, SENSOR_PLUGINS

SRC = Path(__file__).resolve().parents[2] / "src"
ENTERS = re.compile(
    r"^@(?:CONTROLLERS\.register|sensor_plugin|model_plugin|ros_side|part_of)\(", re.M
)
LOADED_BY = {  # folder -> the import that has to load its files
    "bullet_sim/plugins": "bullet_sim.plugins",
    "bullet_sim/controllers": "bullet_sim.controllers",
    "bullet_bridge/plugins": "bullet_bridge.plugins",
    "bullet_bridge/control": "bullet_bridge.robots",
}


@pytest.mark.parametrize("folder", LOADED_BY)
def test_each_family_is_loaded(folder):
    package = folder.split("/")[0]
    files = sorted((SRC / package / "src" / folder).glob("*.py"))
    wanted = [path.stem for path in files if ENTERS.search(path.read_text())]
    assert wanted
    script = f"import sys, {LOADED_BY[folder]}; print(*sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    loaded = done.stdout.split()
    for name in wanted:
        module = f"{folder}/{name}".replace("/", ".")
        where = f"src/{package}/src/{folder}/__init__.py"
        assert module in loaded, f"{module} is not loaded: import it in {where}"


def test_the_table_of_plugins_has_every_library():
    text = (SRC.parent / "docs" / "formats.md").read_text()
    names = {*PLUGINS.names(), *SENSOR_PLUGINS.names()}
    assert [name for name in sorted(names) if f"`lib{name}.so`" not in text] == []


THERMOMETER = '''"""A thermometer."""

from dataclasses import dataclass

from bullet_sim.parts.base import Sensor, part_of
from bullet_sim.plugins.registry import sensor_plugin
from bullet_sim.plugins.spec import SensorSpec, number, rate_of, topic_of


@sensor_plugin("gazebo_ros_thermometer", types=("thermometer",))  # libgazebo_ros_thermometer.so
@dataclass(frozen=True)
class ThermometerSpec(SensorSpec):
    heat: float = number("heat", 20.0)  # the tag, and the default without it [deg C]
    rate: float = rate_of()
    topic: str = topic_of("topicName", "temperature")


@part_of(ThermometerSpec)
class Thermometer(Sensor):
    MESSAGE, FIELDS = "std_msgs/Float64", {"data": 1}

    def measure(self, time):
        return ([self.spec.heat + self.rng.normal(0.0, 0.1)],)
'''
HEATED = """<robot name="r"><link name="l"><inertial><mass value="1"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link><gazebo reference="l">
<sensor name="s" type="thermometer"><plugin filename="libgazebo_ros_thermometer.so">
<heat>30</heat></plugin></sensor></gazebo></robot>"""
READ = """
import sys
from bullet_sim import plugins
from bullet_sim.registry import load_files
plugins.__path__.append(sys.argv[1])  # as if the file were there
load_files(plugins.__name__, plugins.__path__)
import bullet_bridge.plugins
from bullet_bridge.plugins.base import ROS_SIDE, ModelPlugin
from bullet_sim.formats.urdf import parse_urdf
(spec,) = parse_urdf(sys.argv[2], str).sensors
kind = ROS_SIDE[type(spec)]
print(spec.heat, spec.topic, spec.link, kind.__name__, issubclass(kind, ModelPlugin))
"""


def test_a_sensor_is_one_file(tmp_path):
    (tmp_path / "thermometers.py").write_text(THERMOMETER)
    command = [sys.executable, "-c", READ, str(tmp_path), HEATED]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    assert done.stdout.splitlines()[-1] == "30.0 /temperature l Thermometer True"
