"""What navigation publishes, for pages: maps, costmaps, plans and particles; goals for move_base.

Their frames (map, odom) are brought into the world by a robot: a link has a pose in such a frame by
TF, and one in the world by the simulator. So a goal is where it was clicked, whatever the robot's
localization is wrong by, and a map lies beside the walls by just that.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Tuple

import cv2
import numpy as np
import roslib.message
import rospy
from actionlib_msgs.msg import GoalID
from bullet_sim.pose import Array, compose, rpy_from_quaternion
from geometry_msgs.msg import PoseArray, PoseStamped
from nav_msgs.msg import OccupancyGrid, Path
from paddock_common.geometry import pose_of
from rospy.numpy_msg import numpy_msg
from tf2_msgs.msg import TFMessage

from bullet_web.sensors import packed

Planar = Tuple[float, float, float]  # x, y [m], yaw [rad]
GRID, PATH, POSES = "nav_msgs/OccupancyGrid", "nav_msgs/Path", "geometry_msgs/PoseArray"
GOAL = "move_base_simple/goal"  # the end of the topic's name
POSE = "geometry_msgs/PoseStamped"
UPDATES = "_updates"  # behind the name of a costmap
UPDATE = "map_msgs/OccupancyGridUpdate"
PERIOD = 0.3  # [s] of wall time between two messages of a topic for pages, at least
MAX_CELLS = 2048  # of a side of a grid's image
MAX_POSES = 2000  # of an array that are shown
MAX_DEPTH = 100  # frames above one
NOWHERE = "no robot of the world is in the frame {!r} by TF: where that is, is not known"


def _palette(costmap: bool) -> Array:
    """(256, 4) uint8 blue, green, red, alpha of each value of a cell, a byte; -1 is 255.

    A map: free cells are light, occupied ones black. A costmap, as in rviz: from blue to red with
    the cost, where the robot's middle would collide (99) cyan, obstacles (100) violet.
    """
    colors = np.zeros((256, 4), np.uint8)
    share = np.arange(101) / 100.0
    if costmap:
        colors[1:101, 0] = 255 * (1.0 - share[1:])
        colors[1:101, 2] = 255 * share[1:]
        colors[1:101, 3] = 110
        colors[99], colors[100] = (255, 255, 0, 150), (255, 0, 180, 190)
    else:
        colors[:101, :3] = np.rint(255 * (1.0 - share))[:, np.newaxis]
        colors[:101, 3] = np.rint(90 + 150 * share)
    return colors


PALETTES = {costmap: _palette(costmap) for costmap in (False, True)}


def grid_message(topic: str, info: Any, frame: str, cells: Array) -> bytes:
    """What pages get of a grid: a PNG of the part that is not transparent, and where that is.

    Args:
        info: nav_msgs/MapMetaData.
        cells: (height, width) int8, the first row is that of the least y.

    Raises:
        ValueError: it has no size, or its origin is none.
    """
    place = planar(info.origin)
    if not (math.isfinite(info.resolution) and info.resolution > 0.0 and cells.size):
        raise ValueError(f"the grid has {cells.shape} cells of {info.resolution} m")
    if not all(map(math.isfinite, place)):
        raise ValueError(f"the grid's origin is {place}")
    palette = PALETTES["costmap" in topic]
    values = np.where((cells < 0) | (cells > 100), -1, cells)
    seen = palette[values.view(np.uint8), 3] > 0
    rows, columns = np.flatnonzero(seen.any(axis=1)), np.flatnonzero(seen.any(axis=0))
    if rows.size:
        part = values[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    else:
        rows = columns = np.zeros(1, int)
        part = np.full((1, 1), -1, np.int8)
    step = -(-max(part.shape) // MAX_CELLS)
    if step > 1:  # the highest value of a block, so that no wall gets lost
        pad = [(0, -size % step) for size in part.shape]
        part = np.pad(part, pad, constant_values=-1)
        height, width = part.shape
        part = part.reshape(height // step, step, width // step, step).max(axis=(1, 3))
    done, data = cv2.imencode(".png", palette[part.view(np.uint8)][::-1])
    if not done:
        raise ValueError(f"the grid of {part.shape} cells cannot be encoded")
    size = info.resolution
    head = {
        "type": "grid",
        "topic": topic,
        "frame": frame,
        "origin": place,
        "at": [columns[0] * size, rows[0] * size],
        "size": [part.shape[1] * step * size, part.shape[0] * step * size],
    }
    return packed(_plain(head), data.tobytes())


def _plain(head: dict[str, Any]) -> dict[str, Any]:
    lists = (list, tuple)
    return {n: [float(x) for x in v] if isinstance(v, lists) else v for n, v in head.items()}


def path_message(topic: str, message: Any) -> bytes:
    """What pages get of a nav_msgs/Path: (n, 2) float32 [m]."""
    places = [(p.pose.position.x, p.pose.position.y) for p in message.poses]
    return _numbers("path", topic, message, places, 2)


def poses_message(topic: str, message: Any) -> bytes:
    """What pages get of a geometry_msgs/PoseArray: (n, 3) float32 x, y [m], yaw [rad]."""
    step = max(1, -(-len(message.poses) // MAX_POSES))
    return _numbers("poses", topic, message, [planar(p) for p in message.poses[::step]], 3)


def _numbers(kind: str, topic: str, message: Any, rows: list[Any], width: int) -> bytes:
    table = np.asarray(rows, np.float32).reshape(-1, width)
    table = table[np.isfinite(table).all(axis=1)]
    head = {"type": kind, "topic": topic, "frame": message.header.frame_id.lstrip("/")}
    return packed(head, table.tobytes())


def planar(pose: Any) -> Planar:
    """x, y, yaw of a geometry_msgs/Pose, whose quaternion need not have the length 1."""
    q = pose.orientation
    return pose.position.x, pose.position.y, rpy_from_quaternion((q.x, q.y, q.z, q.w))[2]


# frames -------------------------------------------------------------------------------------------
class Frames:
    """The newest transform of each frame, whatever its stamp: time may go back by a reset."""

    def __init__(self) -> None:
        self._parents: dict[str, tuple[str, Any, Any]] = {}  # -> parent, position, quaternion

    def add(self, message: Any) -> None:
        """Take a tf2_msgs/TFMessage."""
        for stamped in message.transforms:
            t, q = stamped.transform.translation, stamped.transform.rotation
            self._parents[stamped.child_frame_id.lstrip("/")] = (
                stamped.header.frame_id.lstrip("/"),
                (t.x, t.y, t.z),
                (q.x, q.y, q.z, q.w),
            )

    def names(self) -> list[str]:
        """Frames that have a parent."""
        return list(self._parents)

    def pose(self, name: str, frame: str) -> Planar | None:
        """Pose of a frame in one above it; None: it is not below that."""
        position, orientation = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)
        for _ in range(MAX_DEPTH):
            if name == frame:
                return position[0], position[1], rpy_from_quaternion(orientation)[2]
            if name not in self._parents:
                return None
            name, offset, turn = self._parents[name]
            position, orientation = compose(offset, turn, position, orientation)
        return None


def anchor(in_world: Planar, in_frame: Planar) -> Planar:
    """Pose of a frame in the world, by a body's pose in the world and its pose in the frame."""
    yaw = in_world[2] - in_frame[2]
    x, y, _ = placed((0.0, 0.0, yaw), in_frame)
    return in_world[0] - x, in_world[1] - y, yaw


