"""The services of navsat_transform_node: datum, zone, and places to and from the map."""

import numpy as np
import rospy
from geographic_msgs.msg import GeoPoint
from geometry_msgs.msg import Point

from robot_localization.navsat.alignment import NotAligned
from robot_localization.rotation import from_quaternion
from robot_localization.srv import (
    FromLL,
    FromLLResponse,
    SetDatum,
    SetDatumResponse,
    SetUTMZone,
    SetUTMZoneResponse,
    ToLL,
    ToLLResponse,
)


class Services:
    """Answers from an Alignment.

    Args:
        alignment: Alignment.
        lock: held while it is used.
        on_zone: called, holding the lock, after a zone was set.
    """

    def __init__(self, alignment, lock, on_zone):
        self._alignment, self._lock, self._on_zone = alignment, lock, on_zone
        self._ends = [
            rospy.Service("datum", SetDatum, self._set_datum),
            rospy.Service("toLL", ToLL, self._to_place),
            rospy.Service("fromLL", FromLL, self._to_world),
            rospy.Service("setUTMZone", SetUTMZone, self._set_zone),
        ]

    def _set_datum(self, request):
        place, turned = request.geo_pose.position, request.geo_pose.orientation
        with self._lock:
            try:
                self._alignment.set_datum(
                    place.latitude,
                    place.longitude,
                    place.altitude,
                    from_quaternion(turned.x, turned.y, turned.z, turned.w),
                )
            except ValueError as error:
                raise rospy.ServiceException(str(error)) from None
        return SetDatumResponse()

    def _set_zone(self, request):
        with self._lock:
            try:
                self._alignment.set_zone(request.utm_zone)
            except ValueError as error:
                raise rospy.ServiceException(str(error)) from None
            self._on_zone()
        return SetUTMZoneResponse()

    def _to_place(self, request):
        point = request.map_point
        with self._lock:
            try:
                return ToLLResponse(
                    GeoPoint(*self._alignment.to_place(np.array((point.x, point.y, point.z))))
                )
            except (NotAligned, ValueError) as error:
                raise rospy.ServiceException(str(error)) from None

    def _to_world(self, request):
        place = request.ll_point
        with self._lock:
            try:
                return FromLLResponse(
                    Point(
                        *self._alignment.to_world(
                            place.latitude, place.longitude, place.altitude
                        ).tolist()
                    )
                )
            except (NotAligned, ValueError) as error:
                raise rospy.ServiceException(str(error)) from None
