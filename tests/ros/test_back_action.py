"""The backing action on the simulated truck: arrival, feedback, cancel, a newer goal, refusal."""

import math
import threading
import unittest

import actionlib
import rospy
from actionlib_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseStamped
from launches import wait_subscribed
from nav_msgs.msg import Odometry
from sensor_msgs.msg import JointState
from shared_worlds import TRUE_TRUCK as LAUNCH  # noqa: F401
from sim_client import START_LIMIT, Recorder, joint, sleep_sim, wait_until, yaw_of

from cybertruck.msg import BackUpAction, BackUpGoal, CyberDriveStamped

TOP_SPEED = 0.7  # [m/s]
TONGUE, OFFSET = 0.70, 0.30  # of config/truck.yaml [m]
PATIENCE = 300.0  # wall time that a short drive may take on a loaded machine [s]


class BackAction(unittest.TestCase):
    """Every test goes on from where another left the truck, at rest."""

    @classmethod
    def setUpClass(cls):
        cls.truth = Recorder("/ground_truth/odom", Odometry)
        cls.joints = Recorder("/joint_states", JointState)
        cls.commands = Recorder("/cmd_cyberdrive", CyberDriveStamped)
        wait_until(lambda: cls.truth.last and cls.joints.last, "the truck", START_LIMIT)
        cls.client = actionlib.SimpleActionClient("back_up", BackUpAction)
        wait_until(
            lambda: cls.client.wait_for_server(rospy.Duration(0.5)), "the action", START_LIMIT
        )
        wait_subscribed(["/odom", "/joint_states"], "/back_up", "/drive")
        odometry = Recorder("/odom", Odometry)
        odometry.next(START_LIMIT)
        odometry.close()
        sleep_sim(1.0)

    def setUp(self):
        self.commands.clear()

    def trailer(self):
        """(x, y [m], heading [rad]) of the trailer's axle, from ground truth and joint states."""
        pose = self.truth.next().pose.pose
        heading = yaw_of(pose.orientation)
        turned = heading + joint(self.joints.last, "hitch_yaw_joint")[0]
        return (
            pose.position.x - OFFSET * math.cos(heading) - TONGUE * math.cos(turned),
            pose.position.y - OFFSET * math.sin(heading) - TONGUE * math.sin(turned),
            turned,
        )

    def run_goal(self, goal, feedback=None):
        """Sends a goal and waits for its end; returns status and result."""
        done = threading.Event()
        self.client.send_goal(goal, done_cb=lambda *_: done.set(), feedback_cb=feedback)
        wait_until(done.is_set, "the end of the goal", PATIENCE)
        return self.client.get_state(), self.client.get_result()

    def assert_standing(self):
        """The truck does not move on."""
        sleep_sim(1.0)
        self.assertLess(abs(self.truth.next().twist.twist.linear.x), 0.01)

    def test_shape_with_feedback(self):
        x, y, heading = self.trailer()
        feedback = []
        status, result = self.run_goal(
            BackUpGoal(shape="lane-change", size=[0.5, 3.0, 0.5], speed=0.5), feedback.append
        )
        self.assertEqual((status, result.message), (GoalStatus.SUCCEEDED, "arrived"))
        self.assertLess(result.max_lateral_error, 0.10)
        self.assertLess(result.end_distance, 0.10)
        progress = [item.progress for item in feedback]
        self.assertGreater(len(progress), 10)
        self.assertEqual(progress, sorted(progress))
        self.assertLess(progress[0], 0.3)
        self.assertGreater(progress[-1], 0.9)
        self.assertGreater(max(abs(item.hitch_angle) for item in feedback), math.radians(3.0))
        speeds = [item.drive.speed for item in self.commands.messages]
        self.assertLess(max(map(abs, speeds)), TOP_SPEED)
        self.assertLess(min(speeds), -0.4)
        end = self.trailer()
        # seen along the way that is backed, the lane lies 0.5 m to the left
        ahead = -(end[0] - x) * math.cos(heading) - (end[1] - y) * math.sin(heading)
        left = (end[0] - x) * math.sin(heading) - (end[1] - y) * math.cos(heading)
        self.assertAlmostEqual(ahead, 4.0, delta=0.10)
        self.assertAlmostEqual(left, 0.5, delta=0.10)
        self.assertAlmostEqual(end[2], heading, delta=math.radians(3.0))
        self.assert_standing()

    def test_path_of_poses_and_a_bad_goal_moves_nothing(self):
        x, y, heading = self.trailer()
        status, result = self.run_goal(BackUpGoal(shape="line", size=[math.nan]))
        self.assertEqual(status, GoalStatus.REJECTED)
        self.assertIn("nan", result.message)
        sleep_sim(0.5)
        self.assertLess(math.dist((x, y), self.trailer()[:2]), 0.005)
        goal = BackUpGoal(speed=0.5)
        goal.path.header.frame_id = "odom"
        for meters in (0.0, 1.0, 2.0):
            item = PoseStamped()
            item.pose.position.x = x - meters * math.cos(heading)
            item.pose.position.y = y - meters * math.sin(heading)
            goal.path.poses.append(item)
        status, result = self.run_goal(goal)
        self.assertEqual(status, GoalStatus.SUCCEEDED)
        end = self.trailer()
        target = goal.path.poses[-1].pose.position
        self.assertLess(math.hypot(end[0] - target.x, end[1] - target.y), 0.05)
        self.assertLess(result.end_distance, 0.05)

    def test_cancel_stops_the_truck(self):
        self.client.send_goal(BackUpGoal(shape="line", size=[8.0]))
        wait_until(lambda: self.truth.last.twist.twist.linear.x < -0.2, "motion", PATIENCE)
        self.client.cancel_goal()
        wait_until(self.client.get_result, "the cancelled goal's result")  # may follow the status
        self.assertEqual(self.client.get_state(), GoalStatus.PREEMPTED)
        self.assertFalse(self.client.get_result().success)
        self.assert_standing()

    def test_a_newer_goal_ends_the_older(self):
        ended = []
        other = actionlib.SimpleActionClient("back_up", BackUpAction)
        wait_until(lambda: other.wait_for_server(rospy.Duration(0.5)), "the action")
        other.send_goal(
            BackUpGoal(shape="line", size=[8.0]),
            done_cb=lambda status, result: ended.append((status, result.message)),
        )
        wait_until(lambda: self.truth.last.twist.twist.linear.x < -0.2, "motion", PATIENCE)
        status, _ = self.run_goal(BackUpGoal(shape="line", size=[1.0], speed=0.5))
        self.assertEqual(status, GoalStatus.SUCCEEDED)
        self.assertEqual(ended, [(GoalStatus.PREEMPTED, "replaced by a newer goal")])
        self.assert_standing()
