"""Controller services and commands of a robot with two joints, without a ROS master."""

import math
import re

import bot_rig
import pytest
from bullet_bridge.control import reconfigure
from bullet_bridge.control import robot as control
from bullet_bridge.control.robot import RobotControl
from bullet_bridge.loop.jobs import JobQueue
from bullet_sim.errors import ControllerError
from bullet_sim.pose import Pose
from bullet_sim.world import World
from std_msgs.msg import Bool, Float64, Float64MultiArray
from urdf_texts import link

LINK = link("{}", inertia=0.01)
JOINT = (
    '<joint name="{0}" type="{1}"><parent link="base"/><child link="{0}_link"/>'
    '<axis xyz="0 0 1"/><limit effort="10" velocity="50" lower="-1" upper="1"/></joint>'
)
BARE = (
    '<robot name="bot">'
    + LINK.format("base")
    + LINK.format("wheel_link")
    + LINK.format("arm_link")
    + JOINT.format("wheel", "continuous")
    + JOINT.format("arm", "revolute")
    + '<gazebo><plugin name="c" filename="libgazebo_ros_control.so"/></gazebo></robot>'
)
URDF = BARE.replace(
    "</robot>",
    bot_rig.transmissions({"wheel": "Velocity Effort", "arm": "Velocity Position Effort"})
    + "</robot>",
)
PARAMS = {
    "/bot/states": {"type": "joint_state_controller/JointStateController", "publish_rate": 50},
    "/bot/fast": {"type": "joint_state_controller/JointStateController", "publish_rate": 5000},
    "/bot/drive": {"type": "velocity_controllers/JointVelocityController", "joint": "wheel"},
    "/bot/rival": {"type": "velocity_controllers/JointVelocityController", "joint": "wheel"},
    "/bot/steer": {"type": "position_controllers/JointPositionController", "joint": "arm"},
    "/bot/group": {
        "type": "velocity_controllers/JointGroupVelocityController",
        "joints": ["wheel", "arm"],
    },
    "/bot/typo": {"type": "velocity_controllers/Wheel", "joint": "wheel"},
    "/bot/wrong": {"type": "velocity_controllers/JointVelocityController", "joint": "nose"},
}


class Bot(bot_rig.Bot):
    """The robot with two joints, a meter up."""

    def __init__(self, monkeypatch):
        super().__init__(monkeypatch, URDF, PARAMS, Pose((0.0, 0.0, 1.0)))

    def run(self, steps):
        """Velocity of the wheel afterwards [rad/s]."""
        super().run(steps)
        return self.velocity("wheel")


@pytest.fixture(name="bot")
def bot_in_a_world(monkeypatch):
    bot = Bot(monkeypatch)
    yield bot
    bot.world.close()


def test_load_switch_list_unload(bot):
    assert bot.load("drive") and bot.load("states")
    assert bot.states() == {"drive": "initialized", "states": "initialized"}
    assert bot.switch(start=["drive", "states"])
    assert bot.states() == {"drive": "running", "states": "running"}
    assert not bot.unload("drive")
    assert bot.switch(stop=["drive"]) and bot.states()["drive"] == "stopped"
    assert bot.unload("drive") and bot.states() == {"states": "running"}
    assert bot.endpoints["/bot/drive/command"].closed


@pytest.mark.parametrize("name", ["/drive", "/bot/drive", "bot/drive", "drive/"])
def test_slashes_and_the_namespace_in_a_name_do_not_matter(bot, name):
    assert bot.load(name) and bot.switch(start=[name]) and bot.states() == {"drive": "running"}
    assert bot.switch(stop=[name]) and bot.unload(name)
    assert bot.endpoints["/bot/drive/command"].closed


def test_list_has_type_and_claims(bot):
    bot.load("drive")
    entry = bot.ask("list_controllers").controller[0]
    assert entry.type == "velocity_controllers/JointVelocityController"
    claimed = entry.claimed_resources[0]
    assert claimed.hardware_interface == "hardware_interface::VelocityJointInterface"
    assert claimed.resources == ["wheel"]
    bot.load("group")
    claimed = bot.ask("list_controllers").controller[1].claimed_resources[0]
    assert claimed.resources == ["arm", "wheel"], "a set upstream"


def test_types_and_reload(bot):
    response = bot.ask("list_controller_types")
    assert "position_controllers/JointPositionController" in response.types
    assert len(response.types) == len(response.base_classes)
    assert response.types == sorted(response.types), "a map upstream"
    assert bot.ask("reload_controller_libraries").ok


