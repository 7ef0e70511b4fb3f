"""The node map_server: a map's file as messages and as a service."""

import sys
import threading

import numpy as np
import rospy
from geometry_msgs.msg import Point, Pose
from nav_msgs.msg import MapMetaData, OccupancyGrid
from nav_msgs.srv import GetMap, GetMapResponse, LoadMap, LoadMapResponse
from paddock_common.geometry import quaternion_of, yaw_of

from occupancy_map.files import FREE_THRESH, OCCUPIED_THRESH, Map, from_image, load
from paddock_common import nodes


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
        origin=Pose(Point(x, y, 0.0), quaternion_of(yaw)),
    )
    message.data = grid.cells.ravel().tolist()
    return message


def from_message(message):
    """Map of a nav_msgs/OccupancyGrid."""
    info, yaw = message.info, yaw_of(message.info.origin.orientation)
    cells = np.array(message.data, np.int8).reshape(info.height, info.width)
    return Map(cells, info.resolution, (info.origin.position.x, info.origin.position.y, yaw))


def valid_now():
    """Waits for the clock; returns the time, or None when ROS shuts down first."""
    while not rospy.is_shutdown():
        now = rospy.Time.now()
        if now != rospy.Time():
            return now
        rospy.rostime.wallsleep(0.05)
    return None


USAGE = "usage: map_server MAP.yaml, or (old) map_server IMAGE RESOLUTION"


class MapServer:
    """Publishes a map and serves it."""

    def __init__(self, grid):
        self._frame, self._lock = str(rospy.get_param("~frame_id", "map")), threading.Lock()
        self._map = rospy.Publisher("map", OccupancyGrid, queue_size=1, latch=True)
        self._info = rospy.Publisher("map_metadata", MapMetaData, queue_size=1, latch=True)
        self._publish(grid)
        self._services = [
            rospy.Service("static_map", GetMap, lambda _: GetMapResponse(self._message)),
            rospy.Service("change_map", LoadMap, self._change),
        ]

    def _publish(self, grid):
        self._message = to_message(grid, self._frame, valid_now() or rospy.Time())
        info = self._message.info
        rospy.loginfo(
            "map_server: map of %d x %d cells of %.3f m", info.width, info.height, info.resolution
        )
        self._info.publish(info)
        self._map.publish(self._message)

    def _change(self, request):
        try:
            grid = load(request.map_url)
        except ValueError as error:
            rospy.logerr("map_server: %s", error)
            return LoadMapResponse(
                map=self._message, result=LoadMapResponse.RESULT_UNDEFINED_FAILURE
            )
        with self._lock:
            self._publish(grid)
            return LoadMapResponse(map=self._message, result=LoadMapResponse.RESULT_SUCCESS)


def _read(arguments):
    if len(arguments) == 1:
        return load(arguments[0])
    rospy.logwarn("map_server: an image and a resolution: better a map file")
    try:
        resolution = float(arguments[1])
    except ValueError:
        raise ValueError(f"resolution is '{arguments[1]}', must be a number") from None
    return from_image(
        arguments[0],
        resolution,
        negate=bool(rospy.get_param("~negate", 0)),
        occupied_thresh=float(rospy.get_param("~occupied_thresh", OCCUPIED_THRESH)),
        free_thresh=float(rospy.get_param("~free_thresh", FREE_THRESH)),
    )


def main():
    """Runs the node; returns 2 for a wrong command line."""
    arguments = rospy.myargv(sys.argv)[1:]
    if len(arguments) not in (1, 2):
        print(USAGE, file=sys.stderr)
        return 2
    nodes.run("map_server", lambda: MapServer(_read(arguments)), anonymous=True)
