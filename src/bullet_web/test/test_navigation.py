"""Maps, plans and particles as pages get them; where their frames are; goals."""

import json
import math
import struct

import cv2
import numpy as np
import pytest
from bullet_web.navigation import (
    MAX_CELLS,
    MAX_POSES,
    Frames,
    Navigation,
    Navigator,
    anchor,
    grid_message,
    inverse,
    layers,
    navigators,
    path_message,
    placed,
    poses_message,
)
from geometry_msgs.msg import Pose, PoseArray, PoseStamped, TransformStamped
from nav_msgs.msg import MapMetaData, Path
from tf2_msgs.msg import TFMessage

UNKNOWN, FREE, OCCUPIED = -1, 0, 100
CLEAR = [0, 0, 0, 0]  # blue, green, red, alpha


def info(resolution=0.5, x=0.0, y=0.0, yaw=0.0):
    """nav_msgs/MapMetaData; its size is not looked at."""
    found = MapMetaData(resolution=resolution)
    found.origin.position.x, found.origin.position.y = x, y
    found.origin.orientation.z, found.origin.orientation.w = math.sin(yaw / 2), math.cos(yaw / 2)
    return found


def unpacked(message):
    """Head and payload of a binary message."""
    (length,) = struct.unpack_from("<I", message)
    return json.loads(message[4 : 4 + length]), message[4 + length :]


def picture(message):
    """Head and pixels (H, W, 4) of a grid's message."""
    head, data = unpacked(message)
    return head, cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)


def transform(parent, child, x, y, yaw):
    """A TFMessage of one transform."""
    found = TransformStamped(child_frame_id=child)
    found.header.frame_id = parent
    found.transform.translation.x, found.transform.translation.y = x, y
    found.transform.rotation.z = math.sin(yaw / 2)
    found.transform.rotation.w = math.cos(yaw / 2)
    return TFMessage([found])


def test_a_map_is_a_picture_of_what_is_known():
    cells = np.full((6, 8), UNKNOWN, np.int8)
    cells[1, 2:5], cells[3, 4] = FREE, OCCUPIED
    head, pixels = picture(grid_message("/map", info(x=-1.0, y=2.0, yaw=0.5), "map", cells))
    assert head["origin"] == pytest.approx([-1.0, 2.0, 0.5])
    assert (head["frame"], head["at"], head["size"]) == ("map", [1.0, 0.5], [1.5, 1.5])
    assert pixels.shape == (3, 3, 4)
    assert pixels[2, 0].tolist() == [255, 255, 255, 90], "the least y is below"
    assert pixels[0, 2].tolist() == [0, 0, 0, 240] and pixels[0, 0].tolist() == CLEAR


def test_a_costmap_has_the_colors_of_rviz():
    cells = np.array([[0, 1, 98, 99, 100, -1, 101]], np.int8)
    pixels = picture(grid_message("/move_base/global_costmap/costmap", info(), "map", cells))[1]
    assert pixels.shape == (1, 4, 4), "what costs nothing or is unknown is not drawn"
    low, high, inscribed, obstacle = pixels[0, :, :3].tolist()
    assert low[0] > 250 and high[2] > 248
    assert inscribed == [255, 255, 0] and obstacle == [255, 0, 180]


def test_a_large_map_keeps_its_walls():
    cells = np.zeros((3, 2 * MAX_CELLS), np.int8)
    cells[1, 1001] = OCCUPIED
    head, pixels = picture(grid_message("/map", info(0.05), "map", cells))
    assert pixels.shape == (2, MAX_CELLS, 4)
    assert head["size"] == pytest.approx([0.05 * 2 * MAX_CELLS, 0.2])
    assert pixels[1, 500, :3].tolist() == [0, 0, 0] and (pixels[:, :, 2] == 0).sum() == 1


def test_an_unknown_map_is_a_transparent_one():
    pixels = picture(grid_message("/map", info(), "map", np.full((5, 5), UNKNOWN, np.int8)))[1]
    assert pixels.tolist() == [[CLEAR]]


@pytest.mark.parametrize(
    "change, reason",
    [
        ({"resolution": 0.0}, "cells of 0.0 m"),
        ({"resolution": math.nan}, "cells of nan m"),
        ({"x": math.inf}, "origin is"),
    ],
)
def test_a_grid_that_is_none(change, reason):
    with pytest.raises(ValueError, match=reason):
        grid_message("/map", info(**change), "map", np.zeros((2, 2), np.int8))


def test_paths_and_particles():
    path, cloud = Path(), PoseArray()
    path.header.frame_id, cloud.header.frame_id = "/odom", "map"
    for number in range(3):
        pose = PoseStamped()
        pose.pose.position.x, pose.pose.position.y = number, -2.0 * number
        path.poses.append(pose)
    path.poses[1].pose.position.x = math.nan
    head, data = unpacked(path_message("/plan", path))
    assert (head["type"], head["frame"]) == ("path", "odom")
    assert np.frombuffer(data, np.float32).tolist() == [0.0, 0.0, 2.0, -4.0]
    for number in range(2 * MAX_POSES):
        pose = Pose()
        pose.position.x, pose.orientation.z, pose.orientation.w = number, 1.0, 1.0
        cloud.poses.append(pose)
    rows = np.frombuffer(unpacked(poses_message("/cloud", cloud))[1], np.float32).reshape(-1, 3)
    assert len(rows) == MAX_POSES
    assert rows[1] == pytest.approx([2.0, 0.0, math.pi / 2])


