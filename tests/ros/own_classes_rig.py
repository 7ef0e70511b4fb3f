"""A user's own controller, plugin and sensor: the package of the tutorial, built and launched."""

import re
import sys

import rospy
from controller_manager_msgs.srv import (
    ListControllers,
)
from drop_in_workspace import ROOT, MasterCase, Workspace
from gazebo_msgs.srv import GetJointProperties, GetModelState
from sim_client import START_LIMIT, Recorder, sleep_sim, wait_connected, wait_until
from std_msgs.msg import Float64

sys.path.insert(0, str(ROOT / "tests" / "tutorials"))
from page import boxes  # noqa: E402

PAGE = ROOT / "docs" / "tutorials" / "your_own_simulation.md"
HOME = "~/lessons/ws/src/my_lab/"
CODE = "src/my_lab/simulation.py"


def files():
    """The tutorial's files by their paths below the package."""
    found = {
        re.sub(f"^{re.escape(HOME)}", "", box.path): box.text
        for box in boxes(PAGE)
        if box.kind == "file"
    }
    return {**found, "src/my_lab/__init__.py": ""}


class OwnClassesCase(MasterCase):
    """Built once, launched for each test."""

    NODE = "own_classes_test"

    @staticmethod
    def make_workspace():
        return Workspace("my_lab", files())

    def launch(self, changes=(), controllers=("joints", "mast")):
        """Launches the package, with (old, new) changes of its code."""
        code = files()[CODE]
        for old, new in changes:
            self.assertIn(old, code)
            code = code.replace(old, new)
        (self.workspace.source / CODE).write_text(code)
        launched = super().launch("lab.launch")
        wait_until(lambda: self.states(launched) == dict.fromkeys(controllers, "running"),
                   f"controllers {controllers}", START_LIMIT)  # fmt: skip
        return launched

    @staticmethod
    def states(launched):
        if not launched.running():
            raise AssertionError(f"the launch ended:\n{launched.output()}")
        try:
            answer = rospy.ServiceProxy(
                "/lab/controller_manager/list_controllers", ListControllers
            )()
        except rospy.ServiceException:
            return None
        return {item.name: item.state for item in answer.controller}

    def record(self, topic):
        recorder = Recorder(topic, Float64)
        self.addCleanup(recorder.close)
        return recorder

    def publish(self, topic, value):
        publisher = rospy.Publisher(topic, Float64, queue_size=10)
        self.addCleanup(publisher.unregister)
        wait_connected(publisher, topic)
        publisher.publish(value)

    @staticmethod
    def x():
        answer = rospy.ServiceProxy("/gazebo/get_model_state", GetModelState)("lab", "")
        return answer.pose.position.x

    @staticmethod
    def angle():
        answer = rospy.ServiceProxy("/gazebo/get_joint_properties", GetJointProperties)("mast")
        return answer.position[0]

    def stands(self):
        before = self.x()
        sleep_sim(0.1)
        return abs(self.x() - before) < 1e-3
