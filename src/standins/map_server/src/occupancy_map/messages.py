"""Maps as messages."""

import math

import numpy as np
import rospy
from geometry_msgs.msg import Point, Pose, Quaternion
from nav_msgs.msg import MapMetaData, OccupancyGrid

from occupancy_map.files import Map


def to_message(grid, frame, stamp):
    """nav_msgs/OccupancyGrid of a Map."""
    x, y, yaw = grid.origin
    message = OccupancyGrid()
    message.header.frame_id, message.header.stamp = frame, stamp
    message.info = MapMetaData(
        map_load_time=stamp,
        resolution=grid.resolution,
        width=grid.cells.shape[1],
        height=grid.cells.shape[0],
        origin=Pose(
            Point(x, y, 0.0),
            Quaternion(0.0, 0.0, math.sin(yaw / 2.0), math.cos(yaw / 2.0)),
        ),
    )
    message.data = grid.cells.ravel().tolist()
    return message


def from_message(message):
    """Map of a nav_msgs/OccupancyGrid."""
    info, turned = message.info, message.info.origin.orientation
    yaw = math.atan2(
        2.0 * (turned.w * turned.z + turned.x * turned.y),
        1.0 - 2.0 * (turned.y**2 + turned.z**2),
    )
    cells = np.array(message.data, np.int8).reshape(info.height, info.width)
    return Map(cells, info.resolution, (info.origin.position.x, info.origin.position.y, yaw))


def valid_now():
    """Waits for the clock; returns the time, or None when ROS ends first."""
    while not rospy.is_shutdown():
        now = rospy.Time.now()
        if now != rospy.Time():
            return now
        rospy.rostime.wallsleep(0.05)
    return None
