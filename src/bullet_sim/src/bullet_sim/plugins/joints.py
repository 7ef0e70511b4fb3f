"""Joint control and states: what plugins do to single joints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from bullet_sim.description.model import DEFAULT_SIM_TYPE, MOVABLE_TYPES, STEER_BOT_SIM_TYPE, Mimic
from bullet_sim.errors import SimError
from bullet_sim.parts.base import Acting, Sensor, part_of
from bullet_sim.parts.outputs import JointStatesOutput
from bullet_sim.plugins.registry import model_plugin
from bullet_sim.plugins.rules import MODEL, ROOT, Rule
from bullet_sim.plugins.spec import PluginSpec, number, read, reading, topic_of
from bullet_sim.plugins.xml import PluginXml, Values


@dataclass(frozen=True)
class JointStatesSpec(PluginSpec):
    """libgazebo_ros_joint_state_publisher: positions and velocities of named joints.

    As upstream it has no efforts.
    """

    NAME = "joint_states"
    joints: tuple[str, ...]
    rate: float = number("updateRate", 100.0)
    topic: str = reading(lambda xml: xml.names.topic("joint_states"), "/joint_states")
    frame_id: str = ""


@model_plugin("gazebo_ros_joint_pose_trajectory")
@dataclass(frozen=True)
class JointPosesSpec(PluginSpec):
    """libgazebo_ros_joint_pose_trajectory: sets joint positions to the points of a trajectory."""

    NAME = "joint_pose_trajectory"
    rate: float = 0.0
    topic: str = topic_of("topicName", "set_joint_trajectory")


@dataclass(frozen=True)
class MimicPidSpec(PluginSpec):
    """<hasPID> of a mimic plugin: its joint follows by a PID's effort.

    Attributes:
        joint: that follows.
        topic: name of the parameters of its gains.
    """

    NAME = "mimic_joint"
    joint: str
    topic: str


@model_plugin("gazebo_ros_control", rule=Rule(MODEL, ROOT))
def control(xml: PluginXml) -> None:
    """Namespace, period and hardware layer of a model's controllers."""
    model, known = xml.model, (DEFAULT_SIM_TYPE, STEER_BOT_SIM_TYPE)
    model.control_namespace = f"/{xml.names.namespace}"
    model.control_period = Values(xml.element, "gazebo_ros_control").number("controlPeriod")
    model.emergency_stop = xml.text("eStopTopic")
    model.robot_param = xml.text("robotParam", "robot_description")
    sim_type = xml.text("robotSimType", DEFAULT_SIM_TYPE).replace("::", "/")
    if sim_type not in known:
        xml.warn(
            f"gazebo_ros_control has robotSimType '{sim_type}', known are {' and '.join(known)}; "
            "the first is used"
        )
    model.robot_sim_type = sim_type if sim_type in known else DEFAULT_SIM_TYPE


@model_plugin("gazebo_ros_joint_state_publisher", rule=Rule(MODEL, MODEL))
def joint_states(xml: PluginXml) -> JointStatesSpec | None:
    """JointStatesSpec; without <jointName> its messages are empty, as upstream's."""
    if xml.element.find("jointName") is None:
        xml.warn(f"{xml.label} has no jointName; its messages are empty, as in Gazebo")
        return read(JointStatesSpec, xml, joints=())
    named = [name.strip() for name in xml.text("jointName").replace(" ", "").split(",")]
    joints = movable(xml, [xml.in_scope(name) for name in named if name])
    return read(JointStatesSpec, xml, joints=joints) if joints else None


