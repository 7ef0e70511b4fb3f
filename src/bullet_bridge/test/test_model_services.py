"""Services about models, called as rospy calls them, without a ROS master."""

import math
import threading
from types import SimpleNamespace

import pytest
from bullet_bridge.loop.jobs import JobQueue
from bullet_bridge.plugins.states import link_names
from bullet_bridge.services import handlers
from bullet_bridge.services import models as model_services
from bullet_bridge.services.lights import LightServices
from bullet_bridge.services.links import JointServices, LinkServices
from bullet_bridge.services.models import ModelServices
from bullet_bridge.services.physics import PhysicsProperties, PhysicsServices
from bullet_sim.description.world import ground_plane
from bullet_sim.errors import WorldError
from bullet_sim.pose import Pose, quaternion_from_yaw
from bullet_sim.world import World
from gazebo_msgs import srv
from gazebo_msgs.msg import LinkState, ModelState, ODEJointProperties, ODEPhysics
from geometry_msgs.msg import Point, Quaternion, Twist, Vector3
from geometry_msgs.msg import Pose as PoseMsg
from rospy import Duration, Time
from std_srvs.srv import EmptyRequest
from urdf_texts import joint, robot, tags
from urdf_texts import link as body

URDF = robot(body("base"), '<link name="plate"/>', joint("weld", "fixed", "base", "plate"))

WHEELED = URDF.replace(
    "</robot>",
    f"{body('wheel')}{joint('axle', 'continuous', 'base', 'wheel', axis='1 0 0')}</robot>",
)


class FakeRobots:
    """Stands in for Robots; connect fails when it is properties to."""

    def __init__(self):
        self.names, self.fault, self.closed, self.received = [], None, [], self
        self.shown = 0

    def subscribe(self, *_):
        """No messages."""

    def show_scene(self):
        self.shown = self.shown + 1

    def connect(self, model, _namespace):
        self.names.append(model.name)
        if self.fault is not None:
            raise self.fault

    def disconnect(self, name):
        self.names.remove(name)
        return [self]

    def close(self):
        self.closed.append(True)


class Desk:
    def __init__(self, monkeypatch):
        self.handlers, self.log = {}, []
        monkeypatch.setattr(
            model_services.rospy,
            "Service",
            lambda name, _kind, handler: self.handlers.update({name: handler}),
        )
        for kind in ("logerr", "logfatal"):
            monkeypatch.setattr(
                handlers.rospy, kind, lambda text, *rest: self.log.append(text % rest)
            )
        self.world, self.jobs, self.robots = World(), JobQueue(), FakeRobots()
        self.changes = 0  # jobs that did not say that they only read
        self.holds = []  # what is connected when the simulation is held and goes on again
        server = SimpleNamespace(
            hold=lambda limit=2.0: self.holds.append(list(self.robots.names)),
            release=lambda _: self.holds.append(list(self.robots.names)),
        )
        self.missing = None  # package that spawn_urdf_model finds missing
        ModelServices(
            "/gazebo", self.world, self.jobs, self.robots, str, server, lambda text: self.missing
        )
        LinkServices("/gazebo", self.world, self.jobs, self.robots)
        JointServices("/gazebo", self.world, self.jobs)
        LightServices("/gazebo", self.world, self.jobs, lambda: None)
        server = SimpleNamespace(real_time_factor=1.0, paused=True, set_paused=lambda _: None)
        server.set_pace = lambda _: None
        properties = PhysicsProperties(self.world, server)
        PhysicsServices("/gazebo", self.jobs, server, properties)

    def call(self, name, request):
        """Call a handler in another thread; the jobs run in this one."""
        results = []

        def ask():
            try:
                results.append(self.handlers[f"/gazebo/{name}"](request))
            except Exception as error:  # what rospy would return to the caller
                results.append(error)

        caller = threading.Thread(target=ask)
        caller.start()
        while caller.is_alive():
            self.changes += self.jobs.run_pending(wait=0.005)
        caller.join()
        return results[0]

    def ask(self, name, *values, **named):
        """Call with a request of these values."""
        kind = "".join(part.capitalize() for part in name.split("_"))
        return self.call(name, getattr(srv, f"{kind}Request")(*values, **named))

    def spawn(self, name="bot", text=URDF, frame="", kind="urdf"):
        return self.call(
            f"spawn_{kind}_model",
            srv.SpawnModelRequest(
                model_name=name, model_xml=text, reference_frame=frame, initial_pose=PoseMsg()
            ),
        )


@pytest.fixture(name="desk")
def _desk(monkeypatch):
    made = Desk(monkeypatch)
    yield made
    made.world.close()


def test_no_step_is_made_until_a_new_model_has_its_plugins(desk):
    """For its reading, then for what it begins with."""
    assert desk.spawn().success and desk.holds == [[], [], [], ["bot"]]
    assert not desk.spawn().success, "there is one of this name"
    assert len(desk.holds) == 4
    desk.robots.fault = WorldError("a plugin does not start")
    assert not desk.spawn("other").success
    assert len(desk.holds) == 8 and desk.holds[-1] == ["bot"], "released after it was removed"


def test_spawn_ask_and_delete(desk):
    assert desk.spawn().success and desk.robots.names == ["bot"]
    properties = desk.ask("get_model_properties", "bot")
    assert (properties.body_names, properties.joint_names, properties.is_static) == (
        ["base"],
        [],
        False,
    )
    state = desk.ask("get_model_state", "bot", "bot::plate")
    assert not state.success, "sdformat merges the plate into the base"
    state = desk.ask("get_model_state", "bot", "bot::base")
    assert state.success and state.header.frame_id == "bot::base" and state.header.seq == 1
    assert desk.ask("delete_model", "bot").success
    assert desk.world.models == {} and desk.robots.closed == [True]


