"""The track's markers for rviz."""

import os

import pytest
from track_model.track_markers import track_markers
from visualization_msgs.msg import Marker

from track_model import track

WALLED = """points: [[0, 0], [3, 0], [3, 3], [0, 3]]
walls: {enabled: true, height: 0.3}
colours: {wall: [255, 0, 51]}
"""


def test_ground_and_walls_are_those_of_the_track(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    file = tmp_path / "walled.yaml"
    file.write_text(WALLED)
    folder = track.load_track(str(file)).directory
    with open(os.path.join(folder, "track.sdf"), encoding="utf-8") as description:
        made = track_markers(description.read(), "map").markers
    ground, *walls = made
    assert (ground.type, ground.mesh_resource) == (
        Marker.MESH_RESOURCE,
        f"file://{folder}/track.obj",
    )
    assert ground.mesh_use_embedded_materials and ground.scale.x == 1.0
    assert len(walls) > 20 and {wall.type for wall in walls} == {Marker.CUBE}
    assert {wall.scale.z for wall in walls} == {0.3}
    assert {wall.pose.position.z for wall in walls} == {0.15}
    assert (walls[0].color.r, walls[0].color.b, walls[0].color.a) == (1.0, 0.2, 1.0)
    assert [marker.id for marker in made] == list(range(len(made)))
    assert {marker.header.frame_id for marker in made} == {"map"}


@pytest.mark.parametrize(
    "description, message",
    [
        ("no XML", "is not the SDF of a track"),
        ("<sdf><model><link/></model></sdf>", "has 0 visuals"),
        (
            "<sdf><visual><geometry><sphere/></geometry></visual></sdf>",
            "has 1 visuals and no mesh or box",
        ),
    ],
)
def test_a_description_without_a_track_is_refused(description, message):
    with pytest.raises(ValueError, match=message):
        track_markers(description, "odom")
