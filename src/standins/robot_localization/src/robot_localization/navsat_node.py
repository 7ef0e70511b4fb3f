"""The node navsat_transform_node: topics, services, transforms."""

import functools
import math
import threading

import numpy as np
import rospy
import tf2_ros
from geographic_msgs.msg import GeoPoint
from geometry_msgs.msg import Point
from nav_msgs.msg import Odometry
from paddock_common.settings import converted
from sensor_msgs.msg import Imu, NavSatFix, NavSatStatus

from paddock_common import nodes
from robot_localization import srv
from robot_localization.frames import Frames, matrix, rotation_of, to_message, to_transform, vector
from robot_localization.navsat import Alignment, NotAligned, fix_as_odometry, odometry_as_fix
from robot_localization.options import truth


class Services:
    """Services of an Alignment.

    Args:
        lock: acquired while it is used.
        on_zone: called with the lock acquired, after a zone was set.
    """

    def __init__(self, alignment, lock, on_zone):
        self._alignment, self._lock, self._on_zone = alignment, lock, on_zone
        for name, service, work in (
            ("datum", srv.SetDatum, self._set_datum),
            ("toLL", srv.ToLL, self._to_geodetic),
            ("fromLL", srv.FromLL, self._to_world),
            ("setUTMZone", srv.SetUTMZone, self._set_zone),
        ):
            rospy.Service(name, service, functools.partial(self._handle, work))

    def _handle(self, work, request):
        with self._lock:
            try:
                return work(request)
            except (NotAligned, ValueError) as error:
                raise rospy.ServiceException(str(error)) from None

    def _set_datum(self, request):
        position = request.geo_pose.position
        self._alignment.set_datum(
            position.latitude,
            position.longitude,
            position.altitude,
            rotation_of(request.geo_pose.orientation),
        )
        return srv.SetDatumResponse()

    def _set_zone(self, request):
        self._alignment.set_zone(request.utm_zone)
        self._on_zone()
        return srv.SetUTMZoneResponse()

    def _to_geodetic(self, request):
        position = vector(request.map_point)
        return srv.ToLLResponse(GeoPoint(*self._alignment.to_geodetic(position)))

    def _to_world(self, request):
        point = request.ll_point
        position = self._alignment.to_world(point.latitude, point.longitude, point.altitude)
        return srv.FromLLResponse(Point(*position.tolist()))


WARN_PERIOD = 5.0  # between two equal warnings [s]
BROADCAST = "broadcast_cartesian_transform"
AS_PARENT = "broadcast_cartesian_transform_as_parent_frame"
OLD_NAMES = {
    "broadcast_utm_transform": BROADCAST,
    "broadcast_utm_transform_as_parent_frame": AS_PARENT,
}


