"""Interactive markers that are dragged: their twist, and the node."""

from dataclasses import dataclass

import rospy
from geometry_msgs.msg import Pose, Quaternion, Twist, Vector3
from interactive_markers.interactive_marker_server import InteractiveMarkerServer
from paddock_common.geometry import yaw_of
from paddock_common.settings import Number
from visualization_msgs.msg import InteractiveMarker, InteractiveMarkerControl

from paddock_common import nodes

AXES = ("x", "y", "z")
NUMBER = Number()


@dataclass(frozen=True)
class Scale:
    """One direction.

    Attributes:
        factor: Speed for each meter or radian that the marker was dragged [1/s].
        lowest: Smallest speed, below 0 [m/s or rad/s].
        highest: Largest speed [m/s or rad/s].
    """

    factor: float
    lowest: float
    highest: float

    def speed(self, displacement):
        """Speed of a displacement [m or rad]."""
        return max(min(self.factor * displacement, self.highest), self.lowest)


@dataclass(frozen=True)
class Drag:
    """Scales of all directions.

    Attributes:
        linear: Dict of x, y, z -> Scale; the marker has no arrows for what is missing.
        angular: Scale of the rotation.
    """

    linear: dict
    angular: Scale

    def velocity(self, position, orientation):
        """Velocity of a dragged marker.

        Args:
            position: (x, y, z) in the robot's frame [m].
            orientation: geometry_msgs/Quaternion.

        Returns:
            ((x, y, z) [m/s], yaw rate [rad/s]).
        """
        speeds = tuple(
            self.linear[name].speed(displacement) if name in self.linear else 0.0
            for name, displacement in zip(AXES, position)
        )
        return speeds, self.angular.speed(yaw_of(orientation))


def read(parameters):
    """Reads the parameters.

    Args:
        parameters: Dict of linear_scale, max_positive_linear_velocity,
            max_negative_linear_velocity (numbers for x alone, or maps of x, y, z), angular_scale,
            max_angular_velocity.

    Raises:
        ValueError: Names the parameter, its value and what is valid.
    """
    scale = parameters.get("linear_scale", 1.0)
    factors = scale if isinstance(scale, dict) else {"x": scale}
    unknown = sorted(set(map(str, factors)) - set(AXES))
    if unknown:
        raise ValueError(f"linear_scale names {', '.join(unknown)}, must be of {', '.join(AXES)}")
    limits = []
    for key, default in (
        ("max_negative_linear_velocity", -1.0),
        ("max_positive_linear_velocity", 1.0),
    ):
        value = parameters.get(key, dict.fromkeys(factors, default))
        if not isinstance(value, dict):
            if isinstance(scale, dict):
                raise ValueError(f"{key} is {value!r}, must be a map as linear_scale is")
            value = {"x": value}
        limits.append({name: NUMBER.check(key, value.get(name, 0.0)) for name in factors})
    linear = {
        name: Scale(NUMBER.check("linear_scale", factor), limits[0][name], limits[1][name])
        for name, factor in factors.items()
    }
    fastest = NUMBER.check("max_angular_velocity", parameters.get("max_angular_velocity", 2.2))
    factor = NUMBER.check("angular_scale", parameters.get("angular_scale", 2.2))
    return Drag(linear, Scale(factor, -fastest, fastest))


HALF = 0.5**0.5
# A control acts along, or about, the x axis of its orientation.
ORIENTATIONS = {
    "x": Quaternion(HALF, 0.0, 0.0, HALF),
    "y": Quaternion(0.0, 0.0, HALF, HALF),
    "z": Quaternion(0.0, HALF, 0.0, HALF),
}


def marker_of(link, robot, size, axes):
    """The marker with one pair of arrows for each axis, and a ring.

    Args:
        link: Frame that it hangs in.
        size: Of the marker [m].
        axes: Of x, y, z.
    """
    marker = InteractiveMarker(name=f"{robot}_twist_marker", scale=size)
    marker.header.frame_id = link
    marker.description = f"twist controller for {robot}"
    marker.pose.orientation.w = 1.0
    for name in sorted(axes):
        control = _control(f"move_{name}", name)
        control.interaction_mode = InteractiveMarkerControl.MOVE_AXIS
        marker.controls.append(control)
    ring = _control("rotate_z", "z")
    ring.interaction_mode = InteractiveMarkerControl.ROTATE_AXIS
    marker.controls.append(ring)
    return marker


def _control(name, axis):
    return InteractiveMarkerControl(
        name=name,
        orientation=ORIENTATIONS[axis],
        orientation_mode=InteractiveMarkerControl.FIXED,
    )


def connect():
    """Connects the node.

    Raises:
        ValueError: A parameter is wrong.
    """
    drag = read(rospy.get_param("~", {}))
    publisher = rospy.Publisher("~cmd_vel", Twist, queue_size=1)
    server = InteractiveMarkerServer("twist_marker_server")
    marker = marker_of(
        str(rospy.get_param("~link_name", "base_link")),
        str(rospy.get_param("~robot_name", "robot")),
        float(rospy.get_param("~marker_size_scale", 1.0)),
        drag.linear,
    )

    def publish_twist(feedback):
        at = feedback.pose.position
        linear, angular = drag.velocity((at.x, at.y, at.z), feedback.pose.orientation)
        publisher.publish(Twist(Vector3(*linear), Vector3(0.0, 0.0, angular)))
        server.setPose(marker.name, Pose(orientation=Quaternion(w=1.0)))  # back to the robot
        server.applyChanges()

    server.insert(marker, publish_twist)
    server.applyChanges()
    # Nobody has moved it yet. rospy's server, unlike roscpp's, counts its start as a movement by
    # somebody else and refuses all others for a second, which does not end where the clock stands.
    server.marker_contexts[marker.name].last_feedback = rospy.Time()


def main():
    nodes.run("marker_server", connect)