@model_plugin(
    "roboticsgroup_gazebo_mimic_joint_plugin", "roboticsgroup_upatras_gazebo_mimic_joint_plugin"
)
def mimic_joint(xml: PluginXml) -> MimicPidSpec | None:
    """A joint's Mimic, and with <hasPID> where its gains are, which need ROS."""
    leader, follower = (xml.in_scope(xml.text(tag)) for tag in ("joint", "mimicJoint"))
    if len(movable(xml, (leader, follower))) < 2:
        return None
    effort = xml.number("maxEffort", -1.0)
    xml.model.joints[follower].mimic = Mimic(
        leader,
        xml.number("multiplier", 1.0),
        xml.number("offset"),
        effort if effort >= 0.0 else None,
        abs(xml.number("sensitiveness")),
    )
    if xml.element.find("hasPID") is None:
        return None
    own = f"gazebo_ros_control/pid_gains/{xml.text('mimicJoint')}"
    where, child = xml.topic("hasPID", own), xml.model.joints[follower].child
    return read(MimicPidSpec, xml, link=child, joint=follower, topic=where)


def movable(xml: PluginXml, names: Sequence[str]) -> tuple[str, ...]:
    """Those of the named joints that can move; one warning for the others."""
    movable = [name for name, joint in xml.model.joints.items() if joint.kind in MOVABLE_TYPES]
    missing = [name for name in names if name not in movable]
    if missing or not names:
        xml.warn(
            f"{xml.label} names joints {', '.join(missing) or '(none)'}, which do not exist or "
            f"do not move; movable joints are {', '.join(movable) or '(none)'}",
            "plugins name joints that do not exist and are left out",
            xml.label,
        )
    return tuple(name for name in names if name in movable)


@part_of(JointStatesSpec)
class JointStatesSensor(Sensor):
    """sensor_msgs/JointState of the named joints, without efforts."""

    watches = True

    def make_output(self) -> JointStatesOutput:
        names = self.spec.joints
        self._indices = [self.model.joints.names.index(name) for name in names]
        return JointStatesOutput(self.spec.topic, names, ("position", "velocity"))

    def measure(self, time: float) -> Any:
        return self.model.joints.columns(self._indices)[:2]


@part_of(JointPosesSpec)
class JointPosesPlugin(Acting):
    """Puts joints to the points of a trajectory_msgs/JointTrajectory, one after the other.

    As upstream, each point waits for the time_from_start of the point before it, counted from then,
    and a trajectory whose frame_id is neither the world nor a link is refused.
    """

    STATE = ("_points", "_next")
    COMMANDS = {"topic": ("trajectory_msgs/JointTrajectory", "_on_trajectory")}

    def __init__(self, context: Any) -> None:
        super().__init__(context)
        self._points: list[tuple[dict[str, float], float]] = []
        self._next = 0.0

    def reset(self, time: float) -> None:
        """Without a trajectory."""
        super().reset(time)
        self._points, self._next = [], 0.0

    def needs_update(self) -> bool:
        """While there are points to come."""
        return bool(self._points)

    def _on_trajectory(self, message: Any) -> None:
        known, topic = set(self.model.joints.names), self.spec.topic
        points = []
        frame = message.header.frame_id
        if frame not in ("world", "map", "/map") and not self._is_link(frame):
            self.log_error(f"{topic}: frame_id '{frame}' is neither world nor map nor a link")
            return
        for point in message.points:
            values = dict(zip(message.joint_names, point.positions))
            if len(point.positions) < len(message.joint_names):
                has, wanted = len(point.positions), len(message.joint_names)
                self.log_error(f"{topic}: a point has {has} positions, must have {wanted}")
                return
            mine = {name: value for name, value in values.items() if name in known}
            points.append((mine, point.time_from_start.to_sec()))
        self._next = max(message.header.stamp.to_sec(), self.world.time)
        self._points = points

    def _is_link(self, frame: str) -> bool:
        """Whether a frame is the name of one of the model's links, MODEL::LINK or LINK."""
        name = self.model.name
        return any(frame in (link, f"{name}::{link}") for link in self.model.rigid_parts)

    def update(self, time: float, period: float) -> None:
        if not self._points or time < self._next:
            return
        values, wait = self._points.pop(0)
        try:
            self.model.joints.set_positions(values)
        except SimError as error:
            self.log_error(f"{self.spec.topic}: {error}")
        self._next += wait