def placed(frame: Planar, place: Planar) -> Planar:
    """A pose in a frame that has a pose, in that one's parent."""
    cosine, sine = math.cos(frame[2]), math.sin(frame[2])
    return (
        frame[0] + cosine * place[0] - sine * place[1],
        frame[1] + sine * place[0] + cosine * place[1],
        frame[2] + place[2],
    )


def inverse(frame: Planar) -> Planar:
    """Pose of the parent in a frame that has a pose."""
    return anchor((0.0, 0.0, 0.0), frame)


# the ROS graph ------------------------------------------------------------------------------------
@dataclass(frozen=True)
class Navigator:
    """A node that takes goals as move_base does.

    Attributes:
        topic: of its goals.
        node: its name.
        frame: in which it navigates.
    """

    topic: str
    node: str
    frame: str


def navigators(
    listening: Mapping[str, list[str]], types: Mapping[str, str], get_param: Callable[..., Any]
) -> tuple[Navigator, ...]:
    """Those of the ROS graph.

    Args:
        listening: topic -> nodes that subscribe to it.
        types: topic -> type.
    """
    result = []
    for topic, nodes in sorted(listening.items()):
        if nodes and topic.endswith(f"/{GOAL}") and types.get(topic, POSE) == POSE:
            node = min(nodes, key=lambda name: (not name.endswith("move_base"), name))
            frame = str(get_param(f"{node}/global_costmap/global_frame", "map")).lstrip("/")
            result.append(Navigator(topic, node, frame))
    return tuple(result)