def test_a_robot_is_told_of_as_by_gazebo_ros_control(monkeypatch):
    """What is logged for an interface without its package, and once the controllers can come."""
    for prefix, count in (("", 1), ("hardware_interface/", 0)):
        one = bot_rig.transmissions({"wheel": "Velocity"}, prefix)
        bot = bot_rig.Bot(monkeypatch, BARE.replace("</robot>", f"{one}</robot>"), PARAMS)
        text = (
            "Deprecated syntax, please prepend 'hardware_interface/' to 'VelocityJointInterface' "
            "within the <hardwareInterface> tag in joint 'wheel'."
        )
        assert bot.log.count(text) == count and bot.log[-1] == "Loaded gazebo_ros_control."
        text = "No p gain specified for pid.  Namespace: /bot/gazebo_ros_control/pid_gains/wheel"
        assert bot.log.count(text) == 1, "an error's line there, too"
        bot.world.close()


@pytest.mark.parametrize("interface, p, count", [("Velocity", 1.0, 0), ("Effort", None, 0),
                                                 ("Position", "much", 1)])  # fmt: skip
def test_joints_without_gains_are_told_of(monkeypatch, interface, p, count):
    one = bot_rig.transmissions({"arm": interface})
    gains = {} if p is None else {"arm": {"p": p, "d": 0.1}}
    params = {**PARAMS, "/bot/gazebo_ros_control/pid_gains": gains}
    bot = bot_rig.Bot(monkeypatch, BARE.replace("</robot>", f"{one}</robot>"), params)
    assert sum("No p gain specified" in text for text in bot.log) == count
    bot.world.close()


def test_command_topics_have_the_type_of_the_controller(bot):
    assert bot.load("drive") and bot.load("group") and bot.load("states")
    assert bot.endpoints["/bot/drive/command"].kind is Float64
    assert bot.endpoints["/bot/group/command"].kind is Float64MultiArray
    assert "/bot/states/command" not in bot.endpoints


@pytest.mark.parametrize(
    "name, reason, lines",
    [
        (
            "ghost",
            "/bot/ghost is not on the parameter server",
            [
                "Could not load controller 'ghost' because the type was not specified. Did you "
                "load the controller configuration on the parameter server (namespace: "
                "'/bot/ghost')?"
            ],
        ),
        (
            "typo",
            "velocity_controllers/Wheel",
            [
                "Could not load controller 'typo' because controller type "
                "'velocity_controllers/Wheel' does not exist.",
                "Use 'rosservice call controller_manager/list_controller_types' to get the "
                "available types",
            ],
        ),
        ("wrong", "joint 'nose'", ["Initializing controller 'wrong' failed"]),
    ],
)
def test_what_cannot_be_loaded_is_refused_with_the_reason(bot, name, reason, lines):
    assert bot.load(name) is False
    assert bot.log[-len(lines) :] == lines, "in the words of ros_control"
    assert reason in bot.control.refused[name]  # which ./run check tells
    assert bot.states() == {}


@pytest.mark.parametrize("strictness", [0, 1, 7])
def test_only_strict_is_strict_as_in_ros_control(bot, strictness):
    bot.load("drive")
    bot.load("rival")
    assert not bot.switch(start=["drive", "ghost"])
    assert bot.states()["drive"] == "initialized"
    assert bot.switch(start=["drive", "ghost"], strictness=strictness)
    assert bot.states()["drive"] == "running" and "'ghost'" in bot.log[-1]
    assert not bot.switch(start=["rival"], strictness=strictness), "a joint is claimed twice"
    assert bot.states() == {"drive": "running", "rival": "initialized"}


def test_the_latest_command_wins(bot):
    bot.load("drive")
    bot.switch(start=["drive"])
    for value in (1.0, -7.0, 3.0):
        bot.command("drive", Float64(value))
    assert bot.run(200) == pytest.approx(3.0, abs=0.05)


def test_group_commands(bot):
    bot.load("group")
    bot.switch(start=["group"])
    bot.command("group", Float64MultiArray(data=[2.0, 0.0]))
    assert bot.run(200) == pytest.approx(2.0, abs=0.05)
    bot.command("group", Float64MultiArray(data=[5.0]))
    assert bot.run(50) == pytest.approx(2.0, abs=0.05)
    assert "has 1 values, must have 2" in bot.log[-1]


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_a_command_that_is_no_number_is_logged_and_the_last_stays(bot, bad):
    bot.load("drive")
    bot.switch(start=["drive"])
    bot.command("drive", Float64(4.0))
    bot.run(200)
    bot.command("drive", Float64(bad))
    assert bot.run(200) == pytest.approx(4.0, abs=0.05)
    assert [text for text in bot.log if f"command of 'drive' is {bad}" in text]


