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

BAD_CONTROLLERS = {
    "unknown type": (
        {"type": "nonsense/Controller", "joint": "left_rear_wheel_joint"},
        "nonsense/Controller",
    ),
    "no such joint": (
        {"type": "velocity_controllers/JointVelocityController", "joint": "no_such_joint"},
        "no_such_joint",
    ),
    "no joint": ({"type": "velocity_controllers/JointVelocityController"}, "joint"),
    "no type": ({"joint": "left_rear_wheel_joint"}, "type"),
    "not a mapping": ([1.0, 2.0], "bad_controller"),
    "gain that is no number": (
        {
            "type": "velocity_controllers/JointVelocityController",
            "joint": "left_rear_wheel_joint",
            "pid": {"p": "much"},
        },
        "much",
    ),
    "negative rate": (
        {"type": "joint_state_controller/JointStateController", "publish_rate": -5},
        "publish_rate",
    ),
    "no parameters": (None, "bad_controller"),
}

LINK = (
    '<link name="a"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" '
    'iyz="0" izz="1"/></inertial>{}</link>'
)
BAD_URDF = {
    "not XML": ("<robot name='bad'><link", ""),
    "empty": ("", ""),
    "another root": ("<nonsense/>", "nonsense"),
    "no links": ("<robot name='bad'/>", ""),
}


def service(name, kind):
    """Gives a proxy of a service that must be there."""
    rospy.wait_for_service(name, timeout=120.0)
    return rospy.ServiceProxy(name, kind)


MISSING_MESHES = {  # text, what is said, whether it is spawned all the same, as upstream
    "file": (
        "<robot name='bad'>"
        + LINK.format(
            '<visual><geometry><mesh filename="file:///no/such/mesh.obj"/></geometry></visual>'
        )
        + "</robot>",
        "/no/such/mesh.obj",
        True,
    ),
    "package": (
        "<robot name='bad'>"
        + LINK.format(
            '<collision><geometry><mesh filename="package://no_such_package/a.obj"/></geometry>'
            "</collision>"
        )
        + "</robot>",
        "Package[no_such_package] does not have a path",
        False,
    ),
}
BAD_SDF = {
    "not XML": ("<sdf version='1.6'><model", ""),
    "empty": ("", ""),
    "no model": ("<sdf version='1.6'/>", ""),
}


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

    def check_controller(self, parameters, reason):
        """Requests a controller with these parameters; None: with none at all."""
        load = service("/racecar/controller_manager/load_controller", LoadController)
        if parameters is not None:
            rospy.set_param("/racecar/bad_controller", parameters)
        since = len(self.log.messages)
        try:
            self.assertFalse(load("bad_controller").ok)
        finally:
            if parameters is not None:
                rospy.delete_param("/racecar/bad_controller")
        self.logged(reason, since)
        names = {
            item.name
            for item in service(
                "/racecar/controller_manager/list_controllers", ListControllers
            )().controller
        }
        self.assertEqual(names, set(CONTROLLERS))

    def check_model(self, kind, text, reason):
        """Requests a model; kind is "urdf" or "sdf"."""
        spawn = service(f"/gazebo/spawn_{kind}_model", SpawnModel)
        since = len(self.log.messages)
        try:
            answer = spawn("bad", text, "", Pose(), "world")
        except rospy.ServiceException:  # another format, as upstream
            self.logged(reason, since)
            return
        if answer.success:  # if it was spawned wrongly, the next row must not find it
            service("/gazebo/delete_model", DeleteModel)("bad")
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

    def check_missing_mesh(self, text, reason, is_spawned):
        """Spawns a model whose mesh is missing: without it, or not at all for its package."""
        since = len(self.log.messages)
        spawn = service("/gazebo/spawn_urdf_model", SpawnModel)
        if is_spawned:
            self.assertTrue(spawn("bad", text, "", Pose(), "world").success)
        else:
            with self.assertRaises(rospy.ServiceException):
                spawn("bad", text, "", Pose(), "world")
        self.assertEqual(service("/gazebo/delete_model", DeleteModel)("bad").success, is_spawned)
        self.logged(reason, since)

    def test_a_pose_that_is_no_number_is_refused(self):
        good = "<robot name='bad'>" + LINK.format("") + "</robot>"
        pose = Pose()
        pose.position.x = math.nan
        spawn = service("/gazebo/spawn_urdf_model", SpawnModel)
        self.refused(spawn("bad", good, "", pose, "world"))
        state = ModelState(model_name="racecar")
        state.pose.orientation.w = math.nan
        move = service("/gazebo/set_model_state", SetModelState)
        self.refused(move(state))
        odometry = Recorder("/racecar/odom", Odometry).next()
        self.assertTrue(math.isfinite(odometry.pose.pose.position.x))

    def test_a_name_that_is_taken_is_refused(self):
        good = "<robot name='bad'>" + LINK.format("") + "</robot>"
        self.refused(
            service("/gazebo/spawn_urdf_model", SpawnModel)("racecar", good, "", Pose(), "world"),
            "racecar",
        )

    def test_names_that_do_not_exist_are_refused(self):
        self.refused(service("/gazebo/delete_model", DeleteModel)("no_such_model"), "no_such_model")
        self.refused(
            service("/gazebo/get_model_state", GetModelState)("no_such_model", ""), "no_such_model"
        )
        self.refused(
            service("/gazebo/set_model_state", SetModelState)(
                ModelState(model_name="no_such_model")
            ),
            "no_such_model",
        )


def add_tests():
    """Adds one test for each row of the tables."""

    def add(group, name, check):
        setattr(BadInput, f"test_{group}_{name.replace(' ', '_')}", check)

    for name, row in BAD_CONTROLLERS.items():
        add("controller", name, lambda self, row=row: self.check_controller(*row))
    for name, row in MISSING_MESHES.items():
        add("missing_mesh", name, lambda self, row=row: self.check_missing_mesh(*row))
    for kind, table in (("urdf", BAD_URDF), ("sdf", BAD_SDF)):
        for name, row in table.items():
            add(kind, name, lambda self, kind=kind, row=row: self.check_model(kind, *row))


add_tests()