def layers(sent: Iterable[str], types: Mapping[str, str]) -> tuple[str, ...]:
    """Topics that pages can show: maps first, then costmaps, plans, arrays of poses."""
    order = {GRID: 0, PATH: 2, POSES: 3}
    ordered = [
        (order[types[topic]] + ("costmap" in topic), topic)
        for topic in sent
        if types.get(topic) in order
    ]
    return tuple(topic for _, topic in sorted(ordered))


# subscriptions ------------------------------------------------------------------------------------
class Layer:
    """One topic that pages want.

    Args:
        deliver: called with the topic and its message for pages, in threads of rospy.
    """

    def __init__(self, topic: str, kind: str, deliver: Callable[[str, bytes], object]) -> None:
        self.topic, self.last = topic, b""  # for pages that come later
        self._kind, self._deliver = kind, deliver
        self._lock = threading.Lock()
        self._message: Any = None  # the newest
        self.frame = ""  # of it
        self._cells: Array | None = None
        self._due, self._at, self._problem = False, -math.inf, ""
        classes = {GRID: numpy_msg(OccupancyGrid), PATH: Path, POSES: PoseArray}
        self._subscribers = [
            rospy.Subscriber(topic, classes[kind], self._receive, queue_size=1, buff_size=1 << 24)
        ]
        update = roslib.message.get_message_class(UPDATE) if kind == GRID else None
        if update is not None:
            self._subscribers.append(
                rospy.Subscriber(topic + UPDATES, numpy_msg(update), self._update, queue_size=10)
            )

    def _receive(self, message: Any) -> None:
        with self._lock:
            self._message, self.frame = message, message.header.frame_id.lstrip("/")
            if self._kind == GRID:
                shape = message.info.height, message.info.width
                fits = len(message.data) == shape[0] * shape[1]
                self._cells = np.array(message.data, np.int8).reshape(shape) if fits else None
            self._due = True
        self.flush()

    def _update(self, message: Any) -> None:
        with self._lock:
            x, y, width, height = message.x, message.y, message.width, message.height
            if self._cells is None or x < 0 or y < 0 or len(message.data) != width * height:
                return
            part = self._cells[y : y + height, x : x + width]
            if part.shape == (height, width):
                part[:] = np.asarray(message.data, np.int8).reshape(part.shape)
                self._due = True
        self.flush()

    def flush(self) -> None:
        """Deliver what has come, unless something was delivered just before."""
        with self._lock:
            if not self._due or time.monotonic() - self._at < PERIOD:
                return
            self._due, self._at = False, time.monotonic()
            try:
                self.last = self._convert()
            except ValueError as error:
                if str(error) != self._problem:  # once
                    self._problem = str(error)
                    rospy.logwarn("%s cannot be shown: %s", self.topic, error)
                return
        self._deliver(self.topic, self.last)

    def _convert(self) -> bytes:
        message = self._message
        if self._kind == PATH:
            return path_message(self.topic, message)
        if self._kind == POSES:
            return poses_message(self.topic, message)
        if self._cells is None:
            info = message.info
            raise ValueError(f"{len(message.data)} cells are not {info.height} x {info.width}")
        return grid_message(self.topic, message.info, self.frame, self._cells)

    def close(self) -> None:
        """Unsubscribe."""
        for subscriber in self._subscribers:
            subscriber.unregister()


