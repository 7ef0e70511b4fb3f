"""A user's own controller, plugin and sensor, from the devel space."""

import re

import rospy
from controller_manager_msgs.srv import ListControllerTypes
from own_classes_rig import OwnClassesCase
from sim_client import sleep_sim, wait_until
from std_srvs.srv import Empty

from bullet_bridge.srv import State


class OwnClasses(OwnClassesCase):
    """Built once."""

    def test_they_work_and_go_back_with_a_saved_state(self):
        launched = self.launch()
        types = rospy.ServiceProxy(
            "/lab/controller_manager/list_controller_types", ListControllerTypes
        )
        self.assertIn("my_lab/BangBang", types().types)
        gas = self.record("/gas")
        first, second = gas.wait_count(2)[-2:]
        self.assertAlmostEqual(first.data, 0.1, delta=1e-3)
        self.publish("/lab/mast/command", 0.8)
        wait_until(lambda: abs(self.angle() - 0.8) < 0.1, "the mast at 0.8 rad")
        self.publish("/belt", 0.5)
        wait_until(lambda: self.x() > 0.5, "the belt moving")
        rospy.ServiceProxy("/gazebo/save_state", State)("there")
        there = self.x()
        self.publish("/belt", 0.0)
        wait_until(self.stands, "the belt to stand")
        still = self.x()
        sleep_sim(0.3)
        self.assertAlmostEqual(self.x(), still, delta=1e-3)
        rospy.ServiceProxy("/gazebo/restore_state", State)("there")
        wait_until(lambda: self.x() > there + 0.2, "the belt moving again, as it did then")
        self.assertGreater(gas.last.data, 0.1)  # nearer to the source
        rospy.ServiceProxy("/gazebo/reset_simulation", Empty)()
        sleep_sim(0.3)
        self.assertAlmostEqual(self.x(), 0.0, delta=1e-3)
        wrong = re.findall(r".*(?:Traceback|FATAL|ERROR|WARN).*", launched.output())
        self.assertEqual([line for line in wrong if "real-time factor" not in line], [])
