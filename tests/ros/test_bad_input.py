"""Bad input: each service refuses it with a reason, and the world goes on."""

import math
import unittest

import rospy
from controller_manager_msgs.srv import (
    ListControllers,
    LoadController,
    SwitchController,
    SwitchControllerRequest,
    UnloadController,
)
from gazebo_msgs.msg import ModelState
from gazebo_msgs.srv import DeleteModel, GetModelState, SetModelState, SpawnModel
from geometry_msgs.msg import Pose
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Log
from shared_worlds import CAR as LAUNCH  # noqa: F401
from sim_client import CONTROLLERS, Recorder, sleep_sim, wait_for_car, wait_until

LINK = (
    '<robot name="bad"><link name="a"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" '
    'iyy="1" iyz="0" izz="1"/></inertial>{}</link></robot>'
)
MESH = LINK.format('<visual><geometry><mesh filename="{}"/></geometry></visual>')
BAD_MODELS = {  # service -> text, what is said
    "urdf": (("<robot name='bad'><link", ""), ("", ""), ("<nonsense/>", "nonsense")),
    "sdf": (("<sdf version='1.6'><model", ""), ("<sdf version='1.6'/>", "")),
}


def service(name, kind):
    """Gives a proxy of a service that must be there."""
    rospy.wait_for_service(name, timeout=120.0)
    return rospy.ServiceProxy(name, kind)


class BadInput(unittest.TestCase):
    """Invalid requests; after each test simulated time has to advance."""

    @classmethod
    def setUpClass(cls):
        wait_for_car()
        cls.log = Recorder("/rosout", Log)

    def tearDown(self):
        sleep_sim(0.1)  # fails if the world stands still

    def refused(self, answer, reason=""):
        """Checks a gazebo_msgs answer: no success, and `reason` in its message or in the log."""
        self.assertFalse(answer.success)
        self.assertTrue(answer.status_message.strip(), "refused without a reason")
        if reason not in answer.status_message:
            self.logged(reason, 0)

    def logged(self, reason, since):
        """Checks that a warning or error with `reason` was logged since a message count.

        /rosout and not /rosout_agg: rostest starts no rosout node.
        """
        wait_until(
            lambda: any(
                reason in item.msg for item in self.log.messages[since:] if item.level >= Log.WARN
            ),
            f"a logged error naming {reason!r}",
        )

    def test_controllers_that_cannot_be_loaded(self):
        load = service("/racecar/controller_manager/load_controller", LoadController)
        for parameters, reason in (
            ({"type": "nonsense/Controller", "joint": "left_rear_wheel_joint"}, "nonsense"),
            ([1.0, 2.0], "bad_controller"),
            (None, "bad_controller"),
        ):
            if parameters is not None:
                rospy.set_param("/racecar/bad_controller", parameters)
            since = len(self.log.messages)
            try:
                self.assertFalse(load("bad_controller").ok)
            finally:
                if parameters is not None:
                    rospy.delete_param("/racecar/bad_controller")
            self.logged(reason, since)
        listed = service("/racecar/controller_manager/list_controllers", ListControllers)()
        self.assertEqual({item.name for item in listed.controller}, set(CONTROLLERS))

    def test_texts_that_are_no_model(self):
        for kind, table in BAD_MODELS.items():
            spawn = service(f"/gazebo/spawn_{kind}_model", SpawnModel)
            for text, reason in table:
                since = len(self.log.messages)
                try:
                    answer = spawn("bad", text, "", Pose(), "world")
                except rospy.ServiceException:  # another format, as upstream
                    self.logged(reason, since)
                    continue
                self.refused(answer, reason)

    def test_controllers_that_cannot_be_switched_or_unloaded(self):
        switch = service("/racecar/controller_manager/switch_controller", SwitchController)
        since = len(self.log.messages)
        self.assertFalse(
            switch(
                start_controllers=["no_such_controller"],
                stop_controllers=[],
                strictness=SwitchControllerRequest.STRICT,
            ).ok
        )
        self.logged("no_such_controller", since)
        unload = service("/racecar/controller_manager/unload_controller", UnloadController)
        self.assertFalse(unload("no_such_controller").ok)
        self.assertFalse(unload("joint_state_controller").ok, "a running one stays loaded")

    def test_a_mesh_that_is_missing_is_left_out_one_of_a_missing_package_fails_the_call(self):
        spawn = service("/gazebo/spawn_urdf_model", SpawnModel)
        delete = service("/gazebo/delete_model", DeleteModel)
        since = len(self.log.messages)
        text = MESH.format("file:///no/such/mesh.obj")
        self.assertTrue(spawn("bad", text, "", Pose(), "world").success)
        self.assertTrue(delete("bad").success)
        self.logged("/no/such/mesh.obj", since)
        with self.assertRaises(rospy.ServiceException):
            spawn("bad", MESH.format("package://no_such_package/a.obj"), "", Pose(), "world")
        self.assertFalse(delete("bad").success)
        self.logged("Package[no_such_package] does not have a path", since)

    def test_what_is_asked_of_models_is_refused_with_a_reason(self):
        good, pose = LINK.format(""), Pose()
        pose.position.x = math.nan
        spawn = service("/gazebo/spawn_urdf_model", SpawnModel)
        move = service("/gazebo/set_model_state", SetModelState)
        state = ModelState(model_name="racecar")
        state.pose.orientation.w = math.nan
        for answer, reason in (
            (spawn("bad", good, "", pose, "world"), ""),
            (spawn("racecar", good, "", Pose(), "world"), "racecar"),
            (move(state), ""),
            (move(ModelState(model_name="no_such_model")), "no_such_model"),
            (service("/gazebo/delete_model", DeleteModel)("no_such_model"), "no_such_model"),
            (service("/gazebo/get_model_state", GetModelState)("no_such_model", ""),
             "no_such_model"),
        ):  # fmt: skip
            self.refused(answer, reason)
        odometry = Recorder("/racecar/odom", Odometry).next()
        self.assertTrue(math.isfinite(odometry.pose.pose.position.x))
