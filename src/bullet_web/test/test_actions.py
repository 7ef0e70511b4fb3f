"""What pages spawn: read by the simulator without a warning, and standing."""

import math

import pytest
import rospy
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.pose import Pose
from bullet_sim.world import World
from bullet_web.actions import (
    BOX,
    CLEARANCE,
    CONE_PARTS,
    ActionError,
    Actions,
    cone,
    free_name,
    parked,
)
from nav_msgs.msg import Odometry
from paddock_common.geometry import pose_of

ROBOT = """<robot name="r"><link name="l"/>
  <transmission name="t"/>
  <gazebo><plugin name="c" filename="libgazebo_ros_control.so"/></gazebo>
  <gazebo reference="l"><material>Gazebo/Red</material><sensor name="s" type="ray"/></gazebo>
</robot>"""


@pytest.mark.parametrize("text, mass, height", [(BOX, 0.5, 0.2), (cone(), 0.3, 0.212)])
def test_what_is_spawned_falls_and_stands(text, mass, height):
    world = World()
    try:
        from bullet_sim.description.world import ground_plane

        world.spawn(ground_plane())
        model = world.spawn_sdf("thing", text, Pose((0.0, 0.0, 0.05)), str)
        assert model.description.warnings == []
        assert sum(link.mass for link in model.rigid_parts.values()) == pytest.approx(mass)
        world.step(2000)
        assert model.pose.position[2] == pytest.approx(0.0, abs=0.005)
        assert model.pose.orientation[3] == pytest.approx(1.0, abs=0.01)
        tops = [part[2] + part[1] / 2 for part in CONE_PARTS]
        assert height == (max(tops) if text != BOX else 0.2)
    finally:
        world.close()


def test_a_parked_robot_has_no_sensors_and_plugins():
    description = parse_urdf(parked(ROBOT), str, "r")
    assert description.sensors == [] and description.control_namespace is None
    assert "Gazebo/Red" in parked(ROBOT)
    with pytest.raises(ActionError, match="/robot_description is no XML"):
        parked("<robot")


def test_names_are_free():
    assert free_name("box", []) == "box_1"
    assert free_name("box", ["box_1", "box_3"]) == "box_2"


@pytest.mark.parametrize("kind, text", [("box", BOX), ("cone", cone())])
def test_what_is_spawned_comes_from_above_under_a_free_name(monkeypatch, kind, text):
    asked = []
    actions = Actions(lambda: [f"{kind}_1"], lambda _: None, lambda _: None)
    monkeypatch.setattr(actions, "_call", lambda name, _, **fields: asked.append((name, fields)))
    message = {"action": "spawn", "kind": kind, "x": 1.0, "y": 2.0, "z": 0.5, "yaw": 0.3}
    assert actions.execute(message) == f"{kind}_2 is there"
    ((name, fields),) = asked
    assert name == "/gazebo/spawn_sdf_model"
    assert (fields["model_name"], fields["model_xml"]) == (f"{kind}_2", text)
    assert fields["initial_pose"] == pose_of(1.0, 2.0, 0.3, 0.5 + CLEARANCE)


def test_a_model_that_cannot_move_is_not_put_elsewhere():
    actions = Actions(lambda: [], lambda name: None, lambda link: None)
    message = {"action": "place", "model": "track", "x": 0.0, "y": 0.0, "z": 0.0}
    with pytest.raises(ActionError, match="model is 'track', which is none that can move"):
        actions.execute(message)


@pytest.mark.parametrize(
    "place, goal",
    [((2.0, 4.0), (8.0, 5.0)), ((1.0, 1.0), (5.0, 6.0))],  # 3 m ahead, 1 m to its left
)
def test_a_goal_is_carried_into_the_frame_of_an_odometry(place, goal):
    # The truck stands at (2, 1) and looks along y; its odometry says (5, 5), along x.
    message = Odometry(child_frame_id="truck/base")
    message.pose.pose = pose_of(5.0, 5.0)
    poses = {"base": (2.0, 1.0, math.pi / 2)}
    actions = Actions(lambda: (), lambda _: None, poses.get)
    assert actions._in_odometry(place, message) == pytest.approx(goal)


def test_a_goal_of_the_truck_without_a_heading_is_along_x(monkeypatch):
    asked = []
    actions = Actions(lambda: (), lambda _: None, lambda _: None)
    monkeypatch.setattr(rospy, "wait_for_message", lambda *_: Odometry())
    monkeypatch.setattr(actions, "_call", lambda *arguments: asked.append(arguments))
    assert actions._goal_of_truck({"x": 1.0, "y": 2.0}) == "the goal is 1.00, 2.00"
    ((name, _, request),) = asked
    assert name == "/goal" and request.pose == pose_of(1.0, 2.0)


def test_poses_are_upright():
    pose = pose_of(1, 2, 0.0, 3)
    assert (pose.position.x, pose.orientation.w) == (1.0, 1.0)


def test_a_refusal_names_the_model(monkeypatch):
    def refuse(_self, _message):
        raise ActionError("DeleteModel: model does not exist")

    monkeypatch.setattr(Actions, "_remove", refuse)
    actions = Actions(lambda: (), lambda _: None, lambda _: None)
    with pytest.raises(ActionError, match="^remove 'box_1': DeleteModel: model does not exist$"):
        actions.execute({"action": "remove", "model": "box_1"})