@pytest.mark.parametrize(
    "name, request_",
    [
        ("get_model_state", srv.GetModelStateRequest("bot", "")),
        ("get_model_properties", srv.GetModelPropertiesRequest("bot")),
        ("get_world_properties", srv.GetWorldPropertiesRequest()),
        ("get_link_state", srv.GetLinkStateRequest("bot::base", "")),
        ("get_link_properties", srv.GetLinkPropertiesRequest("bot::base")),
        ("get_joint_properties", srv.GetJointPropertiesRequest("axle")),
        ("get_light_properties", srv.GetLightPropertiesRequest("sun")),
        ("get_physics_properties", srv.GetPhysicsPropertiesRequest()),
    ],
)
def test_what_only_reads_says_so(desk, name, request_):
    desk.spawn(text=WHEELED)
    desk.changes = 0
    assert desk.call(name, request_).success and desk.changes == 0


@pytest.mark.parametrize(
    "name, request_",
    [
        ("set_model_state", srv.SetModelStateRequest(ModelState(model_name="bot"))),
        ("set_model_configuration", srv.SetModelConfigurationRequest(model_name="bot")),
        ("set_link_state", srv.SetLinkStateRequest(LinkState(link_name="bot::base"))),
        ("apply_body_wrench", srv.ApplyBodyWrenchRequest(body_name="bot::base")),
        ("clear_body_wrenches", srv.BodyRequestRequest("bot::base")),
        ("set_light_properties", srv.SetLightPropertiesRequest(light_name="sun")),
        ("set_physics_properties", srv.SetPhysicsPropertiesRequest(time_step=0.002)),
        ("pause_physics", EmptyRequest()),
        ("delete_model", srv.DeleteModelRequest("bot")),
    ],
)
def test_what_changes_the_world_counts_as_a_change(desk, name, request_):
    desk.spawn()
    desk.changes = 0
    desk.call(name, request_)
    assert desk.changes == 1


def test_a_robot_that_cannot_be_connected_does_not_stay(desk):
    desk.robots.fault = ValueError("no room")
    assert str(desk.spawn()) == "no room"
    assert desk.world.models == {} and desk.robots.names == []
    desk.robots.fault = None
    assert desk.spawn().success


@pytest.mark.parametrize(
    "values, part",
    [
        (dict(name=""), "needs a name"),
        (dict(frame="moon"), "reference frame 'moon'"),
        (dict(text="<robot name='r'/>"), "has no link"),
    ],
)
def test_a_refused_spawn_says_why_once(desk, values, part):
    response = desk.spawn(**values)
    assert not response.success and desk.world.models == {}
    (logged,) = desk.log
    assert part in logged and logged.startswith(response.status_message)


def test_joints_that_the_model_lacks_are_skipped_as_in_gazebo(desk):
    desk.spawn()
    request = srv.SetModelConfigurationRequest("bot", "", ["weld", "nose"], [1.0, math.nan])
    response = desk.call("set_model_configuration", request)
    assert (response.success, response.status_message) == (True, "SetModelConfiguration: success")


POSE = PoseMsg()
OF_BODY, OF_LINK = (
    f"did you forget to scope the {part} by model name?" for part in ("body", "link")
)
# Service, request, status_message of gazebo_ros_api_plugin.cpp behind the service's name.
UNNAMED = ("get_light_properties", "set_physics_properties")  # their texts do not begin with it
DONE = [
    ("get_model_state", ("bot", ""), "got properties"),
    ("get_model_properties", ("bot",), "got properties"),
    ("get_world_properties", (), "got properties"),
    ("set_model_state", (ModelState(model_name="bot"),), "set model state done"),
    ("set_model_configuration", ("bot", "", [], []), "success"),
    ("delete_model", ("bot",), "successfully deleted model"),
    ("get_link_state", ("bot::base", ""), "got state"),
    ("set_link_state", (LinkState(link_name="bot::base"),), "success"),
    ("get_link_properties", ("bot::base",), "got properties"),
    (
        "set_link_properties",
        ("bot::base", POSE, True, 1.0, 0.1, 0, 0, 0.1, 0, 0.1),
        "properties set",
    ),
    ("apply_body_wrench", dict(body_name="bot::base"), ""),
    ("apply_joint_effort", dict(joint_name="axle"), "effort set"),
    ("get_joint_properties", ("axle",), "got properties"),
    ("set_joint_properties", dict(joint_name="axle"), "properties set"),
    ("get_light_properties", ("sun",), ""),
    ("delete_light", ("sun",), "sun successfully deleted"),
    ("get_physics_properties", (), "got properties"),
    ("set_physics_properties", dict(time_step=0.001), "physics engine updated"),
]
REFUSED = [
    ("get_model_state", ("ghost", ""), "model does not exist"),
    ("get_model_state", ("bot", "moon"), "reference relative_entity_name not found, " + OF_BODY),
    ("get_model_state", ("bot", "/world"), "reference relative_entity_name not found, " + OF_BODY),
    ("get_model_properties", ("ghost",), "model does not exist"),
    ("set_model_state", (ModelState(model_name="ghost"),), "model does not exist"),
    (
        "set_model_state",
        (ModelState(model_name="bot", reference_frame="moon"),),
        "specified reference frame entity does not exist",
    ),
    ("set_model_configuration", ("ghost", "", ["a"], []), "model does not exist"),
    (
        "set_model_configuration",
        ("bot", "", ["a"], []),
        "joint name and position list have different lengths",
    ),
    ("delete_model", ("ghost",), "model does not exist"),
    ("get_link_state", ("bot::nose", ""), "link not found, " + OF_LINK),
    ("get_link_state", ("bot::base", "moon"), "reference reference_frame not found, " + OF_LINK),
    ("set_link_state", (LinkState(link_name="bot::nose"),), "link does not exist"),
    ("set_link_state", (LinkState(link_name="bot::base", reference_frame="moon"),), "failed"),
    ("get_link_properties", ("nose",), "link not found, " + OF_LINK),
    (
        "set_link_properties",
        ("nose", POSE, True, 1.0, 0.1, 0, 0, 0.1, 0, 0.1),
        "link not found, " + OF_LINK,
    ),
    ("apply_body_wrench", dict(body_name="nose"), "body does not exist"),
    (
        "apply_body_wrench",
        dict(body_name="bot::base", reference_frame="moon"),
        "reference_frame not found",
    ),
    ("get_joint_properties", ("weld",), "joint not found"),
    ("get_joint_properties", ("nose",), "joint not found"),
    ("set_joint_properties", dict(joint_name="weld"), "joint not found"),
    ("set_joint_properties", dict(joint_name="nose"), "joint not found"),
    ("apply_joint_effort", dict(joint_name="weld"), "joint not found"),
    ("apply_joint_effort", dict(joint_name="nose"), "joint not found"),
    ("get_light_properties", ("moon",), "getLightProperties: Requested light moon not found!"),
    ("delete_light", ("moon",), 'Timeout reached while removing light "moon"'),
]


