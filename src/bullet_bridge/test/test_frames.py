"""Prefixes of frames, looked up at a fake master."""

from dataclasses import dataclass
from types import SimpleNamespace

import pytest
import rosgraph
from bullet_bridge.plugins import frames
from bullet_sim.plugins.drives import WheelDriveSpec
from bullet_sim.plugins.rules import NAMESPACE, NEAREST, OWN, FrameName, FramePrefix

PARAMETERS = {"/tf_prefix": "all", "/a/tf_prefix": "/a_robot", "/number/tf_prefix": 3}


@pytest.fixture(autouse=True)
def _master(monkeypatch):
    def master(caller):
        parts = [part for part in caller.split("/") if part]
        above = ["/" + "/".join([*parts[:end], "tf_prefix"]) for end in range(len(parts), -1, -1)]

        def search(_name):
            if not parts:
                raise rosgraph.MasterFailure("namespace must be global")
            found = next((name for name in above if name in PARAMETERS), None)
            if found is None:
                raise rosgraph.MasterException("no such parameter")
            return found

        def get(name):
            if name not in PARAMETERS:
                raise rosgraph.MasterException("no such parameter")
            return PARAMETERS[name]

        return SimpleNamespace(searchParam=search, getParam=get)

    monkeypatch.setattr(frames.rosgraph, "Master", master)


@pytest.mark.parametrize(
    "source, namespace, expected",
    [
        (OWN, "a", "a_robot/f"),
        (OWN, "b", "f"),
        (OWN, "", "all/f"),
        (NEAREST, "a", "a_robot/f"),
        (NEAREST, "a/camera/left", "a_robot/f"),
        (NEAREST, "b", "all/f"),
        (NEAREST, "", "all/f"),
        (OWN, "number", "f"),
        (NAMESPACE, "b", "b/f"),
        (NAMESPACE, "", "all/f"),
    ],
)
def test_the_parameter_of_each_rule(source, namespace, expected):
    spec = WheelDriveSpec(
        "d",
        "base",
        left=("l",),
        right=("r",),
        frame_id=FrameName("f", FramePrefix(source, namespace)),
        wheel_frames={"l": (FrameName("base", FramePrefix(source, namespace)), "wheel")},
    )
    found = frames.with_prefixes(spec)
    assert found.frame_id == expected and found.child_frame_id == "base_footprint"
    assert found.wheel_frames == {"l": (expected[:-1] + "base", "wheel")}


def test_a_spec_without_frames_is_the_same_and_asks_nobody(monkeypatch):
    monkeypatch.setattr(frames.rosgraph, "Master", None)

    @dataclass(frozen=True)
    class Spec:
        frame_id: str = FrameName("world")

    spec, other = Spec(), object()
    assert frames.with_prefixes(spec) is spec and frames.with_prefixes(other) is other


def test_without_a_master_there_is_no_prefix(monkeypatch):
    def refuse(_name):
        raise ConnectionRefusedError

    monkeypatch.setattr(
        frames.rosgraph, "Master", lambda _: SimpleNamespace(searchParam=refuse, getParam=refuse)
    )
    assert frames.parameter(FramePrefix(NEAREST, "a")) == ""