class Navigation:
    """Layers, frames and goals of one node.

    Args:
        deliver: called with a topic and its message for pages, in threads of rospy.
        link_pose: function from a link's and perhaps its model's name to its x, y, yaw in the
            world, or None.
    """

    def __init__(
        self,
        deliver: Callable[[str, bytes], object],
        link_pose: Callable[[str, str], Planar | None],
    ) -> None:
        self._deliver, self._link_pose = deliver, link_pose
        self.frames = Frames()
        self.navigators: tuple[Navigator, ...] = ()
        self.goal: tuple[str, Planar] | None = None  # the last one, in its frame
        self._layers: dict[str, Layer] = {}
        self._tf: list[Any] = []
        self._goals: dict[str, Any] = {}
        self._publishers: dict[tuple[str, Any], Any] = {}

    # what pages see
    def set_wanted(self, wanted: Mapping[str, str]) -> None:
        """Subscribe to these topics with their types, and to no others."""
        for topic in set(self._layers) - set(wanted):
            self._layers.pop(topic).close()
        for topic in sorted(set(wanted) - set(self._layers)):
            self._layers[topic] = Layer(topic, wanted[topic], self._deliver)

    def last(self, topic: str) -> bytes:
        """What was delivered last of a topic; empty: nothing."""
        return self._layers[topic].last if topic in self._layers else b""

    def flush(self) -> None:
        """Deliver what came while it was too early."""
        for layer in list(self._layers.values()):
            layer.flush()

    def layer_frames(self) -> set[str]:
        """Frames of what was delivered."""
        return {layer.frame for layer in self._layers.values() if layer.frame}

    def watch(self, navigators: tuple[Navigator, ...], looking: bool) -> None:
        """Follow TF and the goals, or do not.

        Args:
            navigators: those that take goals.
            looking: whether somebody looks.
        """
        self.navigators = navigators
        if looking and not self._tf:
            self._tf = [
                rospy.Subscriber(topic, TFMessage, self.frames.add, queue_size=100)
                for topic in ("/tf", "/tf_static")
            ]
        elif not looking and self._tf:
            for subscriber in self._tf:
                subscriber.unregister()
            self._tf = []
        topics = {f"{node.node}/current_goal" for node in navigators} if looking else set()
        for topic in set(self._goals) - topics:
            self._goals.pop(topic).unregister()
        for topic in topics - set(self._goals):
            self._goals[topic] = rospy.Subscriber(topic, PoseStamped, self._new_goal, queue_size=1)

    def _new_goal(self, message: Any) -> None:
        self.goal = message.header.frame_id.lstrip("/"), planar(message.pose)

    def _robot(self, frame: str) -> tuple[Planar, Planar] | None:
        """Poses of the first robot that is in a frame: in the world and in the frame."""
        for name in self.frames.names():
            model, _, link = name.rpartition("/")
            in_world = self._link_pose(link, model)
            in_frame = None if in_world is None else self.frames.pose(name, frame)
            if in_world is not None and in_frame is not None:
                return in_world, in_frame
        return None

    def anchor(self, frame: str) -> Planar | None:
        """Pose of a frame in the world, by the first robot that is in it; None: there is none."""
        robot = self._robot(frame)
        return robot and anchor(*robot)

    def anchors(self, frames: Iterable[str]) -> dict[str, Planar]:
        """Of each frame whose place is known its pose in the world."""
        poses = {frame: self.anchor(frame) for frame in frames}
        return {frame: pose for frame, pose in poses.items() if pose is not None}

    def goal_in_world(self) -> Planar | None:
        """The last goal; None: there is none, or its frame is nowhere."""
        frame = self.anchor(self.goal[0]) if self.goal else None
        return placed(frame, self.goal[1]) if self.goal and frame else None

    # what pages do
    def of_model(self, model: str) -> Navigator | None:
        """The one in the namespace of a model, or the first; None: there is none."""
        named = [node for node in self.navigators if f"/{model}/" in node.topic]
        return next(iter(named or self.navigators), None)

    def send_goal(self, navigator: Navigator, place: tuple[float, float], yaw: float | None) -> str:
        """Publish a goal.

        Args:
            place: in the world [m].
            yaw: in the world [rad]; None: as seen from the robot.

        Raises:
            LookupError: where the navigator's frame is, is not known.
        """
        robot = self._robot(navigator.frame)
        if robot is None:
            raise LookupError(NOWHERE.format(navigator.frame))
        if yaw is None:
            yaw = math.atan2(place[1] - robot[0][1], place[0] - robot[0][0])
        x, y, turn = placed(inverse(anchor(*robot)), (*place, yaw))
        message = PoseStamped(pose=pose_of(x, y, turn))
        message.header.frame_id = navigator.frame
        self._publish(navigator.topic, PoseStamped, message)
        return f"the goal is {x:.2f}, {y:.2f} in {navigator.frame}"

    def cancel(self, navigator: Navigator) -> str:
        """Cancel its goals."""
        self._publish(f"{navigator.node}/cancel", GoalID, GoalID())
        self.goal = None
        return "the goal is cancelled"

    def _publish(self, topic: str, kind: Any, message: Any) -> None:
        key = topic, kind
        if key not in self._publishers:
            self._publishers[key] = rospy.Publisher(topic, kind, queue_size=1)
            end = time.monotonic() + 2.0  # [s] for the first connection
            while not self._publishers[key].get_num_connections() and time.monotonic() < end:
                time.sleep(0.02)
        self._publishers[key].publish(message)

    def close(self) -> None:
        """Subscribe to nothing."""
        self.set_wanted({})
        self.watch((), False)
