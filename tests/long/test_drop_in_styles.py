"""Launch files in other styles: each starts unchanged, and its nodes work."""

import math

import rospy
import tf2_ros
from controller_manager_msgs.srv import ListControllers
from drop_in_workspace import MasterCase, Workspace
from gazebo_msgs.srv import GetModelState, GetWorldProperties
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import JointState
from sim_client import (
    START_LIMIT,
    Recorder,
    faults,
    sleep_sim,
    wait_connected,
    wait_until,
    yaw_of,
)
from std_msgs.msg import Float64


class Styles(MasterCase):
    """Each test is one launch file."""

    NODE = "styles_test"
    make_workspace = Workspace

    def wait_running(self, launched, namespace, names):
        def running():
            if not launched.running():
                raise AssertionError(f"the launch ended:\n{launched.output()}")
            try:
                service = rospy.ServiceProxy(
                    f"{namespace}/controller_manager/list_controllers", ListControllers
                )
                states = {item.name: item.state for item in service().controller}
            except rospy.ServiceException:
                return False
            return all(states.get(name) == "running" for name in names)

        wait_until(running, f"{', '.join(names)} running in {namespace or '/'}", START_LIMIT)

    def state(self, model, gazebo="/gazebo"):
        answer = rospy.ServiceProxy(gazebo + "/get_model_state", GetModelState)(model, "")
        self.assertTrue(answer.success, answer.status_message)
        return answer

    def record(self, topic, kind):
        recorder = Recorder(topic, kind)
        self.addCleanup(recorder.close)
        return recorder

    def publisher(self, topic, kind):
        publisher = rospy.Publisher(topic, kind, queue_size=10)
        self.addCleanup(publisher.unregister)
        wait_connected(publisher, topic)
        return publisher

    def assert_quiet(self, launched):
        self.assertEqual(faults(launched.output()), [])

    def test_server_and_client_started_by_hand(self):
        launched = self.launch("server_and_client.launch")
        self.wait_running(
            launched, "/rover_7", ("joint_state_controller", "rear_left_wheel_controller")
        )
        start = self.state("rover_7")
        self.assertAlmostEqual(start.pose.position.x, 1.0, delta=0.01)
        self.assertAlmostEqual(start.pose.position.y, -0.5, delta=0.01)
        self.assertAlmostEqual(yaw_of(start.pose.orientation), math.pi / 2.0, delta=0.01)
        states = self.record("/rover_7/joint_states", JointState)
        self.publisher("/rover_7/rear_left_wheel_controller/command", Float64).publish(5.0)
        wait_until(
            lambda: (
                states.last
                and states.last.velocity[states.last.name.index("rear_left_wheel_joint")] > 4.5
            ),
            "the wheel turning",
        )
        messages = states.wait_count(len(states.messages) + 10)
        self.assertAlmostEqual(
            (messages[-1].header.stamp - messages[0].header.stamp).to_sec() / 0.04,
            len(messages) - 1,
            delta=2.0,
            msg="25 messages a second of simulated time",
        )
        self.assert_quiet(launched)

    def test_paused_start_with_a_cart_from_a_file(self):
        launched = self.launch("paused_start.launch")
        self.wait_running(launched, "", ("joint_state_controller", "cart_drive"))
        world = rospy.ServiceProxy("/gazebo/get_world_properties", GetWorldProperties)
        wanted = {"third_bench", "bench_by_the_gate", "campus_sign"}
        wait_until(lambda: wanted <= set(world().model_names), f"models {wanted}")
        bench = self.state("third_bench").pose.position
        self.assertAlmostEqual(bench.x, 4.0, places=3)
        self.assertAlmostEqual(bench.y, -3.0, places=3)
        odometry = self.record("/cart_drive/odom", Odometry)
        command = self.publisher("/cart_drive/cmd_vel", Twist)
        twist = Twist()
        twist.linear.x, twist.angular.z = 0.4, 0.5
        sleep_sim(0.5)
        for _ in range(20):  # the controller stops on its own when commands stay away
            command.publish(twist)
            sleep_sim(0.1)
        measured = odometry.last.twist.twist
        self.assertAlmostEqual(measured.linear.x, 0.4, delta=0.02)
        self.assertAlmostEqual(measured.angular.z, 0.5, delta=0.05)
        true = self.state("cart").twist
        self.assertAlmostEqual(math.hypot(true.linear.x, true.linear.y), 0.4, delta=0.04)
        buffer = tf2_ros.Buffer()
        self.addCleanup(tf2_ros.TransformListener(buffer).unregister)
        wait_until(
            lambda: buffer.can_transform("odom", "left_wheel", rospy.Time(0)),
            "odom -> left_wheel in TF",
        )
        self.assertIn("lost_cover.STL", launched.output())
        self.assert_quiet(launched)

    def test_everything_in_a_namespace_with_effort_controllers_from_a_yaml_file(self):
        launched = self.launch("namespaced_world.launch")
        shocks = [
            f"{end}_{side}_shock_ctrlr" for end in ("front", "rear") for side in ("left", "right")
        ]
        self.wait_running(
            launched,
            "/old_buggy",
            ("joint_state_controller", "left_axle_ctrlr", "right_axle_ctrlr", *shocks),
        )
        for shock in shocks:
            self.publisher(f"/old_buggy/{shock}/command", Float64).publish(0.0)
        sleep_sim(1.5)
        # the body's weight on four springs of p = 800 N/m: wheel radius + ride height - sag
        sag = 3.0 * 9.81 / 4.0 / 800.0
        state = self.state("old_buggy", "/old_buggy/gazebo")
        self.assertAlmostEqual(state.pose.position.z, 0.08 + 0.03 - sag, delta=0.002)
        for side in ("left", "right"):
            self.publisher(f"/old_buggy/{side}_axle_ctrlr/command", Float64).publish(5.0)
        sleep_sim(2.0)
        twist = self.state("old_buggy", "/old_buggy/gazebo").twist.linear
        self.assertAlmostEqual(math.hypot(twist.x, twist.y), 5.0 * 0.08, delta=0.02)
        self.assert_quiet(launched)