def test_frames_are_chained_and_the_newest_transform_counts():
    frames = Frames()
    frames.add(transform("map", "odom", 1.0, 0.0, math.pi / 2))
    frames.add(transform("/odom", "base_link", 9.0, 9.0, 0.0))
    frames.add(transform("odom", "base_link", 2.0, 0.0, 0.0))
    assert frames.pose("base_link", "map") == pytest.approx((1.0, 2.0, math.pi / 2))
    assert frames.pose("base_link", "odom") == pytest.approx((2.0, 0.0, 0.0))
    assert frames.pose("odom", "base_link") is None
    frames.add(transform("base_link", "map", 0.0, 0.0, 0.0))  # a ring ends
    assert frames.pose("base_link", "nowhere") is None


def test_a_frame_is_where_a_robot_puts_it():
    seen, told = (3.0, -1.0, 2.0), (0.5, 0.25, -0.4)
    frame = anchor(seen, told)
    assert placed(frame, told) == pytest.approx(seen)
    assert placed(inverse(frame), seen) == pytest.approx(told)


TYPES = {
    "/map": "nav_msgs/OccupancyGrid",
    "/move_base/local_costmap/costmap": "nav_msgs/OccupancyGrid",
    "/a/move_base/NavfnROS/plan": "nav_msgs/Path",
    "/particlecloud": "geometry_msgs/PoseArray",
    "/scan": "sensor_msgs/LaserScan",
    "/a/move_base_simple/goal": "geometry_msgs/PoseStamped",
    "/b/move_base_simple/goal": "std_msgs/String",
}


def test_what_the_graph_has_of_navigation():
    assert layers(sorted(TYPES), TYPES) == tuple(TYPES)[:4]
    listening = {
        "/a/move_base_simple/goal": ["/a/listener", "/a/move_base"],
        "/b/move_base_simple/goal": ["/b/move_base"],
        "/c/move_base_simple/goal": [],
        "/d/move_base_simple/goal": ["/d/planner"],
        "/goal": ["/e"],
    }
    given = {"/d/planner/global_costmap/global_frame": "/d_map"}
    found = navigators(listening, TYPES, lambda name, default: given.get(name, default))
    assert found == (
        Navigator("/a/move_base_simple/goal", "/a/move_base", "map"),
        Navigator("/d/move_base_simple/goal", "/d/planner", "d_map"),
    )


@pytest.fixture
def navigation(monkeypatch):
    """A Navigation with two robots of namespaces; what it publishes is in its list `sent`."""
    places = {("base", "a"): (1.0, 2.0, 0.0), ("base", "b"): (5.0, 5.0, 0.0)}
    found = Navigation(lambda *_: None, lambda link, model: places.get((link, model)))
    found.sent = []
    monkeypatch.setattr(found, "_publish", lambda *each: found.sent.append(each))
    found.watch((Navigator("/a/move_base_simple/goal", "/a/move_base", "map"),), False)
    found.navigators += (Navigator("/b/move_base_simple/goal", "/b/move_base", "b/map"),)
    found.frames.add(transform("map", "a/base", 0.0, 0.0, math.pi / 2))
    return found


def test_a_goal_is_where_it_was_clicked(navigation):
    robot = navigation.of_model("a")
    said = navigation.send_goal(robot, (1.25, 3.0), 0.0)
    assert said == "the goal is -1.00, 0.25 in map"
    topic, kind, message = navigation.sent[0]
    assert (topic, kind, message.header.frame_id) == (robot.topic, PoseStamped, "map")
    position, orientation = message.pose.position, message.pose.orientation
    assert (position.x, position.y) == pytest.approx((-1.0, 0.25))
    assert 2 * math.asin(orientation.z) == pytest.approx(math.pi / 2)


def test_a_goal_without_a_heading_looks_away_from_the_robot(navigation):
    navigation.send_goal(navigation.of_model("a"), (0.0, 2.0), None)
    orientation = navigation.sent[0][2].pose.orientation
    yaw = 2 * math.atan2(orientation.z, orientation.w)
    assert math.remainder(yaw - 3 * math.pi / 2, 2 * math.pi) == pytest.approx(0.0, abs=1e-9)


def test_a_goal_where_no_robot_is(navigation):
    robot = navigation.of_model("b")
    assert robot.node == "/b/move_base" and navigation.of_model("other").node == "/a/move_base"
    with pytest.raises(LookupError, match="no robot of the world is in the frame 'b/map' by TF"):
        navigation.send_goal(robot, (0.0, 0.0), None)
    assert navigation.anchors(["map", "b/map"]).keys() == {"map"}


def test_the_goal_is_shown_until_it_is_cancelled(navigation):
    goal = PoseStamped()
    goal.header.frame_id, goal.pose.position.x, goal.pose.orientation.w = "map", 2.0, 1.0
    navigation._new_goal(goal)
    assert navigation.goal_in_world()[:2] == pytest.approx((1.0, 0.0))
    assert navigation.cancel(navigation.navigators[0]) == "the goal is cancelled"
    assert navigation.sent[0][0] == "/a/move_base/cancel"
    assert navigation.goal_in_world() is None
