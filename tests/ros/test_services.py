"""The services and topics of gazebo_ros on a graph: each is there, and what ROS alone shows."""

import math
import unittest

import rospy
from dynamic_reconfigure.client import Client
from gazebo_msgs import srv
from gazebo_msgs.msg import (
    LinkState,
    LinkStates,
    ModelState,
    ModelStates,
    ODEJointProperties,
    PerformanceMetrics,
)
from geometry_msgs.msg import Point, Pose, Quaternion, Twist, Vector3
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Log
from sim_client import START_LIMIT, Recorder, wait_connected, wait_until
from stepping import Time

LAUNCH = """<launch>
  <include file="$(find gazebo_ros)/launch/empty_world.launch">
    <arg name="gui" value="false"/>
  </include>
  <param name="robot_description" textfile="$(find paddock_tests)/ros/models/small_car.urdf"/>
  <node name="spawn_car" pkg="gazebo_ros" type="spawn_model" output="screen"
        args="-urdf -param robot_description -model car -z 0.06 -J front_left_joint 0.7"/>
  <node name="spawn_box" pkg="gazebo_ros" type="spawn_model" output="screen"
        args="-sdf -file $(find paddock_tests)/ros/models/box.sdf -model box -wait car
              -reference_frame car -y 3 -z 5"/>
  <param name="/gazebo/pub_clock_frequency" value="50.0"/>
</launch>
"""

UNTURNED = Quaternion(0, 0, 0, 1)
HOME = Pose(Point(0, 3, 5), UNTURNED)


def call(name, kind, *values):
    """Calls a service below /gazebo."""
    rospy.wait_for_service("/gazebo/" + name, timeout=START_LIMIT)
    return rospy.ServiceProxy("/gazebo/" + name, kind)(*values)


