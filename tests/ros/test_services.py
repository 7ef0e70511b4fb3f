"""The services and topics of gazebo_ros: effects, and errors of bad input."""

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
from geometry_msgs.msg import Point, Pose, Quaternion, Twist, Vector3, Wrench
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Log
from sim_client import START_LIMIT, Recorder, sleep_sim, wait_connected, wait_until
from std_msgs.msg import ColorRGBA
from std_srvs.srv import Empty
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

MASS = 2.0  # of the box [kg]
UNTURNED = Quaternion(0, 0, 0, 1)
HOME = Pose(Point(0, 3, 5), UNTURNED)


def call(name, kind=Empty, *values, **fields):
    """Calls a service below /gazebo."""
    rospy.wait_for_service("/gazebo/" + name, timeout=START_LIMIT)
    return rospy.ServiceProxy("/gazebo/" + name, kind)(*values, **fields)


class Services(unittest.TestCase):
    """Without gravity, so that the effect of a force is exact."""

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
        self.put_box(HOME)
        car = ModelState("car", Pose(Point(0, 0, 2), UNTURNED), Twist(), "world")
        self.ok(call("set_model_state", srv.SetModelState, car))  # what it did before: all gone

    def put_box(self, pose, twist=None):
        state = ModelState("box", pose, twist or Twist(), "world")
        self.ok(call("set_model_state", srv.SetModelState, state))

    def box(self, frame=""):
        answer = call("get_link_state", srv.GetLinkState, "box::link", frame)
        self.ok(answer)
        return answer.link_state

    def ok(self, answer):
        assert answer.success, answer.status_message
        return answer

    def refused(self, answer, *words, waits=True):
        """Each word is in the answer, or in the log where the answer is a text of gazebo_ros."""
        self.assertFalse(answer.success)
        for word in words:
            if word not in answer.status_message:
                wait_until(
                    lambda word=word: any(word in line.msg for line in self.log.messages),
                    f"{word!r} in the log, the answer was {answer.status_message!r}",
                )
        if waits:
            sleep_sim(0.02)  # and the world goes on

    def set_physics(self, step=0.001, rate=1000.0, gravity=0.0):
        config = call("get_physics_properties", srv.GetPhysicsProperties).ode_config
        values = step, rate, Vector3(0, 0, gravity), config
        return call("set_physics_properties", srv.SetPhysicsProperties, *values)

    def vector(self, value, expected, delta):
        for axis in "xyz":
            self.assertAlmostEqual(
                getattr(value, axis),
                getattr(expected, axis),
                delta=delta,
                msg=f"{axis} of {value} against {expected}",
            )

    # physics ----------------------------------------------------------------------------------
    def test_physics_properties_are_read_and_changed(self):
        now = self.ok(call("get_physics_properties", srv.GetPhysicsProperties))
        self.assertEqual((now.time_step, now.max_update_rate, now.pause), (0.001, 1000.0, False))
        time = self.steps()
        self.put_box(HOME)
        self.ok(self.set_physics(rate=2000.0, gravity=1.0))
        time.go(0.5)
        self.assertAlmostEqual(self.box().twist.linear.z, 0.5, delta=0.01)
        changed = call("get_physics_properties", srv.GetPhysicsProperties)
        self.assertEqual(changed.max_update_rate, 2000.0)
        self.refused(self.set_physics(rate=math.nan), "max_update_rate is nan", waits=False)
        self.ok(self.set_physics())

    def test_the_step_changes_while_a_car_publishes(self):
        """Periods of its plugins go on in simulated time, which never goes back."""
        odometry = Recorder("/odom", Odometry)
        for step in (0.004, 0.0005, 0.001):
            self.ok(self.set_physics(step, 1.0 / step))
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
        after = client.update_configuration({"time_step": 0.002, "gravity_z": 0.0})
        self.assertEqual((after["time_step"], after["gravity_z"]), (0.002, 0.0))
        after = client.update_configuration({"time_step": 5.0, "gravity_z": -1.0})
        self.assertEqual(
            (after["time_step"], after["gravity_z"]),
            (0.002, 0.0),
            "refused as a whole, with the old values",
        )
        unused = {"auto_disable_bodies": True, "sor_pgs_rms_error_tol": 0.5}
        after = client.update_configuration(unused)
        self.assertEqual({name: after[name] for name in unused}, unused, "as it was asked")
        config = call("get_physics_properties", srv.GetPhysicsProperties).ode_config
        self.assertEqual((config.auto_disable_bodies, config.sor_pgs_rms_error_tol), (False, 0.0))
        client.update_configuration({"time_step": 0.001, "sor_pgs_iters": 50})
        client.close()

    def test_lights_are_read_changed_and_deleted(self):
        seen = self.ok(call("get_light_properties", srv.GetLightProperties, "sun"))
        self.assertGreater(seen.diffuse.r, 0.0)
        request = srv.SetLightPropertiesRequest(light_name="sun", attenuation_constant=1.0)
        request.diffuse = ColorRGBA(0.2, 0.3, 0.4, 1.0)
        self.ok(call("set_light_properties", srv.SetLightProperties, request))
        seen = self.ok(call("get_light_properties", srv.GetLightProperties, "sun"))
        self.assertAlmostEqual(seen.diffuse.g, 0.3, places=6)
        self.assertEqual(seen.attenuation_constant, 1.0)
        self.ok(call("delete_light", srv.DeleteLight, "sun"))
        self.refused(call("get_light_properties", srv.GetLightProperties, "sun"), "light 'sun'")

    # states -----------------------------------------------------------------------------------
    def test_states_go_through_frames(self):
        turned = Pose(Point(1, 2, 3), Quaternion(0, 0, math.sqrt(0.5), math.sqrt(0.5)))
        self.put_box(turned, Twist(linear=Vector3(0.1, 0, 0)))
        self.vector(self.box().twist.linear, Vector3(0.1, 0, 0), 1e-6)
        seen = self.box("box").pose
        self.vector(seen.position, Point(0, 0, 0), 1e-9)
        seen = call("get_model_state", srv.GetModelState, "car", "box::link")
        self.assertAlmostEqual(seen.twist.linear.y, 0.1, delta=0.02)  # left along the box's axes
        self.put_box(turned)
        link = LinkState("box::link", Pose(Point(1, 0, 0), UNTURNED), Twist(), "box::link")
        self.ok(call("set_link_state", srv.SetLinkState, link))
        self.vector(self.box().pose.position, Point(1, 3, 3), 1e-6)

    def test_state_topics_move_things(self):
        for name, kind, message in (
            (
                "set_model_state",
                ModelState,
                ModelState("box", Pose(Point(4, 4, 4), UNTURNED), Twist(), ""),
            ),
            (
                "set_link_state",
                LinkState,
                LinkState("box::link", Pose(Point(5, 5, 5), UNTURNED), Twist(), "world"),
            ),
        ):
            publisher = rospy.Publisher("/gazebo/" + name, kind, queue_size=1)
            wait_connected(publisher, name)
            publisher.publish(message)
            wait_until(
                lambda message=message: (
                    abs(self.box().pose.position.x - message.pose.position.x) < 1e-6
                ),
                f"the box moved by {name}",
            )

    def test_what_is_wrong_is_refused_by_name(self):
        bad = Pose(Point(math.nan, 0, 0), UNTURNED)
        names = ["front_left_joint"]
        for name, kind, values, words in (
            ("set_link_state", srv.SetLinkState, [LinkState("box::nose", HOME, Twist(), "")],
             ("box::nose", "box::link")),
            ("set_link_state", srv.SetLinkState, [LinkState("box::link", bad, Twist(), "")],
             ("nan",)),
            ("get_link_state", srv.GetLinkState, ["box::link", "moon"], ("moon",)),
            ("get_model_state", srv.GetModelState, ["box", "moon"], ("moon",)),
            ("get_model_properties", srv.GetModelProperties, ["ghost"], ("ghost",)),
            ("get_link_properties", srv.GetLinkProperties, ["nose"], ("nose",)),
            ("get_joint_properties", srv.GetJointProperties, ["car::laser_joint"],
             ("laser_joint",)),
            ("set_model_configuration", srv.SetModelConfiguration, ["car", "", names, []],
             ("1 entries", "0")),
            ("apply_joint_effort", srv.ApplyJointEffort,
             ["nose", 1.0, rospy.Time(0), rospy.Duration(1)], ("nose",)),
        ):  # fmt: skip
            self.refused(call(name, kind, *values), *words)
        self.refused(self.wrench(body="ground_plane::link"), "static")
        call("clear_body_wrenches", srv.BodyRequest, "nose")  # answers, as upstream
        self.vector(self.box().pose.position, HOME.position, 1e-6)

    def test_states_are_published_for_subscribers(self):
        models, links = (
            Recorder("/gazebo/model_states", ModelStates),
            Recorder("/gazebo/link_states", LinkStates),
        )
        message = models.next()
        self.assertLessEqual({"car", "box", "ground_plane"}, set(message.name))
        place = message.pose[message.name.index("box")].position
        self.vector(place, HOME.position, 1e-6)
        names = links.next().name
        self.assertLessEqual({"box::link", "car::base_link", "car::rear_left"}, set(names))
        self.assertNotIn("car::laser", names, "fixed joints are merged, as in Gazebo")
        time = Time(topics=[models.topic])
        self.put_box(Pose(Point(7, 0, 7), UNTURNED))
        time.go(0.01)
        wait_until(  # none of before is still to come
            lambda: models.last.pose[models.last.name.index("box")].position.x > 6.9,
            "the box there",
        )
        models.clear()
        time.go(1.0)
        count = len(models.wait_count(900))  # one a step, as Gazebo's
        self.assertAlmostEqual(count, 1000, delta=60)
        time.close()
        models.close()
        links.close()

    def test_performance_is_published(self):
        odometry = Recorder("/odom", Odometry)
        metrics = Recorder("/gazebo/performance_metrics", PerformanceMetrics)
        begin = metrics.next().header.stamp
        metrics.clear()
        while metrics.newest.header.stamp < begin + rospy.Duration(1.0):
            metrics.next()
        before, count = begin, 0.0
        for message in metrics.messages:  # each of 0.2 s of wall time
            window, before = message.header.stamp - before, message.header.stamp
            rates = {sensor.name: sensor.sim_update_rate for sensor in message.sensors}
            name = next((name for name in rates if "odom" in name or "ground_truth" in name), None)
            self.assertIsNotNone(name, f"the sensor on /odom among {sorted(rates)}")
            count += rates[name] * window.to_sec()
            self.assertGreater(message.real_time_factor, 0.0)
        self.assertAlmostEqual(count / (before - begin).to_sec(), 50.0, delta=3.0)
        odometry.close()
        metrics.close()

    # forces -----------------------------------------------------------------------------------
    def wrench(self, force=(0, 0, 0), point=(0, 0, 0), start=0.0, duration=0.1, body="box::link"):
        wrench = Wrench(Vector3(*force), Vector3())
        values = Point(*point), wrench, rospy.Time(start), rospy.Duration(duration)
        return call("apply_body_wrench", srv.ApplyBodyWrench, body, "", *values)

    def steps(self):
        """Simulated time that only the test advances, from now on."""
        time = Time()
        self.addCleanup(time.close)
        return time

    def test_a_wrench_at_a_point_moves_and_turns(self):
        time = self.steps()
        self.ok(self.wrench(force=(0, 1, 0), point=(0.02, 0, 0)))
        time.go(0.3)
        self.vector(self.box().twist.linear, Vector3(0, 0.05, 0), 1e-4)
        self.vector(self.box().twist.angular, Vector3(0, 0, 0.02 * 0.1 / 0.04), 1e-4)

    def test_wrench_until_it_is_cleared(self):
        self.ok(self.wrench(force=(0, 0, 1), duration=-1))
        wait_until(lambda: self.box().twist.linear.z > 0.1, "the box to rise")
        call("clear_body_wrenches", srv.BodyRequest, "box::link")
        speed = self.box().twist.linear.z
        sleep_sim(0.2)
        self.assertAlmostEqual(self.box().twist.linear.z, speed, delta=1e-6)

    def test_wrench_in_the_future(self):
        time = self.steps()
        self.ok(self.wrench(force=(2, 0, 0), start=time.now + 0.5))
        time.go(0.49)
        self.assertEqual(self.box().twist.linear.x, 0.0)
        time.go(0.2)  # in the step at whose end it begins, too, as in Gazebo
        self.assertAlmostEqual(self.box().twist.linear.x, 0.101, delta=1e-4)

    # joints -----------------------------------------------------------------------------------
    def joint(self, name="front_left_joint"):
        return self.ok(call("get_joint_properties", srv.GetJointProperties, name))

    def test_joints_are_placed_by_spawn_model_and_configuration(self):
        self.assertAlmostEqual(self.spawned_at, 0.7, delta=0.2, msg="spawn_model -J")
        names, values = ["nose", "front_right_joint"], [1.0, -0.3]  # Gazebo skips those it lacks
        done = call("set_model_configuration", srv.SetModelConfiguration, "car", "", names, values)
        self.assertEqual(self.ok(done).status_message, "SetModelConfiguration: success")
        properties = self.joint("front_right_joint")
        self.assertAlmostEqual(properties.position[0], -0.3, delta=0.05)
        self.assertEqual(properties.type, properties.REVOLUTE)  # which gazebo_ros answers always

    def test_effort_spins_a_wheel_until_cleared(self):
        forever = rospy.Time(0), rospy.Duration(-1)  # in the air: only its own friction holds it
        wheel = "front_left_joint"
        answer = self.ok(call("apply_joint_effort", srv.ApplyJointEffort, wheel, 5.0, *forever))
        self.assertEqual(answer.status_message, "ApplyJointEffort: effort set")
        wait_until(
            lambda: any("clipped from 5 to 2" in line.msg for line in self.log.messages),
            "the warning of the clipped effort",
        )
        wait_until(lambda: self.joint().rate[0] > 5.0, "the wheel at 5 rad/s")
        call("clear_joint_forces", srv.JointRequest, "front_left_joint")
        fastest = self.joint().rate[0]
        wait_until(
            lambda: abs(self.joint().rate[0]) < 0.9 * fastest, "the wheel slowing by its friction"
        )

    # properties -------------------------------------------------------------------------------
    def test_properties_of_a_link_a_joint_and_a_model(self):
        now = self.ok(call("get_link_properties", srv.GetLinkProperties, "box::link"))
        found = now.mass, now.ixx, now.iyy, now.izz, now.gravity_mode
        self.assertEqual(found, (MASS, 0.02, 0.03, 0.04, True))

        def change(mass, gravity=True):
            inertia = now.ixx, 0, 0, now.iyy, 0, now.izz
            values = "box::link", now.com, gravity, mass, *inertia
            self.ok(call("set_link_properties", srv.SetLinkProperties, *values))
            return call("get_link_properties", srv.GetLinkProperties, "box::link")

        self.assertEqual(change(2 * MASS).mass, 2 * MASS)
        self.assertIs(change(MASS, gravity=False).gravity_mode, False)
        change(MASS)
        for damping in (0.25, 0.0):
            values = "front_left_joint", ODEJointProperties(damping=[damping])
            self.ok(call("set_joint_properties", srv.SetJointProperties, *values))
        properties = self.ok(call("get_model_properties", srv.GetModelProperties, "car"))
        self.assertIn("base_link", properties.body_names)
        self.assertIn("rear_left_joint", properties.joint_names)
        self.assertIn("base_link_collision", properties.geom_names)
