"""After a reset the clock restarts (unless it is monotonic) and everything else goes on.

Controllers keep running, /tf has the new time and an older buffer works again, models that were
spawned after the start are where they were spawned.
"""

import math
import unittest

import rospy
import tf2_ros
from controller_manager_msgs.srv import ListControllers
from gazebo_msgs.srv import GetModelState, SpawnModel
from geometry_msgs.msg import Point, Pose, Quaternion
from launches import Launch
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from sim_client import START_LIMIT, Recorder, joint, wait_connected, wait_running, wait_until
from std_msgs.msg import Float64
from std_srvs.srv import Empty

LAUNCH = """<launch>
  <param name="/use_sim_time" value="true"/>
</launch>
"""

BALL = """<sdf version="1.6"><model name="ball"><link name="link"><inertial><mass>1</mass><inertia>
<ixx>0.01</ixx><iyy>0.01</iyy><izz>0.01</izz></inertia></inertial><collision name="c"><geometry>
<sphere><radius>0.1</radius></sphere></geometry></collision></link></model></sdf>"""
TILL = 2.0  # simulated time before the reset [s]


class Reset(unittest.TestCase):
    """One world with a clock that starts over, one with a clock that goes on."""

    def call(self, name, kind=Empty, **fields):
        """Calls a service of the simulator."""
        rospy.wait_for_service("/gazebo/" + name, timeout=START_LIMIT)
        return rospy.ServiceProxy("/gazebo/" + name, kind)(**fields)

    def drive_and_reset(self, service):
        """Drives, then resets; returns the time [s] before."""
        self.odometry = Recorder("/bot/odom", Odometry)
        self.states = Recorder("/bot/joint_states", JointState)
        self.clock = Recorder("/clock", Clock)
        self.wheels = [
            rospy.Publisher(f"/bot/{side}/command", Float64, queue_size=1)
            for side in ("left", "right")
        ]
        for wheel in self.wheels:
            wait_connected(wheel, "wheel")
        wait_running("/bot", 3)
        self.buffer = tf2_ros.Buffer(debug=False)
        self.listener = tf2_ros.TransformListener(self.buffer)
        answer = self.call(
            "spawn_sdf_model",
            SpawnModel,
            model_name="ball",
            model_xml=BALL,
            initial_pose=Pose(Point(3, 0, 2), Quaternion(w=1)),
        )
        self.assertTrue(answer.success, answer.status_message)
        self.command(6.0)
        wait_until(
            lambda: self.place() > 0.2 and self.clock.newest.clock.to_sec() > TILL,
            "the bot driving",
        )
        wait_until(lambda: self.transform() is not None, "a transform before the reset")
        self.command(0.0)
        wait_until(lambda: abs(joint(self.states.next(), "left_joint")[1]) < 0.1, "standing")
        before = self.clock.newest.clock.to_sec()
        self.states.clear()
        self.clock.clear()
        self.call(service)
        return before

    def command(self, speed):
        """Turns both wheels [rad/s]."""
        for wheel in self.wheels:
            wheel.publish(speed)

    def place(self):
        """Distance from the start [m], with the noise of the sensor; 0 before a message."""
        if self.odometry.last is None:
            return 0.0
        point = self.odometry.last.pose.pose.position
        return math.hypot(point.x, point.y)

    def transform(self):
        """The newest transform of a wheel, or None."""
        try:
            return self.buffer.lookup_transform("base", "left_wheel", rospy.Time(0))
        except tf2_ros.TransformException:
            return None

    def check_all_goes_on(self, earliest, latest):
        """Controllers, joint states, /tf: times [s] lie between two bounds."""
        controllers = rospy.ServiceProxy(
            "/bot/controller_manager/list_controllers", ListControllers
        )().controller
        self.assertEqual([item.state for item in controllers], ["running"] * 3)
        wait_until(
            lambda: any(
                earliest <= message.header.stamp.to_sec() < latest
                for message in self.states.messages
            ),
            "joint states",
        )
        wait_until(lambda: self.place() < 0.05, "the bot at its start")
        ball = self.call("get_model_state", GetModelState, model_name="ball").pose.position
        self.assertAlmostEqual(ball.x, 3.0, delta=0.01)
        self.assertGreater(ball.z, 0.05)
        self.command(6.0)
        wait_until(lambda: self.place() > 0.2, "the bot obeying")
        now = rospy.Time.now()
        # A transform of before the reset that arrives after the buffer was cleared is the newest
        # until time has passed it.
        wait_until(
            lambda: (
                (transform := self.transform())
                and transform.header.stamp >= now
                and abs((transform.header.stamp - rospy.Time.now()).to_sec()) < 1.0
            ),
            "/tf with the new time",
        )

    def test_restart_starts_time_over(self):
        with Launch("bot_world.launch"):
            before = self.drive_and_reset("restart")
            # the first message may have been on its way before the reset
            wait_until(lambda: any(m.clock.to_sec() < TILL for m in self.clock.messages), "/clock")
            self.check_all_goes_on(0.0, before)

    def test_a_monotonic_clock_lets_time_go_on(self):
        with Launch("bot_world.launch", monotonic_clock="true"):
            before = self.drive_and_reset("reset_simulation")
            self.check_all_goes_on(before, math.inf)
            times = [message.clock for message in self.clock.messages]
            self.assertEqual(times, sorted(times), "/clock never goes back")

    def tearDown(self):
        """Unregisters everything."""
        self.listener.unregister()
        for thing in (self.odometry, self.states, self.clock):
            thing.close()
        for wheel in self.wheels:
            wheel.unregister()