@pytest.mark.parametrize(
    "name, values, text, success",
    [(*row, True) for row in DONE] + [(*row, False) for row in REFUSED],
)
def test_texts_of_answers_are_upstreams(desk, name, values, text, success):
    desk.spawn(text=WHEELED)
    response = desk.ask(name, **values) if isinstance(values, dict) else desk.ask(name, *values)
    kind = "".join(part.capitalize() for part in name.split("_"))
    wanted = text if not text or name in UNNAMED else f"{kind}: {text}"
    assert (response.success, response.status_message) == (success, wanted)


def test_texts_of_spawning_are_upstreams(desk):
    first = desk.spawn("cube")
    assert (first.success, first.status_message) == (
        True,
        "SpawnModel: Successfully spawned entity",
    )
    again = desk.spawn("cube")
    assert (again.success, again.status_message) == (
        False,
        "SpawnModel: Failure - entity already exists.",
    )
    lost = desk.spawn("other", frame="moon")
    assert lost.status_message == ("SpawnModel: reference reference_frame not found, " + OF_LINK)
    empty = desk.spawn("other", text="<robot name='r'/>")
    assert empty.status_message.startswith(
        "SpawnModel: Entity pushed to spawn queue, but spawn service timed out waiting for entity "
        "to appear in simulation under the name other: "
    ), "and why"


NESTED = (
    '<sdf version="1.7"><model name="x"><link name="base"/><link name="unit::chassis">'
    '<pose>1 0 0 0 0 0</pose><collision name="shell"><geometry><sphere><radius>0.1</radius>'
    '</sphere></geometry></collision></link><joint name="f" type="fixed"><parent>base</parent>'
    "<child>unit::chassis</child></joint>"
    '<model name="arm"><pose>0 2 0 0 0 0</pose><link name="lower"><pose>0 0 1 0 0 0</pose></link>'
    '<model name="hand"><link name="palm"/></model></model>'
    '<joint name="g" type="fixed"><parent>base</parent><child>arm::lower</child></joint>'
    '<joint name="h" type="fixed"><parent>base</parent><child>arm::hand::palm</child></joint>'
    "</model></sdf>"
)


def test_models_within_a_model_have_names_of_their_own(desk):
    request = srv.SpawnModelRequest(model_name="rover", model_xml=NESTED)
    request.initial_pose.position.z = 5.0
    assert desk.call("spawn_sdf_model", request).success

    def properties(name):
        return desk.ask("get_model_properties", name)

    outer = properties("rover")
    assert outer.body_names == ["base", "unit::chassis"] and outer.geom_names == ["shell"]
    assert (outer.child_model_names, outer.parent_model_name) == (["arm"], "")
    for name in ("rover::arm", "arm"):
        arm = properties(name)
        assert (arm.body_names, arm.child_model_names) == (["lower"], ["hand"])
        assert arm.parent_model_name == "rover"
    hand = properties("hand")
    assert (hand.body_names, hand.parent_model_name) == (["palm"], "arm")
    state = desk.ask("get_model_state", "arm", "rover")
    position = state.pose.position
    assert (position.x, position.y, position.z) == pytest.approx((0, 2, 0), abs=1e-9)
    for name in ("lower", "arm::lower", "rover::arm::lower"):
        place = desk.ask("get_link_state", name, "").link_state.pose
        assert (place.position.y, place.position.z) == pytest.approx((2, 6), abs=1e-9)
    place = desk.ask("get_link_state", "unit::chassis", "arm").link_state
    assert place.pose.position.y == pytest.approx(-2, abs=1e-9)
    assert desk.ask("set_model_state", ModelState(model_name="rover::arm")).success
    position = desk.ask("get_model_state", "arm", "").pose.position
    assert (position.x, position.y, position.z) == pytest.approx((0, 0, 0), abs=1e-9)


def link(name, pose):
    mass = "<inertial><mass>1</mass></inertial>"
    return f'<link name="{name}"><pose>{pose}</pose>{mass}</link>'


