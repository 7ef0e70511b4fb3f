"""Topics, tuning and life cycles of effort and drive controllers, without a ROS master."""

import math
import sys

import bot_rig
import pytest
from bot_rig import Bot, held_robot, transmissions
from bullet_bridge.control import reconfigure
from bullet_bridge.control import robot as control
from bullet_bridge.plugins import base
from bullet_sim.controllers import manager
from bullet_sim.controllers.pid import PidGains
from control_msgs.msg import JointControllerState, PidState
from fake_impl import FakeServer, fake_reconfigure, twist
from four_wheel_steering_msgs.msg import FourWheelSteering, FourWheelSteeringStamped
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from std_msgs.msg import Float64, Float64MultiArray

CYLINDER = (
    '<collision><geometry><cylinder radius="0.1" length="0.05"/></geometry></collision></link>'
)
LINK = bot_rig.LINK.replace("</link>", CYLINDER)
JOINT = (
    '<joint name="{0}" type="continuous"><origin xyz="{1}"/><parent link="base"/>'
    '<child link="{0}_link"/><axis xyz="0 1 0"/><limit effort="10" velocity="50"/></joint>'
)
DIAGONAL = [0.1, 0.0, 0.0, 0.0, 0.0, 0.6]
COVARIANCES = dict.fromkeys(("pose_covariance_diagonal", "twist_covariance_diagonal"), DIAGONAL)
PLACES = {
    "left": "0 0.2 0",
    "right": "0 -0.2 0",
    "arm": "0 0 1",
    "spare": "0 0 2",
    "tail": "0 0 -1",
    "fl": "0 0 3",
    "fr": "0 0 4",
    "rl": "0 0 5",
    "rr": "0 0 6",
}
URDF = held_robot(
    [
        *(LINK.format(f"{n}_link") + JOINT.format(n, at) for n, at in PLACES.items()),
        transmissions(dict.fromkeys(PLACES, "Effort Velocity Position")),
    ],
    LINK,
)
PARAMS = {
    "/bot/arm": {
        "type": "effort_controllers/JointPositionController",
        "joint": "arm",
        "pid": {"p": 5.0, "d": 1.0, "publish_state": True},
    },
    "/bot/arms": {
        "type": "effort_controllers/JointGroupPositionController",
        "joints": ["arm", "left"],
        "arm": {"pid": {"p": 5.0}},
        "left": {"pid": {"p": 6.0}},
    },
    "/bot/speeds": {
        "type": "velocity_controllers/JointGroupVelocityController",
        "joints": ["left", "right"],
    },
    "/bot/push": {"type": "effort_controllers/JointEffortController", "joint": "arm"},
    "/bot/base": {
        "type": "diff_drive_controller/DiffDriveController",
        **COVARIANCES,
        "left_wheel": "left",
        "right_wheel": "right",
        "publish_rate": 100,
        "publish_cmd": True,
        "allow_multiple_cmd_vel_publishers": False,
        "base_frame_id": "footprint",
    },
    "/bot/wheels": {
        "type": "diff_drive_controller/DiffDriveController",
        **COVARIANCES,
        "left_wheel": "left",
        "right_wheel": "right",
        "publish_wheel_joint_controller_state": True,
    },
    "/bot/car": {
        "type": "ackermann_steering_controller/AckermannSteeringController",
        **COVARIANCES,
        "rear_wheel": "left",
        "front_steer": "arm",
        "wheel_separation_h": 1.0,
    },
    "/bot/fast": {
        "type": "diff_drive_controller/DiffDriveController",
        **COVARIANCES,
        "left_wheel": "left",
        "right_wheel": "right",
        "publish_rate": 5000,
    },
    "/bot/four": {
        "type": "four_wheel_steering_controller/FourWheelSteeringController",
        **COVARIANCES,
        "front_wheel": ["left", "right"],
        "rear_wheel": ["arm", "tail"],
        "front_steering": ["fl", "fr"],
        "rear_steering": ["rl", "rr"],
        "publish_rate": 100,
        "track": 0.8,
        "wheel_base": 1.0,
    },
    "/bot/gazebo_ros_control/pid_gains": {"spare": {"p": 0.5}, "nose": {"p": 1}, "arm": {"i": 1}},
}


@pytest.fixture(name="bot")
def _bot(monkeypatch):
    bot = Bot(monkeypatch, URDF, PARAMS)
    yield bot
    bot.world.close()


def test_state_comes_every_tenth_step_with_the_time_of_its_measurement(bot):
    bot.start("arm")
    bot.endpoints["/bot/arm/command"].call(Float64(0.5))
    bot.run(100)
    endpoint = bot.endpoints["/bot/arm/state"]
    assert endpoint.kind is JointControllerState and len(endpoint.messages) == 10
    assert [m.header.stamp.to_nsec() for m in endpoint.messages] == [
        (10 * k - 1) * 1_000_000 for k in range(1, 11)
    ]
    first = endpoint.messages[0]
    assert (first.set_point, first.p, first.d, first.time_step) == (0.5, 5.0, 1.0, 0.001)
    assert first.error == pytest.approx(0.5 - first.process_value)


