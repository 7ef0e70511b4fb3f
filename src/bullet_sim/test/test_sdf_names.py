"""Readers of SDF ask for no element or attribute that sdformat does not describe."""

import pathlib
import re

import pytest
from bullet_sim.formats.sdf.world import parse_world

from bullet_sim import xml_reader

NAMES = pathlib.Path(__file__).resolve().parents[3] / "docs" / "support" / "names"
FILES = {  # element -> what its description includes, as a world has it
    "world": (
        *("scene", "physics", "light", "model", "frame", "population", "road", "actor"),
        *("spherical_coordinates", "state", "plugin"),
    ),
    "model": ("link", "joint", "frame", "gripper", "pose", "plugin"),
    "population": ("model", "include", "pose"),
    "link": ("inertial", "collision", "visual", "sensor", "light", "pose", "battery", "projector"),
    "collision": ("geometry", "surface", "pose"),
    "visual": ("geometry", "material", "pose"),
    "geometry": ("box", "sphere", "cylinder", "plane", "mesh", "heightmap", "polyline", "image"),
    "joint": ("pose", "sensor"),
    "sensor": ("camera", "ray", "imu", "contact", "gps", "pose", "plugin"),
    "ray": ("noise",),
    "camera": ("noise", "pose"),
    "actor": ("pose", "link", "joint", "plugin"),
    **dict.fromkeys("xyz", ("noise",)),
    "inertial": ("pose",),
    "light": ("pose",),
}
TEXTS = {"uri": "model://none", "filename": "libnone.so"}
# Beyond sdformat's descriptions, and why.
OURS = {
    ("sdf", "@version"), ("joint", "@type"), ("sensor", "@type"), ("physics", "@default"),
}  # fmt: skip


def described():
    """(element, what it may have), attributes with an @."""
    found = set()
    for name in ("sdf.txt", "sdf_old.txt"):
        for line in (NAMES / name).read_text().splitlines():
            if not line.startswith("#"):
                parts = line.strip().replace("@", "/@").split("/")
                found |= set(zip(parts, parts[1:]))
    for element, included in FILES.items():
        found |= {(element, part) for part in included}
    return found


def everything(tag, parts, leaves, depth=0):
    """An element with all that is described of it, each once.

    Args:
        parts: element -> what it may have.
        leaves: False: without what contains nothing, for which readers have to ask then.
    """
    inner = [name for name in parts.get(tag, ()) if not name.startswith("@")]
    if depth > 8 or not (inner or leaves):
        return ""
    attributes = " ".join(
        f'{name[1:]}="{TEXTS.get(name[1:], f"x{depth}")}"'
        for name in parts.get(tag, ())
        if name.startswith("@")
    )
    inside = "".join(everything(name, parts, leaves, depth + 1) for name in inner if name != tag)
    return f"<{tag} {attributes}>{inside or TEXTS.get(tag, '1')}</{tag}>"


@pytest.fixture(name="worlds", scope="module")
def _worlds():
    parts = {}
    for parent, name in sorted(described()):
        parts.setdefault(parent, []).append(name)
    return [everything("world", parts, leaves) for leaves in (True, False)]


@pytest.fixture(name="asked")
def _asked(monkeypatch):
    """(tag of an element, what has been looked for in it)."""
    found = set()
    for method in ("find", "findall", "findtext", "get"):
        monkeypatch.setattr(xml_reader.Node, method, spied(method, found), raising=False)
    return found


def spied(method, found):
    """A method of an element that notes what is looked for."""
    real = getattr(xml_reader.ElementTree.Element, method)

    def look(self, path, *args, **more):
        parts = [self.tag, *(f"@{path}" if method == "get" else path).split("/")]
        found.update(zip(parts, parts[1:]))
        return real(self, path, *args, **more)

    return look


@pytest.mark.parametrize("kind", ["camera", "depth", "ray", "imu", "contact", "gps"])
def test_readers_ask_for_what_sdformat_describes(kind, worlds, asked):
    library = {"ray": "gazebo_ros_laser", "imu": "gazebo_ros_imu_sensor"}.get(
        kind, "gazebo_ros_bumper" if kind == "contact" else "gazebo_ros_camera"
    )
    plugin = f'<plugin name="p" filename="lib{library}.so"><frameName>f</frameName></plugin>'
    sensor = f'<sensor name="s" type="{kind}">{plugin}'
    for world in worlds:
        text = re.sub("<sensor [^>]*>", sensor, world)
        parse_world(f'<sdf version="1.5">{text}</sdf>', lambda uri: uri)
    beyond = {pair for pair in asked - described() - OURS if pair[0] not in ("plugin", "sdf", "?")}
    assert sorted(beyond) == []