MOVABLE = (
    f'<sdf version="1.6"><model name="x">{link("base", "0 0 0 0 0 0")}<model name="inner"><pose>'
    f"0 1 0 0 0 0.5</pose>{link('one', '0.1 0 0 0 0 0')}{link('two', '0.5 0 0.2 0 0 0')}"
    f'<model name="deep"><pose>0 0 1 0 0 0</pose>{link("three", "0 0 0 0 0 0")}</model></model>'
    '<joint name="j" type="revolute"><parent>base</parent><child>inner::one</child><axis><xyz>0 0 1'
    "</xyz></axis></joint></model></sdf>"
)


@pytest.mark.parametrize("name", ["outer::inner", "inner"])
def test_a_model_within_a_model_is_set_with_its_links_alone(desk, name):
    """Expected: Gazebo 11.1, paused."""
    request = srv.SpawnModelRequest(model_name="outer", model_xml=MOVABLE)
    request.initial_pose.position.x, request.initial_pose.position.z = 1.0, 1.0
    assert desk.call("spawn_sdf_model", request).success
    state = ModelState(model_name=name)
    state.pose.position.x, state.pose.position.y, state.pose.position.z = 3.0, 2.0, 1.0
    state.pose.orientation.z = state.pose.orientation.w = 0.5**0.5
    state.twist.linear.x, state.twist.angular.z = 0.3, 0.2
    assert desk.ask("set_model_state", state).success
    found = {}
    for each in ("base", "inner::one", "inner::two", "inner::deep::three"):
        told = desk.ask("get_link_state", f"outer::{each}", "").link_state
        place, twist = told.pose.position, told.twist
        found[each] = [place.x, place.y, place.z, twist.linear.x, twist.angular.z]
    assert found == {
        "base": pytest.approx([1.0, 0.0, 1.0, 0.0, 0.0]),
        "inner::one": pytest.approx([3.0, 2.1, 1.0, 0.3, 0.2]),
        "inner::two": pytest.approx([3.0, 2.5, 1.2, 0.3, 0.2]),
        "inner::deep::three": pytest.approx([3.0, 2.0, 2.0, 0.0, 0.0]),
    }


def test_deleting_a_model_ends_efforts_on_all_joints_of_its_joints_names(desk):
    """gazebo_ros' deleteModel clears them by their plain names."""
    for name in ("one", "two"):
        assert desk.spawn(name, WHEELED).success
    request = srv.ApplyJointEffortRequest("two::axle", 1.0, Duration(0), Duration(-1))
    request.duration = Duration(-1)
    assert desk.call("apply_joint_effort", request).success and desk.world.forces.active
    assert desk.ask("delete_model", "one").success and not desk.world.forces.active


def test_a_link_hides_a_model_of_its_name_from_the_services(desk):
    """World::ModelByName finds the link first: Gazebo's client waits, though the model is there."""
    assert desk.spawn("bot").success
    answer = desk.spawn("base")
    assert not answer.success and answer.status_message.startswith(TIMED_OUT)
    assert "base" in desk.world.models and not desk.ask("get_model_state", "base", "").success
    assert not desk.ask("delete_model", "base").success


def test_joints_of_models_inside_a_model_are_found_by_no_service(desk):
    joint = '<joint name="{}" type="revolute"><parent>{}</parent><child>{}</child></joint>'
    inner = f'<model name="in">{LINK}<link name="arm"/>{joint.format("deep", "l", "arm")}</model>'
    text = f"{LINK}{inner}{joint.format('outer', 'l', 'in::l')}"
    xml = f'<sdf version="1.6"><model name="x">{text}</model></sdf>'
    assert desk.spawn("x", kind="sdf", text=xml).success
    found = [desk.ask("get_joint_properties", name).success for name in ("outer", "x::outer")]
    hidden = [desk.ask("get_joint_properties", name).success for name in ("deep", "in::deep")]
    assert (found, hidden) == ([True, True], [False, False])


OFF = ' ixy="0" ixz="0" iyz="0"'


def test_an_inertia_is_told_about_the_axes_of_its_inertial_as_in_gazebo(desk):
    """Measured in Gazebo 11.1, of impossible ones as well, which move as others."""
    for name, rpy, izz in (("turned", "0 0 0.7", 0.25), ("flat", "0 0 0", 0.0)):
        inertial = f'<origin rpy="{rpy}"/><mass value="2"/><inertia ixx="0.1" iyy="0.2"{OFF}'
        xml = f'<robot name="r"><link name="b"><inertial>{inertial} izz="{izz}"/></inertial></link>'
        assert desk.spawn(name, f"{xml}</robot>").success
        told = desk.ask("get_link_properties", f"{name}::b")
        assert [told.ixx, told.ixy, told.iyy, told.izz] == [0.1, 0.0, 0.2, izz]


def test_a_link_that_is_set_is_where_its_joint_tells_at_once(desk):
    """In Gazebo 11.1 joints measure where bodies are, also while time stands still."""
    assert desk.spawn("bot", WHEELED).success
    pose = PoseMsg(orientation=Quaternion(math.sin(0.2), 0, 0, math.cos(0.2)))
    assert desk.ask("set_link_state", LinkState("bot::wheel", pose, Twist(), "bot::base")).success
    told = desk.ask("get_joint_properties", "axle")
    assert told.position == pytest.approx([0.4], abs=1e-9)


WORLD = '<sdf version="1.6"><world name="w">{}</world></sdf>'
LINK = '<link name="l"><inertial><mass>1</mass></inertial></link>'
TIMED_OUT = "SpawnModel: Entity pushed to spawn queue"


def test_urdf_through_spawn_sdf_model(desk):
    assert desk.spawn("bot", kind="sdf").success
    assert list(desk.world.model("bot").rigid_parts) == ["base"]


