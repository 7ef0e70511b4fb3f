"""Readers of plugins ask for no parameter that upstream's sources do not know."""

import collections
import pathlib
import re

import pytest
from bullet_sim.plugins import PLUGINS, SENSOR_PLUGINS
from plugin_robots import robot_with
from test_plugin_parameters import NEEDED

from bullet_sim import xml_reader

pytestmark = pytest.mark.usefixtures("sketches")

ROOT = pathlib.Path(__file__).resolve().parents[3]
CAMERAS = ("gazebo_ros_camera_utils", "gazebo_ros_depth_camera")
FORCE_MOVES = ("gazebo_ros_force_based_move", "nexus_ros_force_based_move")
# Plugins that read what is named of others: they share their sources, or are forks of them.
SHARED = {
    "gazebo_ros_diff_drive": ("gazebo_ros_utils",),
    "gazebo_ros_tricycle_drive": ("gazebo_ros_utils",),
    "gazebo_ros_kobuki": ("gazebo_ros_utils",),
    "hector_servo_plugin": ("servo_plugin",),
    "WheelSlipPlugin": ("gazebo_ros_wheel_slip",),
    "gazebo_ros_harness": ("HarnessPlugin",),
    "roboticsgroup_gazebo_mimic_joint_plugin": (
        "roboticsgroup_upatras_gazebo_mimic_joint_plugin",
    ),
    **dict.fromkeys(
        ("gazebo_ros_force_based_move", "ridgeback_ros_force_based_move",
         "nexus_ros_force_based_move", "robotnik_force_based_move", "r550_force_based_move"),
        FORCE_MOVES,
    ),
}  # fmt: skip
# Beyond upstream's, and why: they are off by default, or are read by older versions.
OURS = {
    "gazebo_ros_p3d": {"headerFrame", "twistFrame"},  # off by default
    "hector_gazebo_ros_imu": {"headingGaussianNoise"},  # of older versions, with its like
}
NAMESPACE = "robotNamespace"  # which says nothing to plugins without topics


def upstream():
    """Library -> first parts of the names that docs/support/names has of it."""
    found = collections.defaultdict(set)
    for path in (ROOT / "docs" / "support" / "names").glob("*.txt"):
        for line in path.read_text().splitlines():
            library, _, name = line.partition("/")
            if name and not line.startswith("#"):
                found[library].add(re.split(r"[/@]", name)[0])
    return found


def spied(method, names):
    """A method of an element that notes what is looked for in a <plugin>."""
    real = getattr(xml_reader.ElementTree.Element, method)

    def look(self, path, *args, **more):
        if self.tag == "plugin":
            names.add(re.split(r"[/@]", path)[0])
        return real(self, path, *args, **more)

    return look


@pytest.fixture(name="asked")
def _asked(monkeypatch):
    """Names of the children that have been looked for in a <plugin>."""
    names = set()
    for method in ("find", "findall", "findtext"):
        monkeypatch.setattr(xml_reader.Node, method, spied(method, names), raising=False)
    return names


LIBRARIES = sorted({*PLUGINS.names(), *SENSOR_PLUGINS.names()})


@pytest.mark.parametrize("library", [n for n in LIBRARIES if not n.startswith("paddock_")])
def test_a_reader_asks_for_upstreams_names_alone(library, asked):
    names = upstream()
    known = {NAMESPACE} | OURS.get(library, set())
    cameras = CAMERAS if "camera" in library or "openni" in library else ()
    for other in (library, *SHARED.get(library, ()), *cameras):
        known |= names.get(other, set())
    given = {name: "1" for name in sorted(known) if name.isidentifier()}
    for tags in ({}, {**given, **NEEDED.get(library, {})}):
        robot_with(library, "".join(f"<{tag}>{text}</{tag}>" for tag, text in tags.items()))
    assert asked <= known
