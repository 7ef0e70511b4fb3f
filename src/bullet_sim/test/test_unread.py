"""Elements of SDF that have an effect in Gazebo and none here are named once."""

import pytest
from bullet_sim.formats.sdf.unread import UNREAD
from bullet_sim.formats.sdf.world import parse_model, parse_world

LINK = "<link name='l'>%s</link>"
PLACES = {  # root of a path -> what is around it in a document
    "physics": "%s",
    "scene": "%s",
    "state": "%s",
    "link": f"<model name='m'>{LINK % ''}%s</model>",
    "joint": f"<model name='m'>{LINK % ''}%s</model>",
    "heightmap": f"<model name='m'>{LINK % '<visual name=%sv%s>%%s</visual>'}</model>" % ("'", "'"),
    "": f"<model name='m'>{LINK}</model>",
}


def document(path, value):
    """A world that has a value at a path, from the root of its description."""
    path, _, attribute = path.partition("@")
    *outer, last = path.split("/")
    text = f"<{last} {attribute}='{value}'/>" if attribute else f"<{last}>{value}</{last}>"
    for tag in reversed(outer):
        text = f"<{tag}>{text}</{tag}>"
    around = PLACES.get(path.split("/")[0], PLACES[""])
    return f'<sdf version="1.7"><world name="w">{around % text}</world></sdf>'


def named(path, text):
    return [warning for warning in parse_world(text, str, "w").warnings if f"<{path}>" in warning]


@pytest.mark.parametrize("path", UNREAD)
def test_what_has_no_effect_is_named_where_it_is_not_the_default(path):
    (warning,) = named(path, document(path, "7"))
    assert "line 1" in warning and "'7'" in warning and "ignored here" in warning
    for value in (*UNREAD[path], ""):
        assert named(path, document(path, value)) == []


def test_defaults_are_compared_as_numbers_and_plugins_are_not_read():
    solver = "<physics><ode><solver><precon_iters>%s</precon_iters></solver></ode></physics>"
    model = "<sdf version='1.6'><model name='m'><link name='l'>%s</link></model></sdf>"
    plugin = f"<plugin name='p' filename='libgazebo_ros_imu.so'>{solver % 1}</plugin>"
    assert parse_model(model % plugin, str)[0].warnings == []
    assert parse_model(model % (solver % "0.0e-01"), str)[0].warnings == []
    assert len(parse_model(model % (solver % "0.1"), str)[0].warnings) == 1