@pytest.mark.parametrize("text", ["<sdf version='1.6'><model name='m'/></sdf>", "", "<a/>"])
def test_what_is_no_urdf_is_a_failed_call_of_spawn_urdf_model(desk, text):
    error = desk.spawn("bot", text=text)
    assert isinstance(error, model_services.rospy.ServiceException)
    assert str(error) == "SpawnModel: Failure - entity format is invalid."
    assert desk.log[0].startswith(str(error)) and desk.world.models == {}


def test_a_package_that_is_missing_is_a_failed_call_of_spawn_urdf_model(desk):
    desk.missing = "arm_description"
    error = desk.spawn("bot")
    assert isinstance(error, model_services.rospy.ServiceException)
    assert str(error) == "urdf reference package name does not exist: arm_description"
    assert desk.log == ["Package[arm_description] does not have a path"]
    assert desk.world.models == {}
    assert desk.spawn("bot", kind="sdf").success  # which does not look


@pytest.mark.parametrize("text", [f"<model name='m'>{LINK}</model>", "", "<a/>", "no XML"])
def test_what_is_neither_is_refused_by_spawn_sdf_model(desk, text):
    answer = desk.spawn("bot", text=text, kind="sdf")
    assert not answer.success and desk.world.models == {}
    assert answer.status_message == (
        "GazeboRosApiPlugin SpawnModel Failure: input model_xml not SDF or URDF, or cannot be "
        "converted to Gazebo compatible format."
    )


def test_a_light_through_spawn_sdf_model(desk):
    text = (
        '<sdf version="1.6"><light name="other" type="spot"><pose>1 2 3 0 0 0</pose><diffuse>'
        "0.5 0.4 0.3 1</diffuse></light></sdf>"
    )
    request = srv.SpawnModelRequest(model_name="lamp", model_xml=text)
    request.initial_pose.position.x = 7.0  # has no effect, as upstream
    answer = desk.call("spawn_sdf_model", request)
    assert (answer.success, answer.status_message) == (
        True,
        "SpawnModel: Successfully spawned entity",
    )
    lamp = next(light for light in desk.world.scene.lights if light.name == "lamp")
    assert (lamp.kind, lamp.position, lamp.diffuse) == ("spot", (1, 2, 3), (0.5, 0.4, 0.3))
    assert desk.robots.shown == 1 and desk.world.models == {}
    again = desk.call("spawn_sdf_model", request)
    assert again.status_message == "SpawnModel: Failure - entity already exists."
    assert desk.spawn("lamp").success, "a model may have a light's name"
    assert desk.ask("delete_light", "lamp").success


def test_of_several_models_the_first_is_spawned_under_the_name(desk):
    pair = "".join(f'<model name="{name}">{LINK}</model>' for name in ("a", "b"))
    assert desk.spawn("bot", text=f'<sdf version="1.6">{pair}</sdf>', kind="sdf").success
    assert list(desk.world.models) == ["bot"]


def test_a_world_that_includes_a_model(desk, tmp_path):
    (tmp_path / "m.sdf").write_text(
        f'<sdf version="1.6"><model name="m"><pose>0 0 9 0 0 0</pose>{LINK}</model></sdf>'
    )
    text = WORLD.format(f"<include><uri>{tmp_path}/m.sdf</uri><name>own</name></include>")
    request = srv.SpawnModelRequest(model_name="bot", model_xml=text)
    request.initial_pose.position.x = 2.0
    assert desk.call("spawn_sdf_model", request).success
    assert list(desk.world.models) == ["bot"]
    assert desk.world.model("bot").pose.position == (2, 0, 0), "an include's pose counts"


def test_a_world_with_a_model_keeps_its_name_and_pose(desk):
    text = WORLD.format(f'<model name="own"><pose>0 0 3 0 0 0</pose>{LINK}</model>')
    request = srv.SpawnModelRequest(model_name="bot", model_xml=text)
    request.initial_pose.position.x = 2.0
    answer = desk.call("spawn_sdf_model", request)
    assert not answer.success and answer.status_message.startswith(TIMED_OUT)
    assert "'own'" in answer.status_message
    assert desk.world.model("own").pose.position == (0, 0, 3)
    request.model_name = "own"
    assert desk.ask("delete_model", "own").success
    assert desk.call("spawn_sdf_model", request).success
    assert desk.world.model("own").pose.position == (0, 0, 3), "the request's has no effect"


def test_every_joint_is_revolute_without_a_damping_as_gazebo_ros_answers(desk):
    more = '<limit lower="0" upper="1" effort="1" velocity="1"/><dynamics damping="3"/>'
    rail = joint("rail", "prismatic", "base", "slide", axis="1 0 0", more=more)
    assert desk.spawn("bot", robot(body("base"), body("slide", 1, 1), rail)).success
    desk.world.model("bot").joints.set_positions({"rail": 0.25})
    answer = desk.ask("get_joint_properties", "rail")
    assert (answer.type, answer.damping, answer.position, answer.rate) == (0, [], [0.25], [0.0])


def test_with_an_ode_config_of_zeros_nothing_collides(desk):
    """As in Gazebo 11.1, where bodies fall through each other from then on."""
    desk.world.spawn(ground_plane(), Pose((0.0, 0.0, -0.5)))
    assert desk.spawn("box", robot(body("base", 1, 1, '<box size="1 1 1"/>'))).success
    desk.world.step(500)
    model = desk.world.model("box")
    assert model.pose.position[2] == pytest.approx(0.0, abs=1e-3)
    zeros = srv.SetPhysicsPropertiesRequest(0.001, 1000.0, Vector3(0, 0, -9.8), ODEPhysics())
    assert desk.call("set_physics_properties", zeros).success
    settings = desk.world.engine.settings
    assert (settings.iterations, settings.relaxation, settings.erp) == (0, 0.0, 0.0)
    desk.world.step(500)
    assert -model.pose.position[2] == pytest.approx(0.5 * 9.8 * 0.5**2, rel=0.01)


