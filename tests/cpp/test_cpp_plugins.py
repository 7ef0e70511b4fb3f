"""Plugins in C++ on a ROS graph: commands, topics, sockets, resets, spawning, a crash."""

import re
from contextlib import suppress
from pathlib import Path
from xmlrpc.client import ServerProxy

import rosgraph
import rospy
from drop_in_workspace import Launched, MasterCase, Workspace, master_port
from gazebo_msgs.srv import DeleteModel, GetModelState, SpawnModel
from geometry_msgs.msg import Pose
from sim_client import Recorder, wait_connected, wait_until
from std_msgs.msg import Float64, String
from std_srvs.srv import Empty

ACTING = Path(__file__).parent / "acting"
LISTEN = "0A"  # state of a socket in /proc/net/tcp
LOOPBACK = ("0100007F", "00000000000000000000000001000000", "0000000000000000FFFF00000100007F")
MODEL = """<sdf version="1.6"><model name="{0}"><link name="link"><gravity>0</gravity>
<inertial><mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial></link>
<plugin name="p" filename="{2}"><kind>{1}</kind></plugin></model></sdf>"""


def listening(pid):
    """Addresses at which sockets of a process listen: TCP's, and all of UDP's."""
    links = Path(f"/proc/{pid}/fd").iterdir()
    own = {m[1] for link in links if (m := re.match(r"socket:\[(\d+)\]", _target(link)))}
    found = []
    for kind in ("tcp", "tcp6", "udp", "udp6"):
        for line in Path(f"/proc/{pid}/net/{kind}").read_text().splitlines()[1:]:
            fields = line.split()
            if fields[9] in own and (fields[3] == LISTEN or kind.startswith("udp")):
                found.append(fields[1].partition(":")[0])
    return found


def _target(link):
    try:
        return str(link.readlink())
    except OSError:
        return ""


class CppPlugins(MasterCase):
    """Built once, launched for each test."""

    NODE = "cpp_plugins_test"

    @staticmethod
    def make_workspace():
        files = {
            str(path.relative_to(ACTING)): path.read_text()
            for path in ACTING.rglob("*")
            if path.is_file()
        }
        return Workspace("acting", files)

    def launch(self, *_):
        launched = super().launch("acting.launch")
        models = Recorder("/models", String)
        self.addCleanup(models.close)
        wait_until(lambda: models.messages, "the world's plugin")
        self.models = models
        return launched

    def push(self, name, value):
        publisher = rospy.Publisher(f"/{name}/command", Float64, queue_size=1)
        self.addCleanup(publisher.unregister)
        wait_connected(publisher, f"/{name}/command")
        publisher.publish(value)

    @staticmethod
    def state(name="box"):
        return rospy.ServiceProxy("/gazebo/get_model_state", GetModelState)(name, "")

    def spawn(self, name, kind="force", library="libacting_model.so"):
        return self.spawn_text(name, MODEL.format(name, kind, library))

    @staticmethod
    def spawn_text(name, text):
        return rospy.ServiceProxy("/gazebo/spawn_sdf_model", SpawnModel)(name, text, "", Pose(), "")

    def test_it_acts_by_commands_on_its_own_node(self):
        launched = self.launch()
        self.push("box", 4.0)
        wait_until(lambda: self.state().twist.linear.x > 0.1, "the box moving")
        one = self.state()
        wait_until(lambda: self.state().twist.linear.x > one.twist.linear.x + 0.5, "more speed")
        two = self.state()
        seconds = (two.header.stamp - one.header.stamp).to_sec()
        gained = two.twist.linear.x - one.twist.linear.x
        self.assertAlmostEqual(gained / seconds, 4.0 / 2.0, delta=0.02)
        self.assertIn("box ", self.models.last.data)
        self.push("box", 0.0)
        rospy.ServiceProxy("/gazebo/reset_simulation", Empty)()
        wait_until(lambda: abs(self.state().pose.position.x) < 1e-9, "the box where it was")
        self.assertNotIn("[ERROR]", launched.output())

    def test_sockets_are_of_the_loopback_interface_alone(self):
        self.launch()
        addresses = listening(self.simulator())
        self.assertGreater(len(addresses), 4, addresses)  # of roscpp, rospy and Ignition
        self.assertEqual([each for each in addresses if each not in LOOPBACK], [])

    @staticmethod
    def simulator():
        """Process id of the simulator."""
        uri = rosgraph.Master("/test").lookupNode("/gazebo")
        return ServerProxy(uri).getPid("/test")[2]

    def test_models_come_and_go_with_their_plugins(self):
        launched = self.launch()
        self.assertTrue(self.spawn("second").success)
        wait_until(lambda: "second " in self.models.last.data, "the model in Gazebo's world")
        self.push("second", 1.0)
        wait_until(lambda: self.state("second").twist.linear.x > 0.05, "the second moving")
        self.assertEqual(self.state().twist.linear.x, 0.0)
        rospy.ServiceProxy("/gazebo/delete_model", DeleteModel)("second")
        wait_until(lambda: "second " not in self.models.last.data, "the model gone")
        self.assertTrue(self.spawn("third", library="libacting_broken.so").success)
        wait_until(lambda: "gazebo::Nowhere" in launched.output(), "the missing symbol")
        self.assertIn("plugin 'p' is not loaded", launched.output())

    def test_parameters_are_read_as_by_gazebo_plugins(self):
        self.launch()
        said = Recorder("/there/said", String)
        self.addCleanup(said.close)
        given = "<robotNamespace>there</robotNamespace><given>3</given><flag>True</flag>"
        text = MODEL.format("thing", "", "libacting_utils.so")
        text = text.replace("<kind></kind>", f"{given}<option>two</option>")
        self.assertTrue(self.spawn_text("thing", text).success)
        wait_until(lambda: said.messages, "the plugin's message")
        expected = "3.000000 2.500000 1 2 no joint base utils(ns = there/)"
        self.assertEqual(said.messages[0].data, expected)

    def test_after_a_crash_the_log_names_the_plugin_and_the_simulator_comes_again(self):
        launched = Launched(self.workspace, "acting.launch", master_port(), respawn="true")
        launched.__enter__()
        self.addCleanup(self.stop, launched)
        wait_until(lambda: self.answers("box"), "the world")
        with suppress(rospy.ServiceException):  # who should answer has crashed
            self.spawn("wreck", "crash")
        wait_until(lambda: "has died" in launched.output(), "the end of the simulator")
        self.assertIn("Segmentation fault in plugin ", launched.output())
        self.assertIn("plugin 'p' of model 'wreck' (libacting_model.so, in ", launched.output())
        self.assertIn("exit code -11", launched.output())
        wait_until(lambda: self.answers("box"), "the world, once more")
        self.assertFalse(self.answers("wreck"))

    def answers(self, name):
        try:
            return self.state(name).success
        except rospy.ServiceException:
            return False
