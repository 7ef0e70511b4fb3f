"""The node marker_server."""

import rospy
from geometry_msgs.msg import Pose, Quaternion, Twist, Vector3
from interactive_markers.interactive_marker_server import InteractiveMarkerServer
from visualization_msgs.msg import InteractiveMarker, InteractiveMarkerControl

from marker_twist.drag import read
from paddock_common import nodes

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
        robot: Name of the robot.
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


def main():
    """Runs the node; returns 1 when a parameter is wrong."""
    nodes.init_interruptible("marker_server")
    try:
        drag = read(rospy.get_param("~", {}))
    except ValueError as error:
        rospy.logfatal("marker_server: %s", error)
        return 1
    publisher = rospy.Publisher("~cmd_vel", Twist, queue_size=1)
    server = InteractiveMarkerServer("twist_marker_server")
    marker = marker_of(
        str(rospy.get_param("~link_name", "base_link")),
        str(rospy.get_param("~robot_name", "robot")),
        float(rospy.get_param("~marker_size_scale", 1.0)),
        drag.linear,
    )

    def take(feedback):
        at, turned = feedback.pose.position, feedback.pose.orientation
        linear, angular = drag.velocity(
            (at.x, at.y, at.z), (turned.x, turned.y, turned.z, turned.w)
        )
        publisher.publish(Twist(Vector3(*linear), Vector3(0.0, 0.0, angular)))
        server.setPose(marker.name, Pose(orientation=Quaternion(w=1.0)))  # back to the robot
        server.applyChanges()

    server.insert(marker, take)
    server.applyChanges()
    # Nobody has moved it yet. rospy's server, unlike roscpp's, counts its start as a movement by
    # somebody else and refuses all others for a second, which does not end where the clock stands.
    server.marker_contexts[marker.name].last_feedback = rospy.Time()
    rospy.spin()
    return 0
