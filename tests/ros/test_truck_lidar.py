"""The lidars see the walls of a known room where they are, the trailer, and never the truck."""

import math
import unittest

import numpy as np
from sensor_msgs.msg import LaserScan
from sim_client import START_LIMIT, Recorder

LAUNCH = """<launch>
  <include file="$(find cybertruck)/launch/truck.launch">
    <arg name="world" value="$(find paddock_tests)/ros/room.world"/>
    <arg name="trailer_lidar" value="true"/>
    <arg name="headless" value="true"/>
    <arg name="real_time_factor" value="0"/>
  </include>
  <param name="/robot_state_publisher/publish_frequency" value="5.0"/>
  <param name="/gazebo/pub_clock_frequency" value="20.0"/>
</launch>
"""

SCANS = 60
RANGE_MIN, RANGE_MAX = 0.12, 3.5  # [m]
SIGMA = 0.01  # [m]
# Boxes of room.world (x0, x1, y0, y1) [m], and where the lidars stand in it.
WALLS = (
    (-3.2, 3.2, 2.0, 2.2),
    (-3.2, 3.2, -2.2, -2.0),
    (-3.2, -3.0, -2.0, 2.0),
    (3.0, 3.2, 0.5, 2.0),
    (3.0, 3.2, -2.0, -0.5),
)
LIDAR = (0.30, 0.0)
TRAILER_LIDAR = (-0.30 - 0.70 + 0.10, 0.0)
# The trailer's box at its collision shape: front 0.30 m behind the hitch, which is at -0.30.
TRAILER = (-0.30 - 0.30 - 0.74, -0.30 - 0.30, -0.25, 0.25)


def distance(origin, angle, box):
    """Returns the distance [m] along a ray to a box (x0, x1, y0, y1), infinity for a miss."""
    near, far = 0.0, math.inf
    for start, step, low, high in (
        (origin[0], math.cos(angle), box[0], box[1]),
        (origin[1], math.sin(angle), box[2], box[3]),
    ):
        if abs(step) < 1e-12:
            if not low <= start <= high:
                return math.inf
            continue
        first, second = sorted(((low - start) / step, (high - start) / step))
        near, far = max(near, first), min(far, second)
    return near if near <= far else math.inf


def expected(origin, angles, boxes):
    """Returns the ranges (n,) of a scan without noise, infinity beyond the range."""
    ranges = np.array([min(distance(origin, angle, box) for box in boxes) for angle in angles])
    return np.where(ranges > RANGE_MAX, np.inf, ranges)


def clear_of_edges(origin, angles, boxes):
    """Returns for each beam (n,) whether it hits the same thing when it is 0.3 degrees off, within
    the range by a margin; next to an edge a millimeter decides."""
    around = [expected(origin, angles + math.radians(off), boxes) for off in (-0.3, 0.0, 0.3)]
    hits = np.isfinite(around)
    with np.errstate(invalid="ignore"):
        smooth = np.abs(around[2] - around[0]) < 0.1
        inside = np.max(around, axis=0) < RANGE_MAX - 6 * SIGMA
    return np.where(hits.all(axis=0), smooth & inside, ~hits.any(axis=0))


class TruckLidar(unittest.TestCase):
    """Reads both lidars of a truck that stands at the origin."""

    @classmethod
    def setUpClass(cls):
        recorders = [Recorder(topic, LaserScan) for topic in ("/scan", "/trailer_scan")]
        cls.scans, cls.trailer_scans = (
            recorder.wait_count(SCANS, START_LIMIT)[-SCANS:] for recorder in recorders
        )
        cls.angles = cls.scans[0].angle_min + cls.scans[0].angle_increment * np.arange(360)

    def test_form(self):
        for scans, frame in (
            (self.scans, "lidar_link"),
            (self.trailer_scans, "trailer_lidar_link"),
        ):
            scan = scans[-1]
            self.assertEqual(scan.header.frame_id, frame)
            self.assertEqual(len(scan.ranges), 360)
            self.assertAlmostEqual(scan.angle_increment, math.radians(1.0), places=6)
            self.assertAlmostEqual(scan.angle_min, -math.pi, places=6)
            self.assertAlmostEqual(scan.angle_max, math.radians(179.0), places=6)
            self.assertAlmostEqual(scan.range_min, RANGE_MIN, places=6)
            self.assertAlmostEqual(scan.range_max, RANGE_MAX, places=6)

    def test_five_scans_a_second(self):
        stamps = [scan.header.stamp.to_nsec() for scan in self.scans]
        self.assertEqual(set(np.diff(stamps)), {200_000_000})

    def test_every_beam_sees_walls_trailer_or_nothing(self):
        self.check(LIDAR, self.scans, (*WALLS, TRAILER))
        self.check(TRAILER_LIDAR, self.trailer_scans, WALLS)

    def check(self, origin, scans, boxes):
        """Compares scans with the room; neither truck nor trailer's own roof can hide in it."""
        ranges = np.array([scan.ranges for scan in scans])
        wanted = expected(origin, self.angles, boxes)
        clear = clear_of_edges(origin, self.angles, boxes)
        self.assertGreater(clear.sum(), 300)
        nothing = clear & np.isinf(wanted)
        self.assertGreater(nothing.sum(), 15)
        self.assertTrue((ranges[:, nothing] == np.inf).all())
        seen = clear & np.isfinite(wanted)
        self.assertTrue(np.isfinite(ranges[:, seen]).all())
        errors = ranges[:, seen] - wanted[seen]
        self.assertLess(np.abs(errors.mean(axis=0)).max(), 0.005)
        self.assertLess(abs(errors.mean()), 0.001)
