"""Paddock/Robot-v0 of a launch file is the launched graph: the same commands at the same steps, the
same messages, to the bit."""

import os
import subprocess
import tempfile
import unittest
import warnings

import networks
import numpy as np
import rospkg
import rospy
from geometry_msgs.msg import Twist, Vector3Stamped
from launches import wait_subscribed
from nav_msgs.msg import Odometry
from paddock_common.process import stop_session
from paddock_gym.driver.robot import Source
from paddock_gym.envs.describe import policy_description
from paddock_gym.envs.robot import RobotEnv
from paddock_gym.policy.onnx_policy import OnnxPolicy
from sensor_msgs import point_cloud2
from sensor_msgs.msg import (
    Image,
    Imu,
    JointState,
    LaserScan,
    NavSatFix,
    PointCloud,
    PointCloud2,
    Range,
)
from sim_client import START_LIMIT, Recorder, wait_connected, wait_running, wait_until
from std_msgs.msg import Float64
from stepping import Time

LAUNCH = """<launch>
  <include file="$(find gazebo_ros)/launch/empty_world.launch">
    <arg name="gui" value="false"/>
    <arg name="lockstep" value="true"/>
  </include>
  <param name="cart_description" textfile="$(find paddock_gym)/examples/cart.urdf"/>
  <node name="spawn_cart" pkg="gazebo_ros" type="spawn_model" output="screen"
        args="-urdf -param cart_description -model cart -x -1.5 -z 0.1"/>
  <rosparam command="load" file="$(find paddock_tests)/ros/lidar_bot_control.yaml"/>
  <node name="spawn_bot" pkg="gazebo_ros" type="spawn_model" output="screen"
        args="-urdf -file $(find paddock_tests)/ros/lidar_bot.urdf -model bot -z 0.08"/>
  <node name="bot_spawner" pkg="controller_manager" type="spawner" ns="/bot" output="screen"
        args="--timeout 120 joint_state_controller left right"/>
  <node name="spawn_mast" pkg="gazebo_ros" type="spawn_model" output="screen"
        args="-urdf -file $(find paddock_tests)/ros/mast_bot.urdf -model mast -x 1.5 -z 0.06 -Y 3"/>
  <node name="listener" pkg="rostopic" type="rostopic" args="list" output="log"/>
</launch>
"""
POSE = {"position": "xyz", "orientation": "xyzw"}
ACTIONS = 12
LIMITS = 0.5, 1.0, 6.0, 6.0, 0.3, 0.3, 0.5  # of the random actions
PERIOD = 0.1  # [s]


def vector(message, letters):
    """Numbers of a Vector3, Point or Quaternion."""
    return [getattr(message, letter) for letter in letters]


def arrays(message):
    """Arrays of a message by the names that the gym's have."""
    if isinstance(message, LaserScan):
        return {"ranges": message.ranges, "intensities": message.intensities}
    if isinstance(message, JointState):
        rows = {name: getattr(message, name) for name in ("position", "velocity", "effort")}
        return {name: row for name, row in rows.items() if row}
    if isinstance(message, Imu):
        return {
            "orientation": vector(message.orientation, "xyzw"),
            "angular_velocity": vector(message.angular_velocity, "xyz"),
            "linear_acceleration": vector(message.linear_acceleration, "xyz"),
        }
    if isinstance(message, Image):
        kind = np.float32 if message.encoding == "32FC1" else np.uint8
        pixels = np.frombuffer(message.data, kind).reshape(message.height, message.width, -1)
        return {"data": pixels[..., 0] if message.encoding == "32FC1" else pixels}
    if isinstance(message, PointCloud):
        return {"points": [vector(point, "xyz") for point in message.points]}
    if isinstance(message, PointCloud2):
        is_dense = message.height == 1
        points = point_cloud2.read_points(message, ("x", "y", "z"), skip_nans=is_dense)
        return {"points": np.nan_to_num(np.array(list(points), np.float32), nan=0.0)}
    if isinstance(message, NavSatFix):
        return {"fix": vector(message, ("latitude", "longitude", "altitude"))}
    if isinstance(message, Range):
        return {"range": [message.range]}
    if isinstance(message, Vector3Stamped):
        return {"vector": vector(message.vector, "xyz")}
    pose, twist = message.pose.pose, message.twist.twist
    rows = {name: vector(getattr(pose, name), letters) for name, letters in POSE.items()}
    rows.update({name: vector(getattr(twist, name), "xyz") for name in ("linear", "angular")})
    return rows


TOPICS = {
    "/scan": LaserScan,
    "/imu": Imu,
    "/odom": Odometry,
    "/joint_states": JointState,
    "/camera/image_raw": Image,
    "/bot/scan": LaserScan,
    "/bot/odom": Odometry,
    "/bot/joint_states": JointState,
    "/mast/kinect/image": Image,
    "/mast/kinect/depth": Image,
    "/mast/kinect/points": PointCloud2,
    "/mast/velodyne": PointCloud2,
    "/mast/block": PointCloud,
    "/mast/sonar": Range,
    "/mast/fix": NavSatFix,
    "/mast/fix_velocity": Vector3Stamped,
    "/mast/magnetic": Vector3Stamped,
    "/mast/odom": Odometry,
    "/mast/truth": Odometry,
}
TWISTS = ("/cmd_vel", "/mast/cmd_vel")
COMMANDS = ("/cmd_vel", "/bot/left/command", "/bot/right/command", "/mast/cmd_vel")


