"""Effort controllers on a graph: their states, gains that are tuned while they run, conflicts."""

import subprocess
import unittest

import rospy
from control_msgs.msg import JointControllerState
from controller_manager_msgs.srv import (
    ListControllers,
    LoadController,
    SwitchController,
    SwitchControllerRequest,
    UnloadController,
)
from dynamic_reconfigure.client import Client
from paddock_common.process import stop_session
from sensor_msgs.msg import JointState
from shared_worlds import EFFORT_BOT as LAUNCH  # noqa: F401
from sim_client import (
    START_LIMIT,
    Recorder,
    joint,
    wait_connected,
    wait_until,
)
from std_msgs.msg import Float64
from testing import executable

BOT = "/effort_bot"
WHEEL_GAIN = 0.5  # [N m s/rad]
STRICT = SwitchControllerRequest.STRICT


class Effort(unittest.TestCase):
    """Publishes commands, reads joint states and controller states, calls the services."""

    @classmethod
    def setUpClass(cls):
        cls.start_controllers()
        services = {"load": LoadController, "unload": UnloadController, "switch": SwitchController}
        cls.call = {}
        for name, kind in services.items():
            topic = f"{BOT}/controller_manager/{name}_controller"
            rospy.wait_for_service(topic, START_LIMIT)
            cls.call[name] = rospy.ServiceProxy(topic, kind)
        cls.list = rospy.ServiceProxy(f"{BOT}/controller_manager/list_controllers", ListControllers)
        wait_until(
            lambda: cls.states().get("wheel_velocity") == "running",
            "controllers running",
            START_LIMIT,
        )
        cls.joints = Recorder(f"{BOT}/joint_states", JointState)
        cls.joints.wait_count(1)
        cls.command = {}
        for name in ("arm_position", "slider_effort", "wheel_velocity"):
            cls.command[name] = rospy.Publisher(f"{BOT}/{name}/command", Float64, queue_size=1)
            wait_connected(cls.command[name], name)

    @classmethod
    def start_controllers(cls):
        """Starts them by the spawner; one of them cannot load, the others start all the same."""
        names = ("arm_position", "slider_effort", "wheel_position", "wheel_velocity")
        spawner = subprocess.Popen(
            [executable("controller_manager", "spawner"), "joint_state_controller", *names]
            + ["--namespace", BOT],
            start_new_session=True,
        )
        cls.addClassCleanup(stop_session, spawner, START_LIMIT)

    @classmethod
    def states(cls):
        return {item.name: item.state for item in cls.list().controller}

    def switch(self, start=(), stop=()):
        return self.call["switch"](
            start_controllers=list(start),
            stop_controllers=list(stop),
            strictness=STRICT,
            start_asap=False,
            timeout=0.0,
        ).ok

    def test_position_controller_arrives_and_publishes_its_state(self):
        states = Recorder(f"{BOT}/arm_position/state", JointControllerState)
        self.command["arm_position"].publish(9.0)
        wanted = 1.5  # the joint's stop; other targets: test_effort_physics.py

        def there():
            message = self.joints.last
            return abs(joint(message, "arm_joint")[0] - wanted) < 1e-3 and message

        arrived = wait_until(there, f"arm at {wanted} rad").header.stamp
        state = wait_until(
            lambda: next((item for item in states.messages if item.header.stamp >= arrived), None),
            "the state of that time",
        )
        self.assertEqual(state.set_point, wanted)
        self.assertAlmostEqual(state.error, wanted - state.process_value, delta=1e-9)
        self.assertAlmostEqual(state.process_value, wanted, delta=2e-3)
        self.assertAlmostEqual(state.time_step, 0.001, delta=1e-9)
        states.clear()
        stamps = [message.header.stamp for message in states.wait_count(10)]
        for earlier, later in zip(stamps, stamps[1:]):
            self.assertEqual((later - earlier).to_nsec(), 10_000_000)  # every tenth update
        states.close()

    def test_gains_are_tuned_while_it_runs(self):
        states = Recorder(f"{BOT}/arm_position/state", JointControllerState)
        client = Client(f"{BOT}/arm_position/pid", timeout=START_LIMIT)
        names = {row["name"] for row in client.get_parameter_descriptions(START_LIMIT)}
        self.assertEqual(names, {"p", "i", "d", "i_clamp_min", "i_clamp_max", "antiwindup"})
        first = client.get_configuration(START_LIMIT)
        self.assertEqual((first["p"], first["d"], first["i_clamp_max"]), (20.0, 4.0, 0.0))
        answer = client.update_configuration({"p": 40.0, "d": 6.0, "i_clamp_min": -2.0})
        self.assertEqual((answer["p"], answer["i"], answer["i_clamp_min"]), (40.0, 0.0, -2.0))
        wait_until(lambda: states.last is not None and states.last.p == 40.0, "the new gain")
        self.assertEqual((states.last.i, states.last.d), (0.0, 6.0))
        self.assertEqual(rospy.get_param(f"{BOT}/arm_position/pid/p"), 40.0)
        clipped = client.update_configuration({"i_clamp_min": 5.0, "p": 20.0, "d": 4.0})
        self.assertEqual(clipped["i_clamp_min"], 0.0)
        client.close()
        states.close()

    def test_gains_of_the_joint_itself_are_tuned(self):  # what they do: test_effort_physics.py
        client = Client(f"{BOT}/gazebo_ros_control/pid_gains/wheel_joint", timeout=START_LIMIT)
        self.assertEqual(client.get_configuration(START_LIMIT)["p"], WHEEL_GAIN)
        self.assertEqual(client.update_configuration({"p": 0.1})["p"], 0.1)
        self.command["wheel_velocity"].publish(4.0)
        wait_until(lambda: joint(self.joints.last, "wheel_joint")[1] > 0.4, "the wheel turning")
        client.update_configuration({"p": WHEEL_GAIN})
        client.close()
