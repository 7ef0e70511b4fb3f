"""Go-to-goal beside the plain drives: inside the turning circle, preempted, refused, silent
odometry, a reset."""

import math

import rospy
from actionlib_msgs.msg import GoalStatus
from goal_rig import TOLERANCE, Driver, Rig
from nav_msgs.msg import Odometry
from sim_client import START_LIMIT, sleep_sim, wait_connected, wait_until
from std_srvs.srv import Empty

LAUNCH = """<launch>
  <include file="$(find paddock_tests)/ros/goal_world.launch">
    <arg name="relayed" value="true"/>
    <arg name="trailer" value="true"/>
  </include>
</launch>
"""


class Manoeuvres(Rig):
    """A goal inside the turning circle, new goals, bad goals, lost odometry, a reset."""

    def setUp(self):
        self.wait_rest()

    def test_beside_the_truck_inside_its_turning_circle_then_silence(self):
        x, y, heading = self.pose()
        goal = (x - 0.4 * math.sin(heading), y + 0.4 * math.cos(heading))
        distance, _, path, shortest, changes, _ = self.drive(self.driver, goal)
        print(f"beside: {distance:.3f} m, path {path:.2f} m, shortest {shortest:.2f} m")
        self.assertLessEqual(distance, TOLERANCE)
        self.assertLessEqual(path, 1.10 * shortest)
        self.assertLessEqual(changes, 3)
        sleep_sim(1.0)
        self.commands.clear()
        sleep_sim(1.0)
        self.assertEqual(self.commands.messages, [])

    def test_preempt_and_cancel(self):
        x, y, heading = self.pose()
        ahead = (x + 6.0 * math.cos(heading), y + 6.0 * math.sin(heading))
        self.driver.status.clear()
        self.assertTrue(self.driver.send(*ahead))
        wait_until(lambda: self.speed() > 0.5, "the truck to drive")
        self.assertTrue(self.driver.send(x - 5.0 * math.cos(heading), y - 5.0 * math.sin(heading)))
        wait_until(lambda: len(self.driver.status.messages) >= 3, "the new status")
        first, second, third = self.driver.status.messages[:3]
        self.assertEqual(
            [first.status, second.status, third.status],
            [GoalStatus.ACTIVE, GoalStatus.PREEMPTED, GoalStatus.ACTIVE],
        )
        self.assertEqual(first.goal_id.id, second.goal_id.id)
        self.assertNotEqual(second.goal_id.id, third.goal_id.id)
        self.assertTrue(self.driver.cancel().success, self.driver.status.last.text)
        self.assertEqual(self.driver.wait_end().status, GoalStatus.PREEMPTED)
        self.wait_rest()
        self.assertFalse(self.driver.cancel().success)

    def test_bad_goals_are_refused_and_the_running_one_goes_on(self):
        x, y, heading = self.pose()
        self.driver.status.clear()
        self.assertTrue(self.driver.send(x + 4.0 * math.cos(heading), y + 4.0 * math.sin(heading)))
        for bad in ((math.nan, 0.0), (1e6, 0.0), (0.0, 0.0, 5.0)):
            self.assertFalse(self.driver.send(*bad), bad)
        self.assertEqual(self.driver.wait_end().status, GoalStatus.SUCCEEDED)

    def test_silent_odometry_stops_it(self):
        relayed = Driver("/relayed")
        self.assertFalse(relayed.send(5.0, 5.0))  # no odometry yet
        hand_on = rospy.Subscriber("/odom", Odometry, self.relay.publish)
        wait_connected(self.relay, "the relayed goal node")
        x, y, heading = self.pose()
        goal = (x + 30.0 * math.cos(heading), y + 30.0 * math.sin(heading))
        wait_until(lambda: relayed.send(*goal), "the goal to be taken")
        wait_until(lambda: self.speed() > 0.5, "the truck to drive")
        hand_on.unregister()
        status = relayed.wait_end()
        self.assertEqual(status.status, GoalStatus.ABORTED)
        self.assertIn("no odometry for 0.5 s", status.text)
        self.wait_rest()
        self.assertFalse(relayed.send(5.0, 5.0))  # still silent

    def test_a_reset_ends_the_goal_and_the_truck_stays(self):
        x, y, heading = self.pose()
        self.driver.status.clear()
        self.assertTrue(self.driver.send(x + 9.0 * math.cos(heading), y + 9.0 * math.sin(heading)))
        wait_until(lambda: self.speed() > 0.5, "the truck to drive")
        rospy.wait_for_service("/gazebo/reset_simulation", START_LIMIT)
        rospy.ServiceProxy("/gazebo/reset_simulation", Empty)()
        status = self.driver.wait_end()
        self.assertEqual(
            (status.status, status.text),
            (GoalStatus.ABORTED, "time went back: the simulation was reset"),
        )
        sleep_sim(2.0)
        self.wait_rest()
        self.assertLess(math.hypot(*self.pose()[:2]), 0.2)  # where it was spawned
