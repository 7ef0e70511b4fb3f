"""Gains of an effort controller that are tuned on a graph while it runs."""

import subprocess
import unittest

import rospy
from control_msgs.msg import JointControllerState
from dynamic_reconfigure.client import Client
from paddock_common.process import stop_session
from shared_worlds import EFFORT_BOT as LAUNCH  # noqa: F401
from sim_client import START_LIMIT, Recorder, wait_running, wait_until
from testing import executable

BOT = "/effort_bot"


class Effort(unittest.TestCase):
    """One of its controllers cannot load; the spawner starts the others all the same."""

    def setUp(self):
        names = ("joint_state_controller", "arm_position", "wheel_position", "wheel_velocity")
        command = [executable("controller_manager", "spawner"), *names, "--namespace", BOT]
        spawner = subprocess.Popen(command, start_new_session=True)
        self.addCleanup(stop_session, spawner, START_LIMIT)
        wait_running(BOT, 3)

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