class NavsatNode:
    """Subscribes to fixes, headings and odometry, publishes the fixes as odometry.

    Raises:
        ValueError: A parameter is wrong.
    """

    def __init__(self):
        parameters = rospy.get_param("~", {})
        for old, new in OLD_NAMES.items():
            if old in parameters:
                parameters.setdefault(new, parameters[old])

        def true(name):
            return truth(name, parameters.get(name, False))

        def value(name, default=0.0):
            return converted(name, parameters.get(name, default))

        self._lock = threading.RLock()
        self._alignment = Alignment(
            value("magnetic_declination_radians"),
            value("yaw_offset"),
            true("use_local_cartesian"),
            true("zero_altitude"),
        )
        self._use_odometry_yaw = true("use_odometry_yaw")
        self._broadcast, self._as_parent = true(BROADCAST), true(AS_PARENT)
        self._grid_frame = parameters.get("cartesian_frame_id")
        self._frames = Frames(value("transform_timeout"))
        self._world, self._robot = "odom", "base_link"
        self._fix = None  # the latest, until it is used
        self._odometry, self._odometry_is_new = None, False
        self._start_time = rospy.get_time() + value("delay")
        self._broadcaster = tf2_ros.StaticTransformBroadcaster()
        waits = true("wait_for_datum")
        if waits and "datum" in parameters:
            self._datum_of(parameters["datum"])
        self._alignment.manual = waits

        self._positions = rospy.Publisher("odometry/gps", Odometry, queue_size=10)
        self._filtered = None
        if true("publish_filtered_gps"):
            self._filtered = rospy.Publisher("gps/filtered", NavSatFix, queue_size=10)
        Services(self._alignment, self._lock, self._listen_to_heading)
        self._interfaces = [
            rospy.Subscriber("odometry/filtered", Odometry, self._on_odometry, queue_size=1),
            rospy.Subscriber("gps/fix", NavSatFix, self._on_fix, queue_size=1),
        ]
        self._imu = None
        if not waits:
            self._listen_to_heading()
        rate = value("frequency", 10.0)
        if not rate > 0.0:
            raise ValueError(f"frequency is {rate:g} Hz, must be above 0")
        self._timer = rospy.Timer(rospy.Duration(1.0 / rate), lambda _: self.update(), reset=True)

    def _listen_to_heading(self):
        if not self._use_odometry_yaw and self._imu is None:
            self._imu = rospy.Subscriber("imu/data", Imu, self._on_imu, queue_size=1)

    def _datum_of(self, values):
        if not isinstance(values, list) or len(values) < 3:
            raise ValueError(f"datum is {values!r}, must be [latitude, longitude, heading]")
        latitude, longitude, heading = (converted("datum", item) for item in values[:3])
        self._alignment.set_datum(latitude, longitude, 0.0, matrix(0.0, 0.0, heading))

    def _on_odometry(self, message):
        pose = to_transform(message.pose.pose.position, message.pose.pose.orientation)
        with self._lock:
            self._world = message.header.frame_id.lstrip("/")
            self._robot = message.child_frame_id.lstrip("/") or self._robot
            self._odometry, self._odometry_is_new = (message, pose), True
            self._alignment.set_pose(pose)
            if self._use_odometry_yaw and not self._alignment.manual:
                self._alignment.set_attitude(pose.rotation)

    def _on_imu(self, message):
        with self._lock:
            if self._odometry is None:  # the robot's frame is not known yet
                return
            mount = self._frames.find(self._robot, message.header.frame_id, message.header.stamp)
            if mount is not None and not self._alignment.manual:
                attitude = rotation_of(message.orientation)
                self._alignment.set_attitude(attitude @ mount.rotation.T)

    def _on_fix(self, message):
        position = message.latitude, message.longitude, message.altitude
        if message.status.status == NavSatStatus.STATUS_NO_FIX or not all(
            math.isfinite(item) for item in position
        ):
            return
        with self._lock:
            try:
                self._alignment.set_fix(*position)
            except ValueError as error:
                rospy.logerr_throttle(WARN_PERIOD, f"navsat_transform_node: {error}")
                return
            self._fix = message, position

    def _antenna(self, stamp):
        """(3,) position of the receiver on the robot [m], or None when its frame is not known."""
        mount = self._frames.find(self._robot, self._fix[0].header.frame_id, stamp)
        return None if mount is None else mount.translation

    def update(self):
        """Aligns, or publishes what is new."""
        if rospy.get_time() < self._start_time:
            return
        with self._lock:
            if self._alignment.grid_in_world is None:
                antenna = self._antenna(rospy.Time()) if self._fix else None
                if self._alignment.align(antenna):
                    self._aligned()
                return
            if self._fix and self._odometry:
                self._publish_position()
            if self._filtered and self._odometry_is_new:
                self._odometry_is_new = False
                self._publish_filtered()

    def _aligned(self):
        transform = self._alignment.grid_in_world
        rospy.loginfo(
            "navsat_transform_node: the grid's origin is at (%.3f, %.3f, %.3f) in '%s'",
            *transform.translation,
            self._world,
        )
        if self._imu is not None:
            self._imu.unregister()
            self._imu = None
        if not self._broadcast:
            return
        grid = str(self._grid_frame or self._alignment.grid.name)
        parent, child = (grid, self._world) if self._as_parent else (self._world, grid)
        message = to_message(
            transform.inverse() if self._as_parent else transform, parent, child, rospy.Time.now()
        )
        message.transform.translation.z = float(
            self._alignment.flat(np.array((0.0, 0.0, message.transform.translation.z)))[2]
        )
        self._broadcaster.sendTransform(message)

    def _publish_position(self):
        (fix, position), antenna = self._fix, self._antenna(self._fix[0].header.stamp)
        self._fix, stamp = None, fix.header.stamp
        try:
            position = self._alignment.to_world(*position)
        except ValueError as error:
            rospy.logerr_throttle(WARN_PERIOD, f"navsat_transform_node: {error}")
            return
        if antenna is not None and antenna.any():
            robot = self._frames.find(self._world, self._robot, stamp)
            if robot is not None:
                position = self._alignment.flat(position - robot.rotation @ antenna)
        self._positions.publish(fix_as_odometry(self._alignment, fix, self._world, position))

    def _publish_filtered(self):
        odometry, pose = self._odometry
        try:
            message = odometry_as_fix(self._alignment, odometry, self._robot, pose)
        except ValueError as error:
            rospy.logerr_throttle(WARN_PERIOD, f"navsat_transform_node: {error}")
            return
        self._filtered.publish(message)


def main():
    nodes.run("navsat_transform_node", NavsatNode)