class RobotGym(unittest.TestCase):
    """Both robots drive in the graph and in the environment."""

    def test_the_same_messages_to_the_bit_and_then_the_node_of_a_policy_commands_it(self):
        self.check_messages()
        self.check_policy()

    def check_messages(self):
        """From the beginning of the world on."""
        wait_running("/bot", 3)
        recorders = {name: Recorder(name, kind) for name, kind in TOPICS.items()}
        publishers = [
            rospy.Publisher(name, Twist if name in TWISTS else Float64, queue_size=1)
            for name in COMMANDS
        ]
        for publisher in publishers:
            wait_connected(publisher, publisher.name)
        time = Time(COMMANDS, TOPICS, rospy.get_name())
        env = self.environment()
        sources = policy_description(env).sources
        self.sources = {name: Source(**options) for name, options in sources.items()}
        env.reset(seed=1)
        rng, compared = np.random.default_rng(5), dict.fromkeys(TOPICS, 0)
        for _ in range(ACTIONS):
            action = rng.uniform(-1.0, 1.0, 7).astype(np.float32) * LIMITS
            env.step(action)
            twist, push = Twist(), Twist()
            numbers = env.actions.numbers(action)
            twist.linear.x, twist.angular.z = numbers[:2]
            push.linear.x, push.linear.y, push.angular.z = numbers[4:]
            messages = twist, *map(Float64, numbers[2:4]), push
            for publisher, message in zip(publishers, messages):
                publisher.publish(message)
            time.go(PERIOD, 1)
            self.assertAlmostEqual(time.now, env.world.world.time, 9)
            for name, recorder in recorders.items():
                compared[name] += self.compare(env, name, recorder)
        self.assertEqual(min(compared.values()), ACTIONS, compared)
        env.close()

    def check_policy(self):
        urdf = os.path.join(rospkg.RosPack().get_path("paddock_gym"), "examples", "cart.urdf")
        env = RobotEnv(urdf=urdf, action="cmd_vel", observation="scan", scaled=True)
        about = policy_description(env)
        env.close()
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "policy.onnx")
            weights = np.random.default_rng(3).normal(0.0, 0.3, (2, 24))
            networks.write(path, weights, (0.1, 0.0), about, (24,))
            policy, driven = OnnxPolicy(path, "robot"), set()
            source = Source(**about.sources["scan"])
            scans, commands = Recorder("/scan", LaserScan), Recorder("/cmd_vel", Twist)
            words = ["roslaunch", "--wait", "paddock_gym", "drive_by.launch", f"policy:={path}"]
            launch = subprocess.Popen(words, stdin=subprocess.DEVNULL, start_new_session=True)
            try:
                wait_subscribed(("/scan",), "/robot_driver")
                time = Time(topics=("/scan",), node="/robot_driver")
                time.go(2.0 * PERIOD)  # a timer of rospy begins after time has begun
                for _ in range(ACTIONS):
                    before = len(commands.messages)
                    time.go(PERIOD)
                    time.latest(scans, 0.05)
                    got = commands.wait_count(before + 1, START_LIMIT)[-1]
                    possible = []
                    for scan in scans.messages[-6:]:
                        source.take(scan)
                        [(topic, _, numbers)] = policy.command({"scan": source.read()})
                        possible.append(numbers)
                    self.assertEqual(topic, "/cmd_vel")
                    self.assertIn([got.linear.x, got.angular.z], possible)
                    driven.add(got.linear.x)
            finally:
                stop_session(launch, START_LIMIT)
        self.assertEqual(policy.description.text(), about.text())
        self.assertGreater(len(driven), 1)  # it follows what is seen

    def environment(self):
        """The environment of the launch file, observed as the graph is."""
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "robots.launch")
            with open(path, "w", encoding="utf-8") as file:
                file.write(LAUNCH)
            with warnings.catch_warnings(record=True) as told:
                warnings.simplefilter("always")
                env = RobotEnv(
                    path, action=COMMANDS, observation=tuple(TOPICS), settle=0.0, vary=()
                )
        self.assertIn("rostopic/rostopic", str(told[-1].message))
        return env

    def compare(self, env, name, recorder):
        """Compares the last messages of a topic; 1 where there is one."""
        stamp = env.stamp(name)

        def there():
            last = recorder.last
            return last is not None and last.header.stamp.to_sec() > stamp - 1e-6 and last

        message = wait_until(there, f"{name} at {stamp}", START_LIMIT)
        self.assertAlmostEqual(message.header.stamp.to_sec(), stamp, 8, name)
        fields = env.world.topics[name].fields
        wanted = arrays(message)
        self.assertEqual(set(wanted), set(fields), name)
        for field, values in wanted.items():
            values = np.asarray(values, fields[field].dtype)
            if field == "points" and len(values) < len(fields[field]):  # zeros behind what was hit
                values = np.vstack([values.reshape(-1, 3), np.zeros_like(fields[field])])
                values = values[: len(fields[field])]
            same = np.array_equal(values, fields[field], equal_nan=True)
            self.assertTrue(same, f"{name} {field} at {stamp}: {values} and {fields[field]}")
        self.sources[name].take(message)
        seen = env.agent.observed[name].read()
        self.assertTrue(np.array_equal(self.sources[name].read(), seen, equal_nan=True), name)
        return 1
