"""A package in the usual Gazebo style: builds, comes up from its own launch file, and drives."""

import math
import time
import unittest

import rosgraph
import rospy
import tf2_ros
from ackermann_msgs.msg import AckermannDrive, AckermannDriveStamped
from controller_manager_msgs.srv import ListControllers
from drop_in_workspace import Launched, Workspace, master_answers, master_port
from gazebo_msgs.srv import GetModelState, GetWorldProperties
from nav_msgs.msg import Odometry
from sensor_msgs.msg import CameraInfo, Image
from sim_client import (
    START_LIMIT,
    Recorder,
    faults,
    sleep_sim,
    wait_connected,
    wait_until,
    yaw_of,
)

CONTROLLERS = (
    "joint_state_controller",
    "rear_left_wheel_controller",
    "rear_right_wheel_controller",
    "front_left_steering_controller",
    "front_right_steering_controller",
    "mast_controller",
)
WHEELBASE, WHEEL_RADIUS = 0.36, 0.08  # [m]
SPEED, STEERING = 0.8, 0.3  # [m/s], [rad]
SLIPPING = 0.83  # of the bicycle's yaw rate: what Gazebo's solver makes of such a car


class DropIn(unittest.TestCase):
    """Builds once, launches once, and checks the interfaces of the package."""

    @classmethod
    def setUpClass(cls):
        cls.workspace = Workspace()
        cls.addClassCleanup(cls.workspace.close)
        status, cls.build_output = cls.workspace.build()
        if status != 0:
            raise AssertionError(f"the package does not build:\n{cls.build_output}")
        cls.launched = Launched(cls.workspace, "campus.launch", master_port())
        cls.launched.__enter__()
        cls.addClassCleanup(cls.launched.__exit__, None, None, None)
        cls.wait_for_master()
        rospy.init_node("drop_in_test")
        cls.addClassCleanup(rospy.signal_shutdown, "the test is over")
        cls.truth = Recorder("/campus_rover/ground_truth", Odometry)
        cls.wait_for_controllers()
        cls.drive = rospy.Publisher(
            "/campus_rover/ackermann_cmd", AckermannDriveStamped, queue_size=10
        )
        wait_connected(cls.drive, "the package's own node")

    @classmethod
    def wait_for_master(cls):
        end = time.monotonic() + START_LIMIT
        while not master_answers() or not rosgraph.Master("/drop_in_test").hasParam(
            "/use_sim_time"
        ):
            if time.monotonic() > end or not cls.launched.running():
                raise AssertionError(f"the launch does not come up:\n{cls.launched.output()}")
            time.sleep(0.05)

    @classmethod
    def states(cls):
        service = rospy.ServiceProxy(
            "/campus_rover/controller_manager/list_controllers", ListControllers
        )
        try:
            return {item.name: item.state for item in service().controller}
        except rospy.ServiceException:
            return {}

    @classmethod
    def wait_for_controllers(cls):
        try:
            wait_until(
                lambda: all(cls.states().get(name) == "running" for name in CONTROLLERS),
                "all controllers running",
                START_LIMIT,
            )
        except AssertionError as error:
            raise AssertionError(f"{error}; seen {cls.states()}\n{cls.launched.output()}") from None

    def tearDown(self):
        self.command(0.0, 0.0)

    def command(self, speed, steering):
        self.drive.publish(
            AckermannDriveStamped(drive=AckermannDrive(speed=speed, steering_angle=steering))
        )

    def record(self, topic, kind):
        recorder = Recorder(topic, kind)
        self.addCleanup(recorder.close)
        return recorder

    def test_build_generates_the_package_s_message(self):
        self.assertIn("RoverStatus", self.build_output)

    def test_world_has_the_package_s_own_models(self):
        names = rospy.ServiceProxy("/gazebo/get_world_properties", GetWorldProperties)().model_names
        self.assertLessEqual(
            {
                "ground_plane",
                "bench_by_the_gate",
                "bench_by_the_pond",
                "campus_sign",
                "library_wall",
                "campus_rover",
            },
            set(names),
        )
        bench = rospy.ServiceProxy("/gazebo/get_model_state", GetModelState)(
            "bench_by_the_gate", "world"
        )
        self.assertTrue(bench.success, bench.status_message)
        self.assertAlmostEqual(bench.pose.position.y, 3.0, places=3)
        self.assertAlmostEqual(yaw_of(bench.pose.orientation), 0.3, places=3)

    def test_drives_the_circle_of_a_bicycle(self):
        self.command(SPEED, STEERING)
        sleep_sim(1.5)
        self.truth.clear()
        sleep_sim(2.0)
        first, *_, last = self.truth.messages
        twist = last.twist.twist
        speed = math.hypot(twist.linear.x, twist.linear.y)
        seconds = (last.header.stamp - first.header.stamp).to_sec()
        turn = math.remainder(
            yaw_of(last.pose.pose.orientation) - yaw_of(first.pose.pose.orientation), 2.0 * math.pi
        )
        # the middle of the car, WHEELBASE / 2 ahead of the rear axle, is faster than that
        curvature = math.tan(STEERING) / WHEELBASE
        rear_speed = speed / math.hypot(1.0, curvature * WHEELBASE / 2.0)
        self.assertAlmostEqual(rear_speed, SPEED, delta=0.08 * SPEED)
        wanted = SLIPPING * SPEED * curvature
        self.assertAlmostEqual(turn / seconds, wanted, delta=0.08 * wanted)

    def test_camera(self):
        image = self.record("/campus_rover/front_camera/image_raw", Image)
        info = self.record("/campus_rover/front_camera/camera_info", CameraInfo)
        pictures = image.wait_count(4, START_LIMIT)
        picture = pictures[-1]
        self.assertEqual((picture.width, picture.height), (320, 200))
        self.assertEqual(picture.header.frame_id, "camera_link_optical")
        self.assertEqual(len(picture.data), 320 * 200 * 3)
        period = (pictures[-1].header.stamp - pictures[0].header.stamp).to_sec() / 3.0
        self.assertGreaterEqual(period, 0.099, "10 Hz, less when pictures take longer")
        focal = 320 / (2.0 * math.tan(1.3962634 / 2.0))
        self.assertAlmostEqual(info.wait_count(1)[0].K[0], focal, places=3)

    def test_tf_reaches_the_camera(self):
        buffer = tf2_ros.Buffer()
        self.addCleanup(tf2_ros.TransformListener(buffer).unregister)
        found = wait_until(
            lambda: (
                buffer.can_transform("base_footprint", "camera_link_optical", rospy.Time(0))
                and buffer.lookup_transform("base_footprint", "camera_link_optical", rospy.Time(0))
            ),
            "the camera's transform",
        )
        self.assertAlmostEqual(found.transform.translation.z, 0.14 + 0.06 + 0.3, places=3)

    def test_what_is_unknown_is_one_warning(self):
        text = self.launched.output()
        self.assertEqual(text.count("libcampus_headlights.so"), 1)
        self.assertEqual(faults(text), [])