def test_publish_state_publishes_the_pid_state_of_every_update(bot):
    bot.start("arm")
    bot.endpoints["/bot/arm/command"].call(Float64(0.5))
    bot.run(20)
    endpoint = bot.endpoints["/bot/arm/pid/state"]
    assert endpoint.kind is PidState and len(endpoint.messages) == 20
    message = endpoint.messages[-1]
    assert message.p_term == pytest.approx(5.0 * message.error)
    assert message.output == pytest.approx(message.p_term + message.i_term + message.d_term)


def test_a_pid_of_each_joint_can_be_tuned(bot):
    assert bot.ask("load_controller", name="arms").ok
    assert bot.endpoints["/bot/arms/command"].kind is Float64MultiArray
    assert bot.pid_servers["/bot/arms/left/pid"].gains == PidGains(6.0)
    bot.in_thread(lambda: bot.pid_servers["/bot/arms/left/pid"].apply(PidGains(9.0)))
    assert [pid.gains.p for pid in bot.model.manager.get("arms").pids] == [5.0, 9.0]
    assert bot.ask("unload_controller", name="arms").ok
    assert (
        bot.pid_servers["/bot/arms/left/pid"].closed and bot.pid_servers["/bot/arms/arm/pid"].closed
    )


def test_gains_of_joints_are_read_and_wrong_ones_are_named(bot):
    hardware = bot.model.manager.hardware
    assert hardware.handles(["spare"])[0].gains_pid.gains == PidGains(0.5)
    assert hardware.handles(["arm"])[0].gains_pid is None
    text = "\n".join(bot.log)
    assert "joint 'nose', which does not exist" in text
    assert "/bot/gazebo_ros_control/pid_gains/arm pid has no p; the gains are not used" in text
    bot.in_thread(
        lambda: bot.pid_servers["/bot/gazebo_ros_control/pid_gains/spare"].apply(PidGains(2.0))
    )
    assert hardware.handles(["spare"])[0].gains_pid.gains.p == 2.0


def test_sizes_of_four_steered_wheels_become_parameters(bot):
    assert bot.load("four")
    offset = bot.model.manager.get("four").config.offset
    assert bot.set_params == {  # those that are given stay
        "/bot/four/wheel_steering_y_offset": offset,
        "/bot/four/wheel_radius": bot.model.manager.get("four").config.radius,
    }


def test_a_base_with_four_steered_wheels_takes_and_gives_its_own_message(bot):
    bot.start("four")
    assert bot.endpoints["/bot/four/cmd_vel"].kind is Twist
    bot.endpoints["/bot/four/cmd_four_wheel_steering"].call(
        FourWheelSteering(speed=0.5, front_steering_angle=0.2, rear_steering_angle=0.2)
    )
    bot.run(400)
    state = bot.endpoints["/bot/four/odom_steer"]
    assert state.kind is FourWheelSteeringStamped and len(state.messages) == 40
    last, odometry = state.messages[-1], bot.endpoints["/bot/four/odom"].messages[-1]
    assert (last.header.frame_id, last.header.stamp) == ("odom", odometry.header.stamp)
    assert last.data.speed == pytest.approx(0.5, rel=0.02)
    assert last.data.front_steering_angle == pytest.approx(0.2, rel=0.02)
    twist_now = odometry.twist.twist
    assert math.hypot(twist_now.linear.x, twist_now.linear.y) == pytest.approx(last.data.speed)
    assert twist_now.linear.y == pytest.approx(0.5 * math.sin(0.2), rel=0.05)


@pytest.mark.parametrize(
    "name, topic, message",
    [
        ("base", "cmd_vel", twist(0.4, 0.1)),
        ("car", "cmd_vel", twist(0.4, 0.1)),
        ("speeds", "command", Float64MultiArray(data=[1.0, 2.0])),
    ],
)
def test_a_command_passes_eight_functions_at_most(bot, name, topic, message):
    """From the topic's callback to the motor, which writes the solver's row; checks apart."""
    passed, loop = set(), (__file__, bot_rig.__file__, manager.__file__)
    bot.start(name)

    def note(frame, event, _):
        """What calls one of these, up to the test or to what updates all controllers."""
        code = frame.f_code
        if event == "call" and code.co_name in ("_on_command", "command", "track_velocity"):
            while code.co_filename not in loop or code.co_name == "command":
                passed.add(code)
                frame = frame.f_back
                code = frame.f_code

    sys.setprofile(note)
    try:
        bot.endpoints[f"/bot/{name}/{topic}"].call(message)
        bot.run(1)
    finally:
        sys.setprofile(None)
    names = {code.co_name for code in passed}
    assert {"_on_command", "command", "set_velocity", "track_velocity"} <= names
    assert len(passed) <= 8, names


