"""The definitions' MD5 sums are ROS Noetic's; computed from the files, no build needed."""

import glob
import hashlib
import os

import pytest
from md5_table import CONNECTION, SUMS

gentools = pytest.importorskip("genmsg.gentools")
msg_loader = pytest.importorskip("genmsg.msg_loader")
rospkg = pytest.importorskip("rospkg")

STANDINS = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
FOREIGN = ("actionlib_msgs", "geometry_msgs", "std_msgs", "trajectory_msgs")


@pytest.fixture(name="search_path", scope="module")
def _search_path():
    places = [p for p in os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep) if p]
    rospack = rospkg.RosPack(places + ["/opt/ros/noetic/share", "/usr/share"])
    path = {name: [os.path.join(rospack.get_path(name), "msg")] for name in FOREIGN}
    for name in os.listdir(STANDINS):
        path[name] = [os.path.join(STANDINS, name, "msg")]
    return path


def _text(definition, name, search_path):
    """The text that a definition's sum is taken of."""
    context = msg_loader.MsgContext.create_default()
    spec = msg_loader.load_msg_from_string(context, definition, name)
    msg_loader.load_depends(context, spec, search_path)
    return gentools.compute_md5_text(context, spec)


def _texts(relative, search_path):
    """One text for each part of a file."""
    package, _, file_name = relative.split("/")
    # A name of its own: the action GripperCommand holds the message GripperCommand.
    name = "{}/{}Part".format(package, file_name.split(".")[0])
    with open(os.path.join(STANDINS, relative), encoding="utf-8") as stream:
        return [_text(part, name, search_path) for part in stream.read().split("---\n")]


def _sum(text):
    return hashlib.md5(text.encode("ascii")).hexdigest()


def _sums(relative, search_path):
    return tuple(_sum(text) for text in _texts(relative, search_path))


def _connection_sums(relative, search_path):
    texts = _texts(relative, search_path)
    if relative.endswith(".srv"):
        return (_sum("".join(texts)),)
    sums = []
    for kind, wrap, text in zip(
        ("goal", "result", "feedback"),
        ("GoalID goal_id", "GoalStatus status", "GoalStatus status"),
        texts,
    ):
        outer = _text(f"Header header\nactionlib_msgs/{wrap}\n", "control_msgs/Wrap", search_path)
        sums.append(_sum(f"{outer}\n{_sum(text)} {kind}"))
    return tuple(sums)


@pytest.mark.parametrize("relative", sorted(SUMS))
def test_sum(relative, search_path):
    assert _sums(relative, search_path) == SUMS[relative]


@pytest.mark.parametrize("relative", sorted(CONNECTION))
def test_connection_sum(relative, search_path):
    assert _connection_sums(relative, search_path) == CONNECTION[relative]


def test_every_definition_is_in_the_table():
    files = [
        f
        for kind in ("msg", "srv", "action")
        for f in glob.glob(os.path.join(STANDINS, "*", kind, "*." + kind))
    ]
    assert {os.path.relpath(f, STANDINS) for f in files} == set(SUMS)
    assert {name for name in SUMS if not name.endswith(".msg")} == set(CONNECTION)
