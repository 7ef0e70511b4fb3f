"""Trajectory and gripper actions by actionlib's clients, a wrist's load, a mimic finger."""

import unittest

import actionlib
import rospy
from actionlib_msgs.msg import GoalStatus
from control_msgs.msg import (
    FollowJointTrajectoryAction,
    FollowJointTrajectoryGoal,
    GripperCommandAction,
)
from sensor_msgs.msg import JointState
from sim_client import START_LIMIT, Recorder, wait_until
from std_srvs.srv import Empty
from trajectory_msgs.msg import JointTrajectoryPoint

LAUNCH = """<launch>
  <include file="$(find gazebo_ros)/launch/empty_world.launch">
    <arg name="gui" value="false"/>
    <arg name="headless" value="true"/>
  </include>
  <param name="robot_description" textfile="$(find paddock_tests)/ros/arm_bot.urdf"/>
  <rosparam file="$(find paddock_tests)/ros/actions.yaml" command="load"/>
  <node name="spawn_bot" pkg="gazebo_ros" type="spawn_model" output="screen"
        args="-urdf -param robot_description -model arm_bot"/>
  <node name="controllers" pkg="controller_manager" type="spawner" output="screen"
        args="--timeout 120 joint_state_controller arm hand loads"/>
  <param name="/gazebo/pub_clock_frequency" value="50.0"/>
</launch>
"""


class Actions(unittest.TestCase):
    """Goals to /arm/follow_joint_trajectory and /hand/gripper_cmd."""

    @classmethod
    def setUpClass(cls):
        cls.arm = actionlib.SimpleActionClient(
            "/arm/follow_joint_trajectory", FollowJointTrajectoryAction
        )
        cls.hand = actionlib.SimpleActionClient("/hand/gripper_cmd", GripperCommandAction)
        cls.states = Recorder("/joint_states", JointState)
        for client in (cls.arm, cls.hand):
            if not client.wait_for_server(rospy.Duration(START_LIMIT)):
                raise AssertionError("no action server")
        cls.states.wait_count(1, START_LIMIT)

    def move(self, angle, seconds):
        """Send the arm to an angle [rad]; a list that collects feedback."""
        goal, feedback = FollowJointTrajectoryGoal(), []
        goal.trajectory.joint_names = ["shoulder"]
        goal.trajectory.points = [
            JointTrajectoryPoint(
                positions=[angle], velocities=[0.0], time_from_start=rospy.Duration(seconds)
            )
        ]
        self.arm.send_goal(goal, feedback_cb=feedback.append)
        return feedback

    def finished(self, client):
        """Wait for the end of a goal; (state, result). The status can come before the result."""
        wait_until(
            lambda: client.simple_state == actionlib.SimpleGoalState.DONE, "the end of the goal"
        )
        return client.get_state(), client.get_result()

    def position(self, joint):
        """Newest position of a joint."""
        return dict(zip(self.states.last.name, self.states.last.position))[joint]

    def test_a_trajectory_is_followed_and_succeeds(self):
        self.move(0.5, 0.5)
        state, result = self.finished(self.arm)
        self.assertEqual((state, result.error_code), (GoalStatus.SUCCEEDED, 0))
        wait_until(lambda: abs(self.position("shoulder") - 0.5) < 0.03, "the arm at its goal")

    def test_a_goal_is_reported_and_can_be_cancelled_and_a_wrong_one_is_rejected(self):
        feedback = self.move(-0.5, 60.0)  # an actionlib client drops feedback after the result
        wait_until(lambda: self.arm.get_state() == GoalStatus.ACTIVE, "the goal accepted")
        wait_until(lambda: len(feedback) > 3, "feedback")
        self.assertEqual(feedback[0].joint_names, ["shoulder"])
        self.arm.cancel_goal()
        self.assertEqual(self.finished(self.arm)[0], GoalStatus.PREEMPTED)
        goal = FollowJointTrajectoryGoal()
        goal.trajectory.joint_names = ["nose"]
        self.arm.send_goal(goal)
        state, result = self.finished(self.arm)
        self.assertEqual((state, result.error_code), (GoalStatus.REJECTED, result.INVALID_JOINTS))

    def test_actions_go_on_after_a_reset(self):
        rospy.ServiceProxy("/gazebo/reset_simulation", Empty)()
        self.move(0.3, 0.3)
        self.assertEqual(self.finished(self.arm)[0], GoalStatus.SUCCEEDED)
