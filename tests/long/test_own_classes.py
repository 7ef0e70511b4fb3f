"""A user's own controller, plugin and sensor: from devel and install space, that raise, that cannot
be had."""

import json
import re
from pathlib import Path

import rospy
from controller_manager_msgs.srv import ListControllerTypes, LoadController, SwitchController
from own_classes_rig import CODE, OwnClassesCase, files
from sim_client import sleep_sim, wait_until
from std_srvs.srv import Empty, Trigger

from bullet_bridge.srv import State


class OwnClasses(OwnClassesCase):
    """Built once, launched for each test."""

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

    def test_they_work_from_the_install_space(self):
        (self.workspace.source / CODE).write_text(files()[CODE])
        status, output = self.workspace.build("install")
        self.assertEqual(status, 0, output)
        self.addCleanup(setattr, self.workspace, "setup", self.workspace.setup)
        self.workspace.setup = self.workspace.path / "install" / "setup.bash"
        launched = self.launch([("class GasSensor", "class NotInstalled")])
        self.assertAlmostEqual(self.record("/gas").next().data, 0.1, delta=1e-3)
        self.assertNotIn("[ERROR]", launched.output())

    def test_what_raises_is_switched_off_and_the_rest_goes_on(self):
        launched = self.launch(
            [
                ("self.model.set_velocity((self._speed, 0.0, 0.0))", "self.model.fly(self._speed)"),
                ("error = self._target -", "error = 1 / (self._target - 0.5) -"),
            ]
        )
        gas = self.record("/gas")
        gas.wait_count(2)
        self.publish("/lab/mast/command", 0.5)
        wait_until(
            lambda: self.states(launched) == {"joints": "running", "mast": "stopped"},
            "the controller stopped",
        )
        gas.wait_count(len(gas.messages) + 5)
        log = re.sub(r"\s+", " ", launched.output())
        self.assertIn("controller 'mast' is stopped, since it has raised an exception", log)
        self.assertIn("ZeroDivisionError", log)
        self.assertEqual(log.count("AttributeError: 'Model' object has no attribute 'fly'"), 1)
        self.assertIn("plugin on /belt: is switched off", log)
        switch = rospy.ServiceProxy("/lab/controller_manager/switch_controller", SwitchController)
        self.assertTrue(switch(start_controllers=["mast"], strictness=2).ok)
        self.assertEqual(self.states(launched), dict.fromkeys(("joints", "mast"), "running"))

    def test_a_class_that_cannot_be_had_is_left_out_with_its_reason(self):
        launched = self.launch(
            [
                ("class GasSensor(Sensor)", "class Nose(Sensor)"),
                (
                    'self._speed = self._default = sdf.number("speed", 0.0)',
                    "raise ValueError('no')",
                ),
                ("class BangBang(Controller)", "class BangBang"),
            ],
            controllers=("joints",),
        )
        load = rospy.ServiceProxy("/lab/controller_manager/load_controller", LoadController)
        self.assertFalse(load("mast").ok)
        log = re.sub(r"\s+", " ", launched.output())
        manifest = str(Path(self.workspace.source) / "package.xml")
        self.assertIn(
            f"{manifest} names class 'my_lab.simulation:GasSensor' for sensor 'gas', which cannot "
            "be imported: AttributeError",
            log,
        )
        self.assertIn(
            f"{manifest} names class 'my_lab.simulation:BangBang' for controller "
            "'my_lab/BangBang', which is no subclass of bullet_sim.controllers.base.Controller",
            log,
        )
        self.assertIn("/belt is left out: no", log)
        answer = json.loads(rospy.ServiceProxy("/gazebo/describe", Trigger)().message)
        (lab,) = (model for model in answer["models"] if model["name"] == "lab")
        self.assertEqual(len(lab["lost"]), 3, "what ./run check reports as problems")
        sleep_sim(0.5)  # the simulation goes on
