"""What pages do to the world: the services of the simulator behind each action."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from typing import Any
from xml.etree import ElementTree

import roslib.message
import rospy
from bullet_sim.pose import rpy_from_quaternion
from gazebo_msgs.msg import ModelState
from gazebo_msgs.srv import (
    DeleteModel,
    GetPhysicsProperties,
    SetModelState,
    SetPhysicsProperties,
    SpawnModel,
)
from nav_msgs.msg import Odometry
from paddock_common.geometry import pose_of
from std_srvs.srv import Empty, Trigger

from bullet_web.navigation import Navigation, Navigator, Planar, anchor, placed, planar

TIMEOUT = 2.0  # [s] for a service to be there, and for an odometry
ODOMETRY = "/odom"  # in whose frame goals are
CLEARANCE = 0.05  # [m] above what was clicked
UPRIGHT = math.radians(10.0)  # a model that leans less keeps its height
DESCRIPTION = "/robot_description"  # of the robot that "car" copies
# Size [m], mass [kg]; moments are those of homogeneous bodies.
BOX = """<sdf version="1.6"><model name="box"><link name="link">
  <inertial><mass>0.5</mass><inertia><ixx>0.0033</ixx><iyy>0.0033</iyy><izz>0.0033</izz>
    <ixy>0</ixy><ixz>0</ixz><iyz>0</iyz></inertia></inertial>
  <pose>0 0 0.1 0 0 0</pose>
  <collision name="c"><geometry><box><size>0.2 0.2 0.2</size></box></geometry></collision>
  <visual name="v"><geometry><box><size>0.2 0.2 0.2</size></box></geometry>
    <material><ambient>0.55 0.38 0.2 1</ambient><diffuse>0.55 0.38 0.2 1</diffuse></material>
  </visual>