def test_odometry_is_that_of_its_stamp(bot):
    """Right and left wheel turn freely at their commands, so the pose is known at every time."""
    bot.start("base")
    bot.endpoints["/bot/base/cmd_vel"].call(twist(0.4, 0.0))
    bot.run(300)
    endpoint = bot.endpoints["/bot/base/odom"]
    assert endpoint.kind is Odometry and len(endpoint.messages) == 30
    last = endpoint.messages[-1]
    joints = dict(zip(bot.model.joints.names, bot.model.joints.arrays()[0]))
    assert last.header.stamp.to_nsec() == 300_000_000
    assert last.pose.pose.position.x == pytest.approx(
        0.1 * (joints["left"] + joints["right"]) / 2, abs=1e-12
    )
    assert last.twist.twist.linear.x == pytest.approx(0.4, rel=1e-3)
    assert (last.header.frame_id, last.child_frame_id) == ("odom", "footprint")
    assert last.pose.covariance[0] == 0.1 and last.twist.covariance[35] == 0.6
    moved = bot.endpoints["/tf"].messages[-1].transforms[0]
    assert moved.transform.translation.x == last.pose.pose.position.x
    assert (moved.header, moved.child_frame_id) == (last.header, "footprint")
    limited = bot.endpoints["/bot/base/cmd_vel_out"].messages
    assert len(limited) == 300 and limited[-1].twist.linear.x == 0.4


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_a_twist_that_is_no_number_is_refused(bot, bad):
    bot.start("car")
    bot.endpoints["/bot/car/cmd_vel"].call(twist(0.4, 0.1))
    bot.run(50)
    bot.endpoints["/bot/car/cmd_vel"].call(twist(0.4, bad))
    bot.run(50)
    assert any(f"command of 'car' is {bad}" in text for text in bot.log)
    assert bot.model.manager.get("car").limited == (0.4, 0.1)


def test_the_parameters_of_a_differential_drive(bot):
    bot.start("base")
    server = FakeServer.made["/bot/base"]
    assert list(server.values) == ["wheel_separation_multiplier", "left_wheel_radius_multiplier",
                                   "right_wheel_radius_multiplier", "publish_rate",
                                   "enable_odom_tf"]  # fmt: skip
    assert list(server.config.defaults)[:3] == ["left_wheel_radius_multiplier",
        "right_wheel_radius_multiplier", "wheel_separation_multiplier"]  # fmt: skip
    config = bot.model.manager.get("base").config
    changed = dict(server.values, left_wheel_radius_multiplier=0.5, publish_rate=20.0,
                   wheel_separation_multiplier=1.5, enable_odom_tf=False)  # fmt: skip
    bot.in_thread(lambda: server.callback(changed, 0))
    tuned = bot.model.manager.get("base").config
    assert tuned.radii == (0.5 * config.radii[0], config.radii[1])
    assert tuned.separation == pytest.approx(1.5 * config.separation)
    odom, frames = bot.endpoints["/bot/base/odom"].messages, bot.endpoints["/tf"].messages
    odom.clear(), frames.clear()
    bot.run(1000)
    assert len(odom) == 20 and not frames
    bad = dict(changed, publish_rate=math.nan)
    assert bot.in_thread(lambda: server.callback(bad, 0))["publish_rate"] == 20.0
    assert any("publish_rate nan" in text for text in bot.log)


def test_what_the_wheels_of_a_differential_drive_do(bot):
    bot.start("wheels")
    bot.endpoints["/bot/wheels/cmd_vel"].call(twist(0.4, 0.0))
    bot.run(400)
    message = bot.endpoints["/bot/wheels/wheel_joint_controller_state"].messages[-1]
    assert message.joint_names == ["left", "right"]
    speed = 0.4 / 0.1
    assert list(message.desired.velocities) == pytest.approx([speed, speed])
    assert message.actual.velocities[0] == pytest.approx(speed, rel=0.05)
    assert message.desired.positions[0] == pytest.approx(speed * 0.4, rel=0.02)
    assert message.error.positions[0] == pytest.approx(
        message.desired.positions[0] - message.actual.positions[0]
    )
    assert math.isnan(message.desired.effort[0]) and not math.isnan(message.actual.effort[1])
    assert len(message.actual.accelerations) == 2