class Services(unittest.TestCase):
    """Without gravity. What each service does, bit by bit: src/bullet_bridge/test, without ROS."""

    @classmethod
    def setUpClass(cls):
        wait_until(
            lambda: (
                {"car", "box"}
                <= set(call("get_world_properties", srv.GetWorldProperties).model_names)
            ),
            "car and box",
            START_LIMIT,
        )
        cls.log = Recorder("/rosout", Log)
        cls.spawned_at = wait_until(cls.placed_by_the_spawner, "spawn_model -J to do its work")
        cls.ok(cls, cls.set_physics(cls))

    @staticmethod
    def placed_by_the_spawner():
        angle = call("get_joint_properties", srv.GetJointProperties, "front_left_joint").position[0]
        return angle if abs(angle) > 0.3 else None

    def setUp(self):
        for name, pose in (("box", HOME), ("car", Pose(Point(0, 0, 2), UNTURNED))):
            state = ModelState(name, pose, Twist(), "world")
            self.ok(call("set_model_state", srv.SetModelState, state))

    def box(self):
        return self.ok(call("get_link_state", srv.GetLinkState, "box::link", "")).link_state

    def ok(self, answer):
        assert answer.success, answer.status_message
        return answer

    def set_physics(self, step=0.001, gravity=0.0):
        config = call("get_physics_properties", srv.GetPhysicsProperties).ode_config
        values = step, 1.0 / step, Vector3(0, 0, gravity), config
        return call("set_physics_properties", srv.SetPhysicsProperties, *values)

    def test_the_step_changes_while_a_car_publishes(self):
        """Periods of its plugins go on in simulated time, which never goes back."""
        odometry = Recorder("/odom", Odometry)
        for step in (0.004, 0.0005, 0.001):
            self.ok(self.set_physics(step))
            after = call("get_physics_properties", srv.GetPhysicsProperties)
            self.assertAlmostEqual(after.time_step, step, places=9)
            count = len(odometry.messages)
            wait_until(lambda: len(odometry.messages) > count + 20, f"odometry with {step} s")
        stamps = [message.header.stamp.to_sec() for message in odometry.messages]
        gaps = [late - early for early, late in zip(stamps, stamps[1:])]
        self.assertGreater(min(gaps), 0.0)
        self.assertAlmostEqual(sorted(gaps)[len(gaps) // 2], 0.02, places=6)
        self.assertLess(max(gaps), 0.045)
        odometry.close()

    def test_physics_can_be_reconfigured(self):
        client = Client("/gazebo", timeout=120.0)
        before = client.get_configuration()
        self.assertEqual((before["time_step"], before["sor_pgs_iters"]), (0.001, 50))
        after = client.update_configuration({"gravity_z": -1.5, "sor_pgs_iters": 60})
        self.assertEqual((after["gravity_z"], after["sor_pgs_iters"]), (-1.5, 60))
        properties = call("get_physics_properties", srv.GetPhysicsProperties)
        self.assertEqual((properties.gravity.z, properties.ode_config.sor_pgs_iters), (-1.5, 60))
        after = client.update_configuration({"time_step": 5.0, "gravity_z": -1.0})
        self.assertEqual(
            (after["time_step"], after["gravity_z"]),
            (0.001, -1.5),
            "refused as a whole, with the old values",
        )
        client.update_configuration({"gravity_z": 0.0, "sor_pgs_iters": 50})
        client.close()

    def test_state_topics_move_things(self):
        for name, kind, message in (
            ("set_model_state", ModelState,
             ModelState("box", Pose(Point(4, 4, 4), UNTURNED), Twist(), "")),
            ("set_link_state", LinkState,
             LinkState("box::link", Pose(Point(5, 5, 5), UNTURNED), Twist(), "world")),
        ):  # fmt: skip
            publisher = rospy.Publisher("/gazebo/" + name, kind, queue_size=1)
            wait_connected(publisher, name)
            publisher.publish(message)
            wait_until(
                lambda message=message: (
                    abs(self.box().pose.position.x - message.pose.position.x) < 1e-6
                ),
                f"the box moved by {name}",
            )

    def test_states_and_performance_are_published_for_subscribers(self):
        models, links, metrics = (
            Recorder(f"/gazebo/{name}", kind)
            for name, kind in (("model_states", ModelStates), ("link_states", LinkStates),
                               ("performance_metrics", PerformanceMetrics))
        )  # fmt: skip
        odometry = Recorder("/odom", Odometry)
        self.assertLessEqual({"car", "box", "ground_plane"}, set(models.next().name))
        names = links.next().name
        self.assertLessEqual({"box::link", "car::base_link", "car::rear_left"}, set(names))
        self.assertNotIn("car::laser", names, "fixed joints are merged, as in Gazebo")
        time = Time(topics=[models.topic])
        models.clear()
        time.go(1.0)
        self.assertAlmostEqual(len(models.wait_count(940)), 1000, delta=60)  # one a step
        time.close()
        sensors = metrics.next().sensors
        self.assertTrue(any("odom" in sensor.name for sensor in sensors), sensors)
        for recorder in (models, links, metrics, odometry):
            recorder.close()

    def test_each_of_the_others_answers(self):
        """With success, or without and with the reason in the log."""
        sun = srv.SetLightPropertiesRequest(light_name="sun", attenuation_constant=1.0)
        link = LinkState("box::link", HOME, Twist(), "box::link")
        nowhere = ModelState("box", Pose(Point(math.nan, 0, 0), UNTURNED), Twist(), "world")
        for name, kind, values, reason in (
            ("get_light_properties", srv.GetLightProperties, ["sun"], None),
            ("set_light_properties", srv.SetLightProperties, [sun], None),
            ("delete_light", srv.DeleteLight, ["sun"], None),
            ("delete_light", srv.DeleteLight, ["sun"], "sun"),
            ("set_link_state", srv.SetLinkState, [link], None),
            ("get_model_state", srv.GetModelState, ["car", "box::link"], None),
            ("get_model_state", srv.GetModelState, ["box", "moon"], "moon"),
            ("set_model_state", srv.SetModelState, [nowhere], "nan"),
            ("get_model_properties", srv.GetModelProperties, ["car"], None),
            ("get_link_properties", srv.GetLinkProperties, ["box::link"], None),
            ("set_link_properties", srv.SetLinkProperties,
             ["box::link", Pose(), True, 2.0, 0.02, 0, 0, 0.03, 0, 0.04], None),
            ("set_joint_properties", srv.SetJointProperties,
             ["front_left_joint", ODEJointProperties(damping=[0.0])], None),
            ("set_model_configuration", srv.SetModelConfiguration,
             ["car", "", ["nose", "front_right_joint"], [1.0, -0.3]], None),
            ("delete_model", srv.DeleteModel, ["ghost"], "ghost"),
        ):  # fmt: skip
            answer = call(name, kind, *values)
            self.assertEqual(answer.success, reason is None, (name, answer.status_message))
            if reason:
                wait_until(
                    lambda words=reason: any(words in line.msg for line in self.log.messages),
                    f"{reason!r} in the log, the answer was {answer.status_message!r}",
                )