def test_a_models_state_is_that_of_its_first_link(desk):
    """Whatever canonical_link names, as in Gazebo 11.1."""
    links = '<link name="one"/><link name="two"><pose>1 0 0 0 0 0</pose></link>'
    text = f'<sdf version="1.7"><model name="m" canonical_link="two">{links}</model></sdf>'
    assert desk.spawn("m", text, kind="sdf").success
    state = LinkState("m::two", PoseMsg(Point(1, 0, 9), Quaternion(0, 0, 0, 1)), Twist(), "world")
    assert desk.ask("set_link_state", state).success
    state = desk.ask("get_model_state", "m", "")
    assert (state.pose.position.x, state.pose.position.z) == (0.0, 0.0)


HINGED = robot(
    body("base", 2, 1), body("arm"), joint("hinge", "continuous", "base", "arm", axis="0 0 1")
)


def test_what_is_set_of_physics_is_read(desk):
    config = desk.ask("get_physics_properties").ode_config
    config.max_contacts, config.contact_surface_layer = 33, 0.01
    config.contact_max_correcting_vel, config.sor_pgs_precon_iters = 10.0, 2
    config.auto_disable_bodies = True
    request = srv.SetPhysicsPropertiesRequest(0.001, 1000.0, Vector3(0, 0, -9.8), config)
    assert desk.call("set_physics_properties", request).success
    seen = desk.ask("get_physics_properties").ode_config
    config.auto_disable_bodies = False  # which Gazebo never answers
    assert seen == config


def test_every_parameter_of_a_joint_is_taken(desk):
    """Also with several values, or those without effect: gazebo_ros answers success."""
    assert desk.spawn("bot", HINGED).success
    config = ODEJointProperties(
        damping=[0.1, 0.2], hiStop=[0.5], loStop=[-0.5], erp=[0.2], cfm=[0.1], stop_erp=[0.3],
        stop_cfm=[0.1], fudge_factor=[1.0], fmax=[2.0], vel=[1.5],
    )  # fmt: skip
    answer = desk.ask("set_joint_properties", "hinge", config)
    assert (answer.success, answer.status_message) == (True, "SetJointProperties: properties set")
    desk.world.step(100)
    model = desk.world.model("bot")
    assert model.joints.arrays()[1][0] == pytest.approx(1.5, rel=0.2), "its motor turns it"
    desk.world.step(2000)
    assert model.joints.arrays()[0][0] == pytest.approx(0.5, abs=0.05)


DRIVES = """<sdf version="1.6"><model name="m"><link name="base"><pose>0 0 2 0 0 0</pose>
  <gravity>0</gravity><inertial><mass>50</mass><inertia><ixx>9</ixx><iyy>9</iyy><izz>9</izz></inertia>
  </inertial></link>
  <link name="wheel"><pose>1 0 2 0 0 0</pose><gravity>0</gravity></link>
  <link name="gear"><pose>2 0 2 0 0 0</pose><gravity>0</gravity></link>
  <link name="load"><pose>3 0 2 0 0 0</pose><gravity>0</gravity></link>
  <joint name="hold" type="fixed"><parent>world</parent><child>base</child></joint>
  <joint name="strut" type="revolute2"><parent>base</parent><child>wheel</child>
    <axis><xyz>0 0 1</xyz></axis><axis2><xyz>0 1 0</xyz></axis2></joint>
  <joint name="input" type="revolute"><parent>base</parent><child>gear</child>
    <axis><xyz>0 0 1</xyz></axis></joint>
  <joint name="weld" type="fixed"><parent>gear</parent><child>load</child></joint>
  <joint name="mesh" type="gearbox"><parent>gear</parent><child>wheel</child>
    <gearbox_reference_body>base</gearbox_reference_body><gearbox_ratio>2</gearbox_ratio>
    <axis><xyz>0 0 1</xyz></axis><axis2><xyz>0 0 1</xyz></axis2></joint>
</model></sdf>"""


def test_joint_names_are_those_that_gazebo_has(desk):
    """Fixed joints of an SDF and gearboxes, too; a joint of two axes once."""
    assert desk.spawn("m", DRIVES, kind="sdf").success
    names = desk.ask("get_model_properties", "m").joint_names
    assert names == ["hold", "strut", "input", "weld", "mesh"]


def test_the_second_axis_takes_its_own_values(desk):
    """GazeboRosApiPlugin::setJointProperties gives each value to the axis of its index."""
    no_gears = DRIVES[: DRIVES.index('  <joint name="mesh"')] + "</model></sdf>"
    assert desk.spawn("m", no_gears, kind="sdf").success
    config = ODEJointProperties(
        fmax=[10.0, 10.0],
        vel=[0.0, 2.0],
        hiStop=[1.0, 50.0],
        loStop=[-1.0, -50.0],
        damping=[0, 0.1],
    )
    assert desk.ask("set_joint_properties", "strut", config).success
    desk.world.step(500)
    limits = desk.world.model("m").joints.limits
    assert (limits["strut"].upper, limits["strut__2"].upper) == (1.0, 50.0)
    assert (limits["strut"].damping, limits["strut__2"].damping) == (0.0, 0.1)
    rates = desk.world.model("m").joints.state()[1]
    assert rates["strut"] == pytest.approx(0.0, abs=0.02)
    assert rates["strut__2"] == pytest.approx(2.0, abs=0.02)


