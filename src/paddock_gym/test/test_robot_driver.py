"""The node robot_driver: what it makes of messages, how long it waits for those that are due."""

import threading
import time

import numpy as np
import pytest
from genpy import Time
from paddock_gym.driver import robot
from sensor_msgs import point_cloud2
from sensor_msgs.msg import LaserScan, NavSatFix, PointCloud
from std_msgs.msg import Header

POINTS = [(1.0, 2.0, 3.0), (np.nan,) * 3, (4.0, 5.0, 6.0)]


@pytest.fixture(name="source")
def _source(monkeypatch):
    """Function: arguments of a Source -> it, without a subscription."""
    monkeypatch.setattr(robot.rospy, "Subscriber", lambda *_, **__: None)
    return robot.Source


def scan(stamp):
    """A LaserScan of a time [s]."""
    return LaserScan(header=Header(stamp=Time.from_sec(stamp)), ranges=[stamp])


def test_a_message_is_due_a_period_after_the_last_one(source):
    scans = source("/scan", "sensor_msgs/LaserScan", {"ranges": [1]})
    scans.take(scan(0.1))
    assert not scans.is_due(9.0)  # nobody knows its period
    scans.take(scan(0.2))
    assert not scans.is_due(0.29) and scans.is_due(0.3)
    scans.take(scan(0.0))  # time went back
    assert not scans.is_due(9.0)


def test_the_node_waits_for_what_is_due_and_no_longer(source):
    scans = source("/scan", "sensor_msgs/LaserScan", {"ranges": [1]})
    driver = robot.RobotDriver.__new__(robot.RobotDriver)
    driver._sources, driver._wait = {"scan": scans}, 5.0
    for stamp in (0.1, 0.2):
        scans.take(scan(stamp))
    driver._wait_for_due(0.25)
    threading.Timer(0.05, scans.take, (scan(0.3),)).start()
    begin = time.monotonic()
    driver._wait_for_due(0.3)
    assert scans.read() == np.float64(0.3) and time.monotonic() - begin < 5.0
    driver._wait = 0.05
    driver._wait_for_due(0.4)  # it does not come
    assert scans.read() == np.float64(0.3)


@pytest.mark.parametrize("organized", [False, True])
def test_points_are_where_the_environment_has_them(source, organized):
    cloud = point_cloud2.create_cloud_xyz32(Header(), POINTS)
    clouds = source("/points", "sensor_msgs/PointCloud2", {"points": [3, 3]}, dtype="float32",
                    organized=organized)  # fmt: skip
    clouds.take(cloud)
    nothing = [0.0, 0.0, 0.0]
    rows = [POINTS[0], nothing, POINTS[2]] if organized else [POINTS[0], POINTS[2], nothing]
    assert np.array_equal(clouds.read(), np.float32(rows))


def test_a_cloud_without_channels_and_one_without_points(source):
    clouds = source("/points", "sensor_msgs/PointCloud", {"points": [2, 3]}, dtype="float32")
    clouds.take(PointCloud())
    assert np.array_equal(clouds.read(), np.zeros((2, 3)))


def test_a_fix_is_latitude_longitude_altitude(source):
    fixes = source("/fix", "sensor_msgs/NavSatFix", {"fix": [3]})
    fixes.take(NavSatFix(latitude=49.9, longitude=8.9, altitude=3.0))
    assert fixes.read().tolist() == [49.9, 8.9, 3.0]
