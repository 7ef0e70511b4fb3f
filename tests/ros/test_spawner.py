"""The scripts of controller_manager: flags, what they leave behind, exit codes."""

import signal
import subprocess
import sys
import time
import unittest

import rosnode
import rospy
from controller_manager_msgs.srv import ListControllers
from roslib.packages import find_node
from shared_worlds import EFFORT_BOT as LAUNCH  # noqa: F401
from sim_client import START_LIMIT, wait_connected, wait_until
from std_msgs.msg import Bool

BOT = "/effort_bot"


class Spawner(unittest.TestCase):
    """Runs the scripts as processes and reads list_controllers."""

    @classmethod
    def setUpClass(cls):
        name = f"{BOT}/controller_manager/list_controllers"
        rospy.wait_for_service(name, START_LIMIT)
        cls.list = rospy.ServiceProxy(name, ListControllers)

    def setUp(self):
        self.running = []
        self.assertEqual(self.states(), {})

    def tearDown(self):
        for process in self.running:
            if process.poll() is None:
                self.end(process)
            process.stdout.close()

    def states(self):
        return {item.name: item.state for item in self.list().controller}

    def start(self, script, *arguments):
        process = subprocess.Popen(
            [sys.executable, find_node("controller_manager", script)[0], *arguments],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        )
        self.running.append(process)
        return process

    def end(self, process):
        """Interrupts it, as roslaunch does; returns its exit code."""
        process.send_signal(signal.SIGINT)
        return process.wait(START_LIMIT)

    def command(self, *arguments):
        """Runs `controller_manager` in the robot's namespace: (exit code, text)."""
        process = self.start("controller_manager", *arguments, f"__ns:={BOT}")
        text, _ = process.communicate(timeout=START_LIMIT)
        return process.returncode, text

    def test_it_starts_and_takes_down_on_exit(self):
        names = "arm_position", "wheel_velocity"
        process = self.start("spawner", "--namespace", BOT, *names)
        both = dict.fromkeys(names, "running")
        wait_until(lambda: self.states() == both, "both running", START_LIMIT)
        self.assertEqual(self.end(process), 0)
        self.assertEqual(self.states(), {})

    def test_rosnode_kill_takes_down_what_loaded_and_what_did_not_is_named(self):
        words = "--namespace", BOT, "ghost", "wheel_position", "arm_position"
        process = self.start("spawner", *words, "__name:=killed_spawner")
        wait_until(
            lambda: self.states() == {"arm_position": "running"}, "the good one", START_LIMIT
        )
        rosnode.kill_nodes([name for name in rosnode.get_node_names() if "killed_spawner" in name])
        self.assertEqual(process.wait(START_LIMIT), 0)
        self.assertEqual(self.states(), {})
        text = process.stdout.read()
        self.assertIn("Failed to load ghost", text)
        self.assertIn("Failed to load wheel_position", text)
        self.assertIn("Started controllers: arm_position", text)

    def test_wait_for_waits_for_true(self):
        publisher = rospy.Publisher("/go", Bool, queue_size=1)
        process = self.start("spawner", "--wait-for", "/go", "--namespace", BOT, "arm_position")
        wait_connected(publisher, "the spawner")
        publisher.publish(False)
        time.sleep(0.5)
        self.assertEqual(self.states(), {})
        publisher.publish(True)
        wait_until(lambda: self.states() == {"arm_position": "running"}, "it running", START_LIMIT)
        self.end(process)

    def test_a_robot_that_never_comes_ends_it_after_the_timeout_with_the_reason(self):
        start = time.monotonic()
        process = self.start("spawner", "--timeout", "2", "--namespace", "/ghost", "arm_position")
        text, _ = process.communicate(timeout=START_LIMIT)
        self.assertEqual(process.returncode, 0)  # as upstream's
        self.assertIn("couldn't find the expected controller_manager ROS interface", text)
        self.assertGreater(time.monotonic() - start, 2.0)
        self.assertIn(
            "/ghost/controller_manager/load_controller was not available within 2 s", text
        )

    def test_unspawner_stops_and_starts_again(self):
        spawner = self.start("spawner", "--namespace", BOT, "arm_position")
        wait_until(lambda: self.states() == {"arm_position": "running"}, "it running", START_LIMIT)
        unspawner = self.start("unspawner", "--namespace", BOT, "arm_position")
        wait_until(lambda: self.states() == {"arm_position": "stopped"}, "it stopped", START_LIMIT)
        self.end(unspawner)
        self.assertEqual(self.states(), {"arm_position": "running"})
        self.end(spawner)

    def test_commands_and_exit_codes(self):
        code, text = self.command("list-types")
        self.assertEqual(code, 0)
        self.assertIn("effort_controllers/JointPositionController", text)
        self.assertEqual(self.command("load", "arm_position")[0], 0)
        self.assertEqual(self.command("start", "arm_position")[0], 0)
        code, text = self.command("list")
        self.assertIn("arm_position", text)
        self.assertIn("running", text)
        code, text = self.command("unload", "arm_position")  # which runs
        self.assertEqual(code, 0)
        self.assertIn("Error when unloading 'arm_position'", text)
        self.assertEqual(self.command("reload-libraries", "--restore")[0], 0)
        self.assertEqual(self.states(), {"arm_position": "running"})
        self.assertEqual(self.command("kill", "arm_position")[0], 0)
        self.assertEqual(self.command("spawn", "ghost")[0], 0)
        self.assertEqual(self.command("dance")[0], 1)
