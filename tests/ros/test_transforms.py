"""The simulator's own transforms: those of robot_state_publisher and odom_tf, to 1e-6."""

import unittest

import rospy
from nav_msgs.msg import Odometry
from sensor_msgs.msg import JointState
from sim_client import START_LIMIT, Recorder, command_publishers, wait_until
from tf2_msgs.msg import TFMessage

from bullet_bridge.srv import Step

LAUNCH = """<launch>
  <include file="$(find track_model)/launch/world.launch">
    <arg name="track" value="easy"/>
    <arg name="headless" value="true"/>
    <arg name="lockstep" value="true"/>
    <arg name="state_publisher" value="bridge"/>
    <arg name="state_rate" value="1000"/>
  </include>
  <node name="reference" pkg="robot_state_publisher" type="robot_state_publisher">
    <param name="publish_frequency" value="1000"/>
    <remap from="joint_states" to="/racecar/joint_states"/>
    <remap from="/tf" to="/reference/tf"/>
    <remap from="/tf_static" to="/reference/tf_static"/>
  </node>
</launch>
"""

BATCH, BATCHES = 50, 40  # steps of 1 ms: 2 s of driving
EXACT = 1e-6  # [m], of quaternions
ENOUGH = 300  # transforms of six joints that both have


def numbers(transform):
    """Translation and rotation of a geometry_msgs/Transform; q and -q are one rotation."""
    place, turn = transform.translation, transform.rotation
    sign = -1.0 if turn.w < 0.0 else 1.0
    return [
        place.x,
        place.y,
        place.z,
        *(sign * part for part in (turn.x, turn.y, turn.z, turn.w)),
    ]


def by_time(recorder):
    """The recorded transforms: {(stamp, child frame): TransformStamped}."""
    return {
        (item.header.stamp, item.child_frame_id): item
        for message in recorder.messages
        for item in message.transforms
    }


def by_name(recorder):
    """The newest message's transforms by their child frames."""
    return {item.child_frame_id: item for item in recorder.last.transforms}


class Transforms(unittest.TestCase):
    """Drives a bend, compares what came."""

    @classmethod
    def setUpClass(cls):
        cls.reference, cls.reference_static = (
            Recorder(f"/reference/{name}", TFMessage) for name in ("tf", "tf_static")
        )
        cls.own, cls.own_static = (Recorder(f"/{name}", TFMessage) for name in ("tf", "tf_static"))
        cls.odometry = Recorder("/racecar/odom", Odometry)
        rospy.wait_for_service("/gazebo/step", START_LIMIT)
        cls.step = rospy.ServiceProxy("/gazebo/step", Step, persistent=True)
        wait_until(cls.made(lambda: len(cls.odometry.messages) > 1), "odometry", START_LIMIT)
        publishers, states = command_publishers(), Recorder("/racecar/joint_states", JointState)

        def drives():
            for name, publisher in publishers.items():
                publisher.publish(0.3 if "hinge" in name else 15.0)
            return states.last is not None and max(states.last.velocity) > 10.0

        wait_until(cls.made(drives), "turning wheels", START_LIMIT)
        states.close()
        wait_until(cls.made(lambda: by_time(cls.own) and by_time(cls.reference)), "transforms")
        for _ in range(BATCHES):
            cls.step(BATCH, [], [])
        # robot_state_publisher passes over states that come faster than it gets a processor
        wait_until(cls.made(lambda: len(cls.shared()) > ENOUGH), "transforms of both", START_LIMIT)

    @classmethod
    def shared(cls):
        """Keys of by_time() that both have."""
        return by_time(cls.own).keys() & by_time(cls.reference).keys()

    @classmethod
    def made(cls, condition):
        """Steps before each look at a condition."""

        def look():
            cls.step(BATCH, [], [])
            return condition()

        return look

    def assert_same(self, ours, theirs):
        self.assertEqual(ours.header.frame_id, theirs.header.frame_id)
        for mine, other in zip(numbers(ours.transform), numbers(theirs.transform)):
            self.assertAlmostEqual(mine, other, delta=EXACT)

    def test_moving_joints(self):
        end = rospy.Time.from_sec(rospy.get_time() - 0.5)
        wait_until(lambda: any(stamp > end for stamp, _ in by_time(self.reference)), "all of it")
        ours, theirs = by_time(self.own), by_time(self.reference)
        names = {child for _, child in theirs}
        self.assertEqual(len(names), 6)
        shared = ours.keys() & theirs.keys()
        self.assertGreater(len(shared), ENOUGH)
        for key in shared:
            self.assert_same(ours[key], theirs[key])
        wheel = "left_rear_wheel"
        turns = {round(numbers(ours[key].transform)[6], 3) for key in shared if key[1] == wheel}
        self.assertGreater(len(turns), 20, "the wheel turned meanwhile")

    def test_fixed_joints(self):
        ours, theirs = by_name(self.own_static), by_name(self.reference_static)
        self.assertEqual(set(ours), set(theirs))
        self.assertGreater(len(theirs), 2)
        for name, transform in theirs.items():
            self.assert_same(ours[name], transform)