</link></model></sdf>"""
CONE_PARTS = (  # radius, height, middle above the ground [m], color
    (0.085, 0.012, 0.006, "0.08 0.08 0.08 1"),
    (0.062, 0.05, 0.037, "0.95 0.35 0.05 1"),
    (0.047, 0.05, 0.087, "0.95 0.95 0.95 1"),
    (0.032, 0.05, 0.137, "0.95 0.35 0.05 1"),
    (0.018, 0.05, 0.187, "0.95 0.35 0.05 1"),
)


class ActionError(Exception):
    """An action that the simulator refuses; the text is for the page."""


def cone() -> str:
    """SDF of a traffic cone of five discs, 0.3 kg."""
    parts = "".join(
        f"<{tag} name='{tag}{index}'><pose>0 0 {middle} 0 0 0</pose><geometry><cylinder>"
        f"<radius>{radius}</radius><length>{height}</length></cylinder></geometry>"
        + (
            f"<material><ambient>{color}</ambient><diffuse>{color}</diffuse></material>"
            if tag == "visual"
            else ""
        )
        + f"</{tag}>"
        for index, (radius, height, middle, color) in enumerate(CONE_PARTS)
        for tag in ("collision", "visual")
    )
    return (
        '<sdf version="1.6"><model name="cone"><link name="link"><inertial><pose>0 0 0.05 0 0 0'
        "</pose><mass>0.3</mass><inertia><ixx>0.0011</ixx><iyy>0.0011</iyy><izz>0.0006</izz>"
        f"<ixy>0</ixy><ixz>0</ixz><iyz>0</iyz></inertia></inertial>{parts}</link></model></sdf>"
    )


def parked(text: str) -> str:
    """URDF without sensors, plugins and transmissions: the robot as an obstacle.

    Raises:
        ActionError: it is no XML.
    """
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise ActionError(f"{DESCRIPTION} is no XML: {error}") from error
    for child in list(root):
        if child.tag == "transmission":
            root.remove(child)
        for tag in ("plugin", "sensor") if child.tag == "gazebo" else ():
            for part in child.findall(tag):
                child.remove(part)
    return ElementTree.tostring(root, encoding="unicode")


def free_name(kind: str, taken: Collection[str]) -> str:
    """KIND_1, or the first that no model has."""
    number = 1
    while f"{kind}_{number}" in taken:
        number += 1
    return f"{kind}_{number}"


class Actions:
    """Executes actions; blocks, so it is used in a thread of its own.

    Args:
        names: function that lists the models.
        pose: function from a model's name to its position and quaternion, or None.
        link_pose: function from a link's name to its x, y, yaw in the world, or None.
        navigation: what takes goals as move_base does; None: nothing.

    Attributes:
        goal: the last goal: x, y in the frame of the odometry, and x, y in the world; or None.
    """

    def __init__(
        self,
        names: Callable[[], Collection[str]],
        pose: Callable[[str], list[float] | None],
        link_pose: Callable[[str], Planar | None],
        navigation: Navigation | None = None,
    ) -> None:
        self._names, self._pose, self._link_pose = names, pose, link_pose
        self._navigation = navigation
        self.goal: tuple[tuple[float, float], tuple[float, float]] | None = None

    def execute(self, message: dict[str, Any]) -> str:
        """Do what a checked message "do" asks for.

        Returns:
            What was done, for its page; empty: it is to be seen.

        Raises:
            ActionError: it cannot be done.
        """
        action = getattr(self, f"_{message['action']}")
        try:
            return action(message) or ""
        except (rospy.ROSException, rospy.ServiceException) as error:
            raise ActionError(f"{message['action']}: {error}") from error
        except ActionError as error:  # texts of gazebo_ros, such as "model does not exist"
            model = repr(message.get("model"))
            if "model" not in message or model in str(error):
                raise
            raise ActionError(f"{message['action']} {model}: {error}") from error

    @staticmethod
    def _call(name: str, kind: Any, *arguments: Any, **fields: Any) -> Any:
        rospy.wait_for_service(name, TIMEOUT)
        response = rospy.ServiceProxy(name, kind)(*arguments, **fields)
        if not getattr(response, "success", True):
            text = getattr(response, "status_message", "") or getattr(response, "message", "")
            raise ActionError(text or f"{name} has refused; its reason is in the log")
        return response

    def _pause(self, _: dict[str, Any]) -> None:
        self._call("/gazebo/pause_physics", Empty)

    def _resume(self, _: dict[str, Any]) -> None:
        self._call("/gazebo/unpause_physics", Empty)

    def _reset(self, _: dict[str, Any]) -> None:
        self._call("/gazebo/restart", Empty)

    def _step(self, message: dict[str, Any]) -> None:
        self._pause(message)
        kind = roslib.message.get_service_class("bullet_bridge/Step")
        self._call("/gazebo/step", kind, message["count"], [], [])

    def _pace(self, message: dict[str, Any]) -> None:
        now = self._call("/gazebo/get_physics_properties", GetPhysicsProperties)
        rate = message["factor"] / now.time_step
        self._call(
            "/gazebo/set_physics_properties",
            SetPhysicsProperties,
            now.time_step,
            rate,
            now.gravity,
            now.ode_config,
        )

    def _place(self, message: dict[str, Any]) -> str:
        name = message["model"]
        present = self._pose(name)
        if present is None:
            raise ActionError(f"model is {name!r}, which is none that can move")
        roll, pitch, yaw = rpy_from_quaternion(present[3:])
        height = message["z"] + CLEARANCE
        if abs(roll) < UPRIGHT and abs(pitch) < UPRIGHT:
            height = max(height, present[2])
        state = ModelState(model_name=name)
        state.pose = pose_of(message["x"], message["y"], message.get("yaw", yaw), height)
        self._call("/gazebo/set_model_state", SetModelState, state)
        return f"{name} is put at {message['x']:.2f}, {message['y']:.2f}"

    def _spawn(self, message: dict[str, Any]) -> str:
        kind = message["kind"]
        name = free_name(kind, self._names())
        height = message["z"] + CLEARANCE
        where = (message["x"], message["y"], message.get("yaw", 0.0), height)
        if kind == "car":
            if not rospy.has_param(DESCRIPTION):
                raise ActionError(f"there is no robot to copy: {DESCRIPTION} is not set")
            service, text = "spawn_urdf_model", parked(str(rospy.get_param(DESCRIPTION)))
        else:
            service, text = "spawn_sdf_model", BOX if kind == "box" else cone()
        self._call(
            f"/gazebo/{service}",
            SpawnModel,
            model_name=name,
            model_xml=text,
            robot_namespace=name,
            initial_pose=pose_of(*where),
            reference_frame="",
        )
        return f"{name} is there"

    def _remove(self, message: dict[str, Any]) -> str:
        self._call("/gazebo/delete_model", DeleteModel, message["model"])
        return f"{message['model']} is removed"

    def _navigator(self, message: dict[str, Any]) -> Navigator | None:
        navigation = self._navigation
        return None if navigation is None else navigation.of_model(message.get("model", ""))

    def _goal(self, message: dict[str, Any]) -> str:
        navigator = self._navigator(message)
        if navigator is not None and self._navigation is not None:
            place = message["x"], message["y"]
            try:
                return self._navigation.send_goal(navigator, place, message.get("yaw"))
            except LookupError as error:
                raise ActionError(str(error)) from error
        return self._goal_of_truck(message)

    def _goal_of_truck(self, message: dict[str, Any]) -> str:
        kind = roslib.message.get_service_class("cybertruck/Goal")
        if kind is None:
            raise ActionError("the package cybertruck is not there")
        place = message["x"], message["y"]
        try:
            odometry = rospy.wait_for_message(ODOMETRY, Odometry, TIMEOUT)
        except rospy.ROSException as error:
            raise ActionError(f"the goal is in the frame of {ODOMETRY}, which is silent") from error
        request = kind._request_class()
        goal = self._in_odometry(place, odometry)
        request.pose = pose_of(*goal, message.get("yaw", 0.0))
        self.goal = goal, place
        self._call("/goal", kind, request)
        return f"the goal is {place[0]:.2f}, {place[1]:.2f}"

    def _in_odometry(self, place: tuple[float, float], message: Any) -> tuple[float, float]:
        """A place of the world in the frame of an odometry, which drifts and is not moved along
        when its model is put elsewhere."""
        link = message.child_frame_id.rpartition("/")[2]
        here = self._link_pose(link)
        if here is None:
            return place
        world = anchor(planar(message.pose.pose), here)
        return placed(world, (*place, 0.0))[:2]

    def _cancel(self, message: dict[str, Any]) -> str:
        navigator = self._navigator(message)
        if navigator is not None and self._navigation is not None:
            return self._navigation.cancel(navigator)
        self._call("/goal/cancel", Trigger)
        return "the goal is cancelled"