def test_another_center_of_mass_shifts_the_frame_that_is_told(desk):
    """ODELink::MoveCallback takes Inertial::CoG() off the body's position."""
    desk.spawn()
    model = desk.world.model("bot")
    turned = Pose((1.0, 2.0, 6.0), quaternion_from_yaw(math.pi / 2))
    model.set_state(turned)
    values = dict(com=PoseMsg(Point(0.3, 0.0, 0.0), Quaternion(0, 0, 0, 1)), mass=1.0)
    before = model.rigid_parts["base"].center
    request = srv.SetLinkPropertiesRequest(link_name="bot::base", **values)
    assert desk.call("set_link_properties", request).success
    desk.world.step(1)
    shifted = (1.0, 2.0 - 0.3 + before[0], 6.0)
    assert model.link_state("base")[0].position == pytest.approx(shifted, abs=1e-3)
    for name, arguments in (
        ("get_link_state", ("bot::base", "")),
        ("get_model_state", ("bot", "")),
    ):
        answer = desk.ask(name, *arguments)
        place = (answer.link_state if name == "get_link_state" else answer).pose.position
        assert (place.x, place.y) == pytest.approx(shifted[:2], abs=1e-3)
    model.set_state(turned)
    assert model.link_state("base")[0].position == pytest.approx(turned.position)
    model.set_link_state("base", turned, (0, 0, 0), (0, 0, 0))
    assert model.link_state("base")[0].position == pytest.approx(turned.position)


TURNED = PoseMsg(orientation=Quaternion(0, 0, math.sqrt(0.5), math.sqrt(0.5)))


@pytest.mark.parametrize(
    "frame, expected",
    [("bot::base", (0.2, 0.0)), ("world", (0.2, 0.0)), ("post", (0.0, -0.2)), ("", (0.2, 0.0))],
)
def test_a_wrench_in_a_frame_acts_as_gazebo_ros_turns_it(desk, frame, expected):
    """By the rotation from the frame to the body, though it acts along the world's axes."""
    assert desk.spawn("bot", HINGED).success and desk.spawn("post").success
    desk.ask("set_model_state", ModelState("bot", TURNED, Twist(), ""))
    request = srv.ApplyBodyWrenchRequest(
        body_name="bot::base", reference_frame=frame, start_time=Time(0.05), duration=Duration(0.1)
    )
    request.wrench.force.x = 6.0  # on 3 kg for 0.1 s
    assert desk.call("apply_body_wrench", request).success
    desk.world.engine.set_gravity((0.0, 0.0, 0.0))
    desk.world.step(49)
    assert desk.world.model("bot").link_state("base")[1] == pytest.approx((0.0, 0.0, 0.0))
    desk.world.step(200)  # in the step at whose end it begins, too, as in Gazebo
    _, linear, _ = desk.world.model("bot").link_state("base")
    assert linear[:2] == pytest.approx(expected, abs=3e-3)
    assert desk.world.model("bot").times_moved == 2  # placed and pushed


def test_a_links_velocity_is_less_its_frames_along_the_worlds_axes(desk):
    assert desk.spawn("bot").success and desk.spawn("post", HINGED).success
    moving = Twist(linear=Vector3(1, 0, 0))
    desk.ask("set_model_state", ModelState("post", TURNED, moving, ""))
    place = PoseMsg(position=Point(2, 0, 0), orientation=Quaternion(0, 0, 0, 1))
    state = LinkState("bot::base", place, Twist(linear=Vector3(0, 3, 0)), "post::base")
    assert desk.ask("set_link_state", state).success
    pose, linear, _ = desk.world.model("bot").link_state("base")
    assert pose.position == pytest.approx((0, 2, 0)) and tuple(linear) == pytest.approx((-1, 3, 0))
    assert desk.world.model("bot").times_moved == 1
    state.reference_frame = "post"
    answer = desk.ask("set_link_state", state)
    assert (answer.success, answer.status_message) == (False, "SetLinkState: failed")


def test_the_origin_of_a_robot_is_within_the_pose_of_its_spawning(desk):
    origin = '<origin xyz="1 0 0" rpy="0 0 0.5"/>'
    text = URDF.replace("<link", f"{origin}<link", 1)
    at = PoseMsg(Point(4.0, 6.0, 1.0), Quaternion(*quaternion_from_yaw(1.0)))
    request = srv.SpawnModelRequest(model_name="bot", model_xml=text, initial_pose=at)
    assert desk.call("spawn_urdf_model", request).success
    pose = desk.world.model("bot").pose
    assert pose.position == pytest.approx((4.5403, 6.8415, 1.0), abs=1e-4)  # measured in Gazebo
    assert pose.rpy[2] == pytest.approx(1.5)


def test_a_link_is_put_into_the_frame_of_a_link_and_its_velocity_is_the_worlds(desk):
    desk.spawn()
    frame = Pose((0.0, 0.0, 1.0), quaternion_from_yaw(0.5))
    desk.world.spawn_urdf("other", URDF, frame, str)
    state = LinkState("bot::base", PoseMsg(Point(1, 6, 5), Quaternion(0, 0, 0, 1)), Twist(), "")
    state.twist.linear.x = 1.0
    for name, success in (("other", False), ("/world", False), ("other::base", True)):
        state.reference_frame = name
        assert desk.ask("set_link_state", state).success == success
    pose, linear, _ = desk.world.model("bot").link_state("base")
    assert pose.position == pytest.approx((-1.999, 5.7449, 6.0), abs=1e-3)  # measured in Gazebo
    assert linear == pytest.approx((1.0, 0.0, 0.0))


