"""With odom_source ground_truth the truck's odometry is the truth, to the last digit."""

import unittest

from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from shared_worlds import TRUE_TRUCK as LAUNCH  # noqa: F401
from sim_client import Recorder
from tf2_msgs.msg import TFMessage
from truck_client import TRUTH, Driver, wait_for_truck, way


class TruckGroundTruth(unittest.TestCase):
    """Drives an arc and compares messages of the same stamps."""

    def test_odometry_pose_and_transform_are_the_truth(self):
        wait_for_truck()
        truth, odometry = Recorder(TRUTH, Odometry), Recorder("/odom", Odometry)
        poses, transforms = Recorder("/pose", PoseStamped), Recorder("/tf", TFMessage)
        truth.next()
        Driver().hold(0.4, 1.0, 3.0)
        self.assertGreater(way(truth.messages)[0], 2.0)
        truths = {m.header.stamp: m for m in truth.messages}
        published = [m for m in odometry.messages if m.header.stamp in truths]
        self.assertGreater(len(published), 100)
        for message in published:
            true = truths[message.header.stamp]
            self.assertEqual(message.pose, true.pose)
            self.assertEqual(message.twist, true.twist)
        for message in poses.messages:
            if message.header.stamp in truths:
                self.assertEqual(message.pose, truths[message.header.stamp].pose.pose)
        moved = [
            t
            for m in transforms.messages
            for t in m.transforms
            if t.child_frame_id == "base_footprint" and t.header.stamp in truths
        ]
        self.assertGreater(len(moved), 100)
        for transform in moved:
            true = truths[transform.header.stamp].pose.pose
            self.assertEqual(
                (transform.transform.translation.x, transform.transform.translation.y),
                (true.position.x, true.position.y),
            )
            self.assertEqual(transform.transform.rotation, true.orientation)
