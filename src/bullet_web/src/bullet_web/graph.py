"""What the ROS graph has for pages: topics to drive, cameras, lidars, navigation, goals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import rosgraph
import rospy

from bullet_web.driving import Drive, drive_of
from bullet_web.navigation import Navigator, layers, navigators

TWIST = "geometry_msgs/Twist"
IMAGE = "sensor_msgs/Image"
POINTS = ("sensor_msgs/LaserScan", "sensor_msgs/PointCloud2", "sensor_msgs/Range")
GOAL = "/goal"
STANDARD = "/cmd_vel"  # the topic that comes first


@dataclass(frozen=True)
class Graph:
    """What there is.

    Attributes:
        cameras, lidars: names of topics; lidars are all that measure points.
        layers: topics with maps, costmaps, plans and arrays of poses.
        types: of these topics.
        goal: whether there is a service that takes goals.
        navigators: nodes that take them as move_base does.
    """

    drives: tuple[Drive, ...] = ()
    cameras: tuple[str, ...] = ()
    lidars: tuple[str, ...] = ()
    layers: tuple[str, ...] = ()
    types: Mapping[str, str] = field(default_factory=dict)
    goal: bool = False
    navigators: tuple[Navigator, ...] = ()
    referee: bool = field(default=False)


def look(caller: str) -> Graph:
    """Ask the master.

    Args:
        caller: name of this node, which is no subscriber that counts.

    Raises:
        OSError, rosgraph.MasterException: it does not answer.
    """
    master = rosgraph.Master(caller)
    publishers, subscribers, services = master.getSystemState()
    types = dict(master.getTopicTypes())
    listening = {topic: [name for name in nodes if name != caller] for topic, nodes in subscribers}
    sent = [topic for topic, _ in publishers]
    drives = [
        drive_of(topic, _parameters(nodes))
        for topic, nodes in sorted(listening.items(), key=lambda item: (item[0] != STANDARD, item))
        if nodes and types.get(topic) == TWIST
    ]
    shown = layers(sent, types)
    return Graph(
        tuple(drives),
        _of_type(sent, types, (IMAGE,)),
        _of_type(sent, types, POINTS),
        shown,
        {
            topic: types[topic]
            for topic in sent
            if types.get(topic) in (IMAGE, *POINTS) or topic in shown
        },
        GOAL in {name for name, _ in services},
        navigators(listening, types, rospy.get_param),
        types.get("/referee/status") == "track_model/LapStatus",
    )


def _of_type(
    topics: Sequence[str], types: dict[str, str], wanted: Sequence[str]
) -> tuple[str, ...]:
    return tuple(sorted(topic for topic in topics if types.get(topic) in wanted))


def _parameters(nodes: Sequence[str]) -> dict[str, Any]:
    """Private parameters of the first of some nodes that has any."""
    for node in nodes:
        values = rospy.get_param(node, {})
        if isinstance(values, dict) and values:
            return values
    return {}