def test_a_second_publisher_makes_it_brake_where_that_is_forbidden(bot):
    bot.start("base")
    endpoint = bot.endpoints["/bot/base/cmd_vel"]
    endpoint.call(twist(0.4, 0.0))
    bot.run(10)
    endpoint.subscribers = 2
    endpoint.call(twist(0.4, 0.0))
    bot.run(10)
    assert bot.model.manager.get("base").limited == (0.0, 0.0)
    assert any("more than one publisher" in text for text in bot.log)


def test_claims_of_both_interfaces_are_listed(bot):
    bot.ask("load_controller", name="car")
    claims = bot.ask("list_controllers").controller[0].claimed_resources
    assert [(c.hardware_interface, c.resources) for c in claims] == [
        ("hardware_interface::PositionJointInterface", ["arm"]),
        ("hardware_interface::VelocityJointInterface", ["left"]),
    ]


def test_a_rate_above_one_a_step_is_one_a_step_as_upstream(bot):
    bot.start("fast")
    bot.run(7)
    assert len(bot.endpoints["/bot/fast/odom"].messages) == 7


def test_unload_and_close_close_all_endpoints(bot):
    bot.ask("load_controller", name="base")
    bot.ask("load_controller", name="arm")
    assert bot.ask("unload_controller", name="base").ok
    for name in ("/bot/base/cmd_vel", "/bot/base/odom", "/tf", "/bot/base/cmd_vel_out"):
        assert bot.endpoints[name].closed, name
    assert not bot.endpoints["/bot/arm/state"].closed
    bot.control.close()
    assert all(endpoint.closed for endpoint in bot.endpoints.values())
    assert all(tuning.closed for tuning in bot.pid_servers.values())


@pytest.mark.parametrize("error", [control.rospy.ROSException("bad name"), OSError("no master")])
def test_a_controller_whose_topics_fail_is_unloaded(bot, monkeypatch, error):
    def fail(*_):
        raise error

    monkeypatch.setattr(reconfigure, "pid_server", fail)
    assert not bot.ask("load_controller", name="arm").ok
    assert bot.ask("list_controllers").controller == []
    assert bot.endpoints["/bot/arm/command"].closed and bot.endpoints["/bot/arm/state"].closed
    reason = f"topics of controller 'arm' cannot be made: {error}"
    assert any(reason in text for text in bot.log) and bot.control.refused == {"arm": reason}


def test_a_controller_whose_publisher_fails_leaves_no_subscription(bot, monkeypatch):
    make = base.publisher

    def refuse(topic, *rest):
        if topic == "/bot/base/odom":
            raise control.rospy.ROSException("bad name")
        return make(topic, *rest)

    monkeypatch.setattr(base, "publisher", refuse)
    assert not bot.load("base")
    assert "/bot/base/cmd_vel" not in bot.endpoints


def test_unloading_drops_a_buffered_command(bot):
    bot.ask("load_controller", name="push")
    bot.endpoints["/bot/push/command"].call(Float64(1.0))
    assert bot.ask("unload_controller", name="push").ok
    bot.run(1)
    assert not any("not loaded" in text for text in bot.log)


def test_reload_libraries_needs_force_to_unload(bot):
    bot.start("push")
    assert not bot.ask("reload_controller_libraries", force_kill=False).ok
    assert bot.ask("reload_controller_libraries", force_kill=True).ok
    assert bot.ask("list_controllers").controller == []
    assert bot.ask("reload_controller_libraries", force_kill=False).ok


@pytest.mark.parametrize("reset", ["start_over", "reset_models"])
def test_a_command_keeps_its_stamp_over_a_reset(bot, reset):
    """diff_drive_controller compares the stamp of its last command with the time of the update:
    after reset_simulation it drives until its time-out in the time of before."""
    bot.start("base")
    bot.run(1000)
    bot.endpoints["/bot/base/cmd_vel"].call(twist(0.4, 0.0))
    bot.run(100)
    getattr(bot.world, reset)()
    bot.control.restart(fresh=False)
    bot.run(1495 if reset == "start_over" else 395)
    assert bot.velocity("left") == pytest.approx(4.0, abs=1e-3)
    bot.run(100)
    assert bot.velocity("left") == pytest.approx(0.0, abs=1e-3)


def test_gains_beyond_their_ranges_are_told_and_held_within_them_at_a_change(monkeypatch):
    """control_toolbox::Pid::initDynamicReconfig gives the gains to roscpp's server, which clamps
    what it is asked for."""
    params, set_gains = fake_reconfigure(monkeypatch), []
    server = reconfigure.pid_server(
        "/bot/arm/pid", PidGains(1.0, d=5000.0, i_clamp_min=-2e5), set_gains.append
    )
    assert (params["/bot/arm/pid/d"], server.config["i_clamp_min"]) == (5000.0, -2e5)
    assert server.update_configuration({"p": 2.0})["d"] == 1000.0
    assert set_gains == [PidGains(2.0, d=1000.0, i_clamp_min=-1e5)]