def test_joint_states_come_at_their_rate(bot):
    bot.load("states")
    bot.run(100)
    sent = bot.endpoints["/bot/joint_states"].messages
    assert sent == []
    bot.switch(start=["states"])
    bot.run(1000)
    assert len(sent) == pytest.approx(50, abs=1)
    assert sorted(sent[0].name) == ["arm", "wheel"]
    assert sent[-1].header.stamp > sent[0].header.stamp


def test_joint_states_are_of_joints_with_a_transmission_in_alphabetical_order(monkeypatch):
    spare = URDF.replace(
        "</robot>",
        '<link name="loose"/><joint name="aside" type="continuous"><parent link="base"/>'
        '<child link="loose"/></joint></robot>',
    )
    for urdf, names in ((spare, ["arm", "wheel"]), (BARE, [])):
        bot = bot_rig.Bot(monkeypatch, urdf, PARAMS, Pose((0.0, 0.0, 1.0)))
        bot.start("states")
        bot.run(100)
        message = bot.endpoints["/bot/joint_states"].messages[0]
        assert message.name == names
        assert len(message.position) == len(message.velocity) == len(message.effort) == len(names)
        bot.world.close()


def test_joint_states_are_silent_until_their_time_of_before_as_upstream(bot):
    bot.load("states")
    bot.switch(start=["states"])
    bot.run(1000)
    sent = bot.endpoints["/bot/joint_states"].messages
    for fresh in (False, True):
        before = sent[-1].header.stamp
        sent.clear()
        bot.world.start_over()
        bot.control.restart(fresh=fresh)
        bot.run(1100)
        assert (sent[0].header.stamp > before) is not fresh


def test_restart_drops_buffered_commands(bot):
    bot.load("drive")
    bot.switch(start=["drive"])
    bot.command("drive", Float64(4.0))
    bot.control.restart()
    assert bot.run(100) == pytest.approx(0.0, abs=1e-6)


def test_an_emergency_stop_comes_by_its_topic(monkeypatch):
    urdf = URDF.replace('.so"/>', '.so"><eStopTopic>stop</eStopTopic></plugin>')
    bot = bot_rig.Bot(monkeypatch, urdf, PARAMS, Pose((0.0, 0.0, 1.0)))
    bot.start("drive")
    bot.command("drive", Float64(3.0))
    bot.run(100)
    assert bot.velocity("wheel") == pytest.approx(3.0, abs=1e-3)
    for stop in (True, True, False):
        bot.endpoints["/bot/stop"].call(Bool(stop))
        bot.run(100)
        assert bot.velocity("wheel") == pytest.approx(0.0, abs=1e-3)
    bot.command("drive", Float64(2.0))
    bot.run(100)
    assert bot.velocity("wheel") == pytest.approx(2.0, abs=1e-3)
    bot.control.close()
    assert bot.endpoints["/bot/stop"].closed


def delete(bot):
    """What Robots.disconnect and the caller of delete_model do."""
    bot.control.closed = True
    bot.control.close()


def test_a_deletion_during_a_load_leaves_nothing(bot, monkeypatch):
    of = control.ROS_SIDE.of

    def overtaken(controller):
        def make(*arguments):
            topics = of(controller)(*arguments)
            delete(bot)
            return topics

        return make

    monkeypatch.setattr(control.ROS_SIDE, "of", overtaken)
    assert not bot.load("drive")
    assert "/bot/drive/command" in bot.endpoints
    assert all(endpoint.closed for endpoint in bot.endpoints.values())
    assert bot.states() == {}
    assert any("its model is deleted" in text for text in bot.log)


class Tuning:
    """Stands in for a server of gains; a test says what happens while it is made."""

    made, meanwhile = [], None

    def __init__(self, *_):
        self.closed = 0
        type(self).meanwhile()
        self.made.append(self)

    def close(self):
        self.closed += 1


@pytest.fixture(name="tuned")
def _tuned(bot, monkeypatch):
    """The robot with a controller 'pid' that can be loaded."""
    monkeypatch.setitem(
        PARAMS,
        "/bot/pid",
        {
            "type": "effort_controllers/JointPositionController",
            "joint": "arm",
            "pid": {"p": 1.0, "i": 0.0, "d": 0.0},
        },
    )
    monkeypatch.setattr(reconfigure, "pid_server", Tuning)
    monkeypatch.setattr(Tuning, "made", [])
    return bot