def test_mass_and_inertia_are_told_and_count_for_nothing_as_in_gazebo(desk):
    desk.spawn()
    ground = '<sdf version="1.6"><model name="g"><static>1</static><link name="l"/></model></sdf>'
    desk.spawn("g", ground, kind="sdf")
    static = desk.ask("get_link_properties", "g::l")
    assert (static.success, static.mass, static.izz, static.gravity_mode) == (True, 0, 0, False)
    com = PoseMsg(Point(0.3, 0.0, 0.0), Quaternion(0, 0, 0, 1))
    values = dict(com=com, gravity_mode=False, mass=4.0, ixx=1.0, ixy=0.5, iyy=2.0, izz=3.0)
    values.update(ixz=0.02, iyz=0.03)
    request = srv.SetLinkPropertiesRequest(link_name="bot::base", **values)
    assert desk.call("set_link_properties", request).success
    told = desk.ask("get_link_properties", "bot::base")
    assert {name: getattr(told, name) for name in values} == values
    model = desk.world.model("bot")
    desk.world.forces.apply_wrench(model, "base", (4.0, 0, 0), (0, 0, 0), (0, math.inf))
    desk.world.step(100)
    assert tuple(model.link_state("base")[1]) == pytest.approx((0.4, 0.0, 0.0))  # as of 1 kg


def test_joints_are_placed_by_their_scoped_names_too(desk):
    desk.spawn(text=WHEELED)
    request = srv.SetModelConfigurationRequest("bot", "", ["bot::axle"], [0.5])
    assert desk.call("set_model_configuration", request).success
    assert desk.world.model("bot").joints.arrays()[0][0] == pytest.approx(0.5)


ON_A_WORLD = robot(
    '<link name="world"/>',
    *(
        body(name, mass, center=f"{x} 0 0")
        for name, x, mass in (("base", 0.1, 1), ("plate", 0, 3), ("arm", 0, 1), ("tip", 0, 1))
    ),
    joint("anchor", "fixed", "world", "base", "0 0 2"),
    joint("weld", "fixed", "base", "plate", "0.5 0 0"),
    joint("hinge", "revolute", "base", "arm",
          more='<limit lower="-1" upper="1" effort="9" velocity="9"/>'),
    joint("kept", "fixed", "arm", "tip") + tags("kept", preserveFixedJoint="true"),
)  # fmt: skip


def test_links_and_joints_are_those_of_gazebo(desk):
    """Links that sdformat merges and `world` are none; joints that stay are, fixed ones, too."""
    assert desk.spawn(text=ON_A_WORLD).success
    found = desk.ask("get_model_properties", "bot")
    assert found.canonical_body_name == ""  # gazebo_ros never sets it
    assert found.body_names == ["base", "arm", "tip"]
    assert sorted(found.joint_names) == ["anchor", "hinge", "kept"]
    for link in ("world", "plate"):
        for name in (link, f"bot::{link}"):
            answer = desk.ask("get_link_state", name, "")
            said = "GetLinkState: link not found, " + OF_LINK
            assert not answer.success and answer.status_message == said
            answer = desk.ask("get_link_properties", name)
            assert not answer.success
    base = desk.ask("get_link_state", "bot::base", "").link_state
    assert (base.pose.position.z, base.pose.orientation.w) == (2.0, 1.0)
    base = desk.ask("get_link_properties", "bot::base")
    assert (base.mass, base.com.position.z) == (4.0, 0.0)  # with the plate, in its own frame
    assert base.com.position.x == pytest.approx((0.1 + 3 * 0.5) / 4)
    (model,) = desk.world.models.values()
    assert link_names(model) == ["bot::base", "bot::arm", "bot::tip"]
    assert [motion[0][2] for motion in model.body_motions()] == pytest.approx([2.0] * 3)


def test_links_of_a_fixed_joint_of_an_sdf_keep_their_mass(desk):
    text = (
        '<sdf version="1.6"><model name="m">'
        + "".join(
            f'<link name="{name}"><pose>{x} 0 0 0 0 0</pose><inertial><mass>{mass}</mass>'
            "</inertial></link>"
            for name, x, mass in (("b", 0, 1), ("a", 2, 3), ("loose", 4, 5))
        )
        + '<joint name="weld" type="fixed"><parent>b</parent><child>a</child></joint></model></sdf>'
    )
    assert desk.spawn(text=text, kind="sdf").success
    for name, mass in (("a", 3.0), ("b", 1.0)):
        answer = desk.ask("get_link_properties", f"bot::{name}")
        assert (answer.mass, answer.com.position.x) == (mass, 0.0)
    found = desk.ask("get_model_properties", "bot")
    assert (found.body_names, found.joint_names) == (["b", "a", "loose"], ["weld"])
    (model,) = desk.world.models.values()
    assert link_names(model) == ["bot::b", "bot::a", "bot::loose"]
    assert [motion[0][0] for motion in model.body_motions()] == [0.0, 2.0, 4.0]
    moving = Twist(linear=Vector3(0, 0, 1))
    for name in ("loose", "a"):  # also one that a joint holds, which pulls the other one then
        place = PoseMsg(position=Point(7, 0, 1), orientation=Quaternion(0, 0, 0, 1))
        state = LinkState(f"bot::{name}", place, moving, "world")
        assert desk.ask("set_link_state", state).success
        pose, linear, _ = model.link_state(name)
        assert (pose.position, tuple(linear)) == ((7, 0, 1), (0, 0, 1))