def test_a_deletion_while_the_tuning_is_created_leaves_nothing(tuned, monkeypatch):
    monkeypatch.setattr(Tuning, "meanwhile", lambda: delete(tuned))
    assert not tuned.load("pid")
    assert [tuning.closed for tuning in Tuning.made] == [1]
    assert all(endpoint.closed for endpoint in tuned.endpoints.values())


def test_a_service_that_cannot_be_made_fails_the_load_alone(tuned, monkeypatch):
    def refuse():
        raise control.rospy.ServiceException("taken")

    monkeypatch.setattr(Tuning, "meanwhile", refuse)
    assert not tuned.load("pid")
    assert tuned.states() == {} and "taken" in tuned.log[-1]
    assert tuned.endpoints["/bot/pid/command"].closed
    assert tuned.load("drive")


def test_a_robot_whose_services_cannot_be_made_leaves_none(bot, monkeypatch):
    made = control.rospy.Service

    def refuse(name, *rest):
        if name.endswith("list_controllers"):
            raise control.rospy.ServiceException("taken")
        return made(name, *rest)

    monkeypatch.setattr(control.rospy, "Service", refuse)
    bot.endpoints.clear()
    with pytest.raises(control.rospy.ServiceException):
        RobotControl(bot.jobs, bot.world, bot.model, "bot")
    assert len(bot.endpoints) == 3 and all(endpoint.closed for endpoint in bot.endpoints.values())


@pytest.mark.parametrize(
    "text, expected",
    [
        (f"<robot name='r'>{bot_rig.transmissions({'arm': 'Effort'})}</robot>", "effort"),
        ("<robot", "velocity"),
        (None, "velocity"),
    ],
)
def test_transmissions_are_those_of_the_parameter(monkeypatch, text, expected):
    """As upstream, found from the namespace upwards; without one the spawned text's count."""
    asked = []

    class Master:
        def __init__(self, namespace):
            asked.append(namespace)

        def searchParam(self, name):  # noqa: N802
            asked.append(name)
            if text is None:
                raise reconfigure.rosgraph.MasterError("there is none")
            return f"/{name}"

        def getParam(self, name):  # noqa: N802
            return text

    monkeypatch.setattr(reconfigure.rosgraph, "Master", Master)
    plugin = bot_rig.CONTROL.replace(
        "/></gazebo>", "><robotParam>it</robotParam></plugin></gazebo>"
    )
    parts = (
        LINK.format("arm_link"),
        JOINT.format("arm", "revolute"),
        bot_rig.transmissions({"arm": "Velocity"}),
    )
    bot = bot_rig.Bot(monkeypatch, bot_rig.held_robot(parts, control=plugin), {})
    assert asked == ["/bot", "it"]
    assert bot.model.manager.hardware.registered.interfaces == {"arm": (expected,)}
    bot.world.close()


@pytest.mark.parametrize(
    "kinds, params, lines",
    [
        (
            {"wheel": "Velocity", "nose": "Effort"},
            {},
            ['This robot has a joint named "nose" which is not in the gazebo model.'],
        ),
        (
            {"wheel": "Velocity"},
            {"/bot/joint_limits": {"wheel": {"has_velocity_limits": False}}},
            ["Cannot enforce limits for joint 'wheel'. It has no velocity limits specification."],
        ),
    ],
)
def test_a_robot_that_gazebo_ros_control_cannot_serve_has_no_controllers(
    monkeypatch, kinds, params, lines
):
    text = BARE.replace("</robot>", f"{bot_rig.transmissions(kinds)}</robot>")
    log = []
    for level in ("logfatal", "logerr"):
        monkeypatch.setattr(control.rospy, level, lambda text, *args: log.append(text % args))
    world = World(gravity=(0.0, 0.0, 0.0))
    model = world.spawn_urdf("bot", text, Pose(), str)
    monkeypatch.setattr(
        control.rospy, "get_param", lambda name, default=None: params.get(name, default)
    )
    with pytest.raises(ControllerError, match=re.escape(lines[0])):
        RobotControl(JobQueue(), world, model, "bot")
    assert [line for line in log if "gain" not in line] == [
        *lines,
        "Could not initialize robot simulation interface",
    ]
    world.close()


def test_limits_of_the_parameters_hold(monkeypatch):
    limits = {"wheel": {"has_velocity_limits": True, "max_velocity": 5.0}}
    bot = bot_rig.Bot(monkeypatch, URDF, {**PARAMS, "/bot/joint_limits": limits})
    bot.start("drive")
    bot.endpoints["/bot/drive/command"].call(Float64(15.0))
    bot.run(100)
    assert bot.velocity("wheel") == pytest.approx(5.0, abs=1e-6)
    bot.world.close()
