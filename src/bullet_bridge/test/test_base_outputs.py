"""Bases that are moved by forces, by a tricycle's wheel or many wheels; forces on links."""

import math

import pytest
from bullet_bridge.plugins import base
from bullet_sim.formats.sdf.world import ground_plane
from bullet_sim.plugins.bases import ForceMoveSpec, ManyWheelsSpec, TricycleSpec
from bullet_sim.plugins.forces import (
    ForceSpec,
    SlippingWheel,
    VacuumGripperSpec,
    WheelSlipSpec,
)
from bullet_sim.pose import Pose
from bullet_sim.world import World
from fake_impl import FakeReceivedCounts, FakeServer, in_thread, plugin_of, twist
from geometry_msgs.msg import Wrench
from std_srvs.srv import EmptyRequest
from urdf_texts import joint, link, robot

GRAVITY = (0.0, 0.0, 0.0)

MASS, INERTIA = 2.0, 0.5


def box(name, mass=MASS, inertia=INERTIA):
    return link(name, mass, inertia)


BOX = robot(box("base"))


def wheel(name, xyz):
    parent, shape = "fork" if name == "front" else "base", '<cylinder radius="0.1" length="0.004"/>'
    turning = joint(f"{name}_j", "continuous", parent, name, xyz)
    return link(name, 0.2, 1e-3, shape, "1.5707963 0 0") + turning


TRIKE = robot(
    box("base", 4.0, 0.1), box("fork", 0.3, 0.01),
    joint("steer", "continuous", "base", "fork", "0.4 0 0", "0 0 1"),
    wheel("front", "0 0 0"), wheel("left", "0 0.2 0"), wheel("right", "0 -0.2 0"),
)  # fmt: skip


def run(plugin, world, steps):
    """Updates after each step, or when due, as the simulation makes them."""
    every = 1 if plugin.every_step or not plugin.spec.rate else round(1000 / plugin.spec.rate)
    for _ in range(steps):
        if world.step_count % every == 0:
            plugin.update(world.time, world.time_step)
        world.step(1)


def pushed(world, topics, **values):
    """(plugin, received, model) of a box of MASS that is moved by forces."""
    model = world.spawn_urdf("r", BOX, Pose(), str)
    received = FakeReceivedCounts()
    spec = ForceMoveSpec("f", "base", base="base", **{"gains": (1e3, 1e3, 100.0), **values})
    return plugin_of(world, model, spec, received=received), received, model


def test_a_force_in_proportion_to_the_lack_of_speed(world, topics):
    plugin, received, model = pushed(world, topics, gains=(4.0, 8.0, 1.0))
    received.take(twist(1.0, 0.2, y=-0.5))
    run(plugin, world, 500)
    # of dv/dt = gain (wanted - v) / mass, by steps: v = wanted (1 - (1 - gain dt / mass)^n)
    _, linear, angular = model.link_state("base")
    pose = model.pose
    own = pose.matrix.T @ linear
    lag_x, lag_y, lag_yaw = (
        (1.0 - gain * 0.001 / of) ** 500 for gain, of in ((4.0, MASS), (8.0, MASS), (1.0, INERTIA))
    )
    assert angular[2] == pytest.approx(0.2 * (1.0 - lag_yaw), rel=1e-6)
    assert own[0] == pytest.approx(1.0 - lag_x, rel=0.05)  # its axes turn while it moves
    assert own[1] == pytest.approx(-0.5 * (1.0 - lag_y), rel=0.05)


def test_odometry_adds_up_the_velocity_and_is_less_certain_while_it_turns(world, topics):
    plugin, received, model = pushed(world, topics, rate=50.0)
    received.take(twist(0.5, y=0.2))
    run(plugin, world, 1000)
    odometry = topics["/odom"].messages[-1]
    assert len(topics["/odom"].messages) == pytest.approx(50, abs=3)
    assert odometry.pose.pose.position.x == pytest.approx(model.pose.position[0], abs=0.02)
    assert odometry.pose.pose.position.y == pytest.approx(model.pose.position[1], abs=0.02)
    assert odometry.twist.twist.linear.y == pytest.approx(0.2, rel=0.01)
    assert odometry.pose.covariance[35] == odometry.twist.covariance[35] == 0.01
    assert odometry.pose.covariance[0] == 0.001 and odometry.pose.covariance[14] == 1e12
    transform = topics["/tf"].messages[-1].transforms[0]
    assert transform.transform.translation.x == odometry.pose.pose.position.x
    received.take(twist(0.5, 0.5))
    run(plugin, world, 200)
    turning = topics["/odom"].messages[-1]
    assert turning.pose.covariance[35] == turning.twist.covariance[35] == 100.0


def test_without_a_command_it_stops_after_the_timeout(world, topics):
    plugin, received, model = pushed(world, topics, timeout=0.25, sideways=False, publish_tf=False)
    received.take(twist(1.0, y=0.5))
    run(plugin, world, 200)
    assert model.link_state("base")[1][:2] == pytest.approx((1.0, 0.5), rel=0.01)
    assert topics["/odom"].messages[-1].twist.twist.linear.y == 0.0, "ridgeback's knows x alone"
    run(plugin, world, 200)
    assert model.link_state("base")[1] == pytest.approx((0.0, 0.0, 0.0), abs=1e-3)
    assert topics["/tf"].messages == []


def test_maxima_hold_upwards_alone_as_upstream(world, topics):
    plugin, received, model = pushed(world, topics, maxima=(0.6, 0.6, 0.5))
    received.take(twist(2.0, y=-2.0))
    run(plugin, world, 300)
    assert model.link_state("base")[1][:2] == pytest.approx((0.6, -2.0), rel=0.01)


def test_robotniks_stays_where_it_is_after_its_watchdog(world, topics):
    plugin, received, model = pushed(world, topics, timeout=0.1, holds=True)
    received.take(twist(1.0))
    run(plugin, world, 150)
    held = model.pose.position
    world.engine.set_gravity((0.0, 0.0, -9.81))
    count = len(topics["/odom"].messages)
    assert count > 0
    run(plugin, world, 300)
    assert math.dist(model.pose.position, held) < 1e-4
    assert len(topics["/odom"].messages) == count, "upstream sends no odometry then"
    received.take(twist(1.0))
    run(plugin, world, 50)
    assert model.pose.position[0] > held[0] + 0.01


def trike(world, received, **values):
    world.spawn(ground_plane())
    world.engine.set_gravity((0.0, 0.0, -9.81))
    model = world.spawn_urdf("trike", TRIKE, Pose((0.0, 0.0, 0.1)), str)
    values = {"diameter": 0.2, "encoder_diameter": 0.2, "separation": 0.4, **values}
    wheels = {"steering": "steer", "wheel": "front_j", "encoders": ("left_j", "right_j")}
    spec = TricycleSpec("t", "base", **wheels, **values)
    plugin = plugin_of(world, model, spec, received=received)
    plugin.prepare()
    return plugin, model


def test_a_tricycle_drives_the_circle_of_its_geometry(world, topics):
    received = FakeReceivedCounts()
    plugin, model = trike(world, received)
    received.take(twist(0.5, 0.4))
    run(plugin, world, 3000)
    # the driven wheel goes round at 0.5 m/s on a radius of 0.4 / sin(0.4)
    assert model.link_state("base")[2][2] == pytest.approx(0.5 * math.sin(0.4) / 0.4, rel=0.02)
    odometry = topics["/bot/odom"] if "/bot/odom" in topics else topics["/odom"]
    last = odometry.messages[-1]
    assert last.twist.twist.linear.x == pytest.approx(0.5 * math.cos(0.4), rel=0.02)
    assert last.twist.twist.angular.z == pytest.approx(0.5 * math.sin(0.4) / 0.4, rel=0.02)
    assert last.pose.pose.position.x == pytest.approx(model.pose.position[0], abs=0.02)


def test_a_tricycle_steers_with_a_speed_and_tells_of_its_wheels(world, topics):
    received = FakeReceivedCounts()
    frames = tuple(("base", name) for name in ("steer", "front_j", "left_j", "right_j"))
    plugin, model = trike(
        world,
        received,
        steering_speed=0.4,
        from_wheels=True,
        wheel_states_topic="/joint_states",
        wheel_frames=frames,
    )
    received.take(twist(0.0, 0.3))
    run(plugin, world, 500)
    assert model.joints.positions_of(("steer",))[0] == pytest.approx(0.2, abs=0.02)
    run(plugin, world, 1000)
    # it stops within the tolerance, or is turned back where the lead is above the wheel's speed
    assert model.joints.positions_of(("steer",))[0] == pytest.approx(0.3, abs=0.02)
    state = topics["/joint_states"].messages[-1]
    assert state.name == ["steer", "front_j", "left_j", "right_j"]
    assert len(state.velocity) == len(state.effort) == 4
    transforms = [m.transforms for m in topics["/tf"].messages if len(m.transforms) == 4][-1]
    assert [t.child_frame_id for t in transforms] == ["steer", "front_j", "left_j", "right_j"]
    assert transforms[2].transform.translation.y == pytest.approx(0.2, abs=1e-3)


def test_odometry_by_a_tricycles_encoders(world, topics):
    received = FakeReceivedCounts()
    plugin, model = trike(world, received, from_wheels=True)
    received.take(twist(0.5))
    run(plugin, world, 2000)
    last = topics["/odom"].messages[-1]
    assert last.pose.pose.position.x == pytest.approx(model.pose.position[0], rel=0.03)
    assert last.twist.twist.linear.x == pytest.approx(0.5, rel=0.02)


def test_bases_of_many_wheels_give_them_their_velocity(world, topics):
    model = world.spawn_urdf("trike", TRIKE, Pose(), str)
    spec = ManyWheelsSpec(
        "d", "base", left=("left_j",), right=("right_j",), separation=0.4, diameter=0.2, resets=True
    )
    received = FakeReceivedCounts()
    plugin = plugin_of(world, model, spec, received=received)
    received.take(twist(0.5, 1.0))
    run(plugin, world, 20)
    rates = dict(zip(model.joints.names, model.joints.arrays()[1]))
    assert rates["left_j"] == pytest.approx(3.0, rel=1e-3)  # (0.5 - 0.2) / 0.1
    assert rates["right_j"] == pytest.approx(7.0, rel=1e-3)
    assert topics["/odom"].messages == [] and plugin.resets_with_model
    spec = ManyWheelsSpec("d", "base", left=("left_j",), right=("right_j",), publish_odometry=True)
    plugin = plugin_of(world, model, spec, received=received)
    run(plugin, world, 5)
    assert topics["/odom"].messages and not plugin.resets_with_model
    assert topics["/tf"].messages == []


def test_a_wrench_by_topic_acts_in_each_step_along_the_worlds_axes(world, topics, monkeypatch):
    model = world.spawn_urdf("r", BOX, Pose.from_xyz_rpy((0, 0, 0), (0, 0, 1.0)), str)
    received = FakeReceivedCounts()
    plugin = plugin_of(world, model, ForceSpec("f", "base", "/push"), received=received)
    assert received.topic == "/push"
    assert plugin._rate() == pytest.approx(1.0 / world.time_step), "it has no rate: each step"
    wrench = Wrench()
    wrench.force.x, wrench.torque.z = 4.0, 0.1
    received.take(wrench)
    run(plugin, world, 100)
    _, linear, angular = model.link_state("base")
    assert linear == pytest.approx((0.1 * 4.0 / MASS, 0.0, 0.0), abs=1e-9)
    assert angular[2] == pytest.approx(0.1 * 0.1 / INERTIA)
    logged = []
    monkeypatch.setattr(base.rospy, "logerr", lambda _, text: logged.append(text))
    wrench.force.x = math.nan
    for _ in range(2):  # within a second it is logged once
        received.take(wrench)
    run(plugin, world, 100)
    assert model.link_state("base")[1][0] == pytest.approx(0.2 * 4.0 / MASS)
    assert len(logged) == 1 and "/push" in logged[0]


def test_a_vacuum_gripper_draws_what_is_near(world, topics):
    gripper = world.spawn_urdf("r", BOX, Pose((0.0, 0.0, 1.0)), str)
    near = world.spawn_urdf("near", BOX, Pose((0.03, 0.0, 1.0)), str)
    far = world.spawn_urdf("far", BOX, Pose((0.06, 0.0, 1.0)), str)
    spec = VacuumGripperSpec("v", "base", "/arm/grasping", "/arm")
    plugin = plugin_of(world, gripper, spec)
    run(plugin, world, 3)
    assert [message.data for message in topics["/arm/grasping"].messages] == [False] * 3
    topics["/arm/on"].call(EmptyRequest())
    gripper.set_state(gripper.pose, (0.0, 0.0, 0.5))
    run(plugin, world, 1)
    assert topics["/arm/grasping"].messages[-1].data is True
    # the gripper's velocity, and a pull of at most 20 N for a step
    assert near.link_state("base")[1] == pytest.approx((-20.0 / MASS * 0.001, 0, 0.5), abs=1e-6)
    assert far.link_state("base")[1] == pytest.approx((0, 0, 0), abs=1e-9)
    near.set_state(Pose((0.005, 0.0, gripper.pose.position[2])))
    run(plugin, world, 1)
    assert math.dist(near.pose.position, gripper.pose.position) < 1e-3, "within 1 cm it is held"
    topics["/arm/off"].call(EmptyRequest())
    run(plugin, world, 1)
    assert topics["/arm/grasping"].messages[-1].data is False


@pytest.mark.parametrize(
    "text",
    [
        BOX.replace("</robot>", "<gazebo><static>true</static></gazebo></robot>"),
        BOX.replace('"base"', '"other"').replace(
            "</robot>",
            '<link name="stick"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"'
            ' ixy="0" ixz="0" iyz="0"/>'
            '</inertial></link><joint name="j" type="continuous"><parent link="other"/><child '
            'link="stick"/><origin xyz="0.5 0 0"/><axis xyz="0 0 1"/></joint></robot>',
        ),
    ],
    ids=["static", "another link than the root"],
)
def test_a_vacuum_gripper_tells_of_each_link_that_is_near(world, topics, text):
    gripper = world.spawn_urdf("r", BOX, Pose((0.0, 0.0, 1.0)), str)
    place = 0.02 if "stick" not in text else -0.48
    world.spawn_urdf("near", text, Pose((place, 0.0, 1.0)), str)
    plugin = plugin_of(world, gripper, VacuumGripperSpec("v", "base", "/grasping"))
    topics["/on"].call(EmptyRequest())
    run(plugin, world, 1)
    assert topics["/grasping"].messages[-1].data is True


ROLLER = robot(
    box("base", 2.0, 100.0), link("wheel", 0.2, 1e-3, '<sphere radius="0.1"/>'),
    joint("axle", "continuous", "base", "wheel"),
)  # fmt: skip
ROLLING, PUSH, NORMAL = 1.0, 2.0, 20.0  # [m/s], [N], [N] of the plugin


def sideways(world, wheel, changed=None):
    """Velocity [m/s] to the side of a ball that rolls and is pushed there with PUSH; slip1 and
    slip2 of its contacts then [m/(N s)]."""
    world.spawn(ground_plane())
    world.engine.set_gravity((0.0, 0.0, -9.81))
    model = world.spawn_urdf("r", ROLLER, Pose((0.0, 0.0, 0.1)), str)
    plugin = in_thread(plugin_of(world, model, WheelSlipSpec("s", "base", (wheel,), "/r/slip")))
    slips = []
    set_slip = model.body.set_slip
    model.body.set_slip = lambda link, *values: (
        slips.append(values), set_slip(link, *values))  # fmt: skip
    if changed is not None:
        FakeServer.made["/r/slip"].callback(changed, 1)
    model.joints.set_motor("axle", ROLLING / 0.1, 1.0)
    for step in range(2000):
        plugin.update(world.time, 0.001)
        if step > 700:
            model.apply_wrench(model.root, (0.0, PUSH, 0.0), (0.0, 0.0, 0.0))
        world.step(1)
    _, linear, _ = model.link_state("base")
    assert linear[0] == pytest.approx(ROLLING, rel=0.05)
    return linear[1], slips[-1]


def test_a_slipping_wheel_has_its_rims_speed_times_compliance_over_force(world, topics):
    wheel = SlippingWheel("wheel", "axle", 0.1, NORMAL, lateral=0.5, longitudinal=0.25)
    _, slips = sideways(world, wheel)
    assert slips == pytest.approx((ROLLING * 0.5 / NORMAL, ROLLING * 0.25 / NORMAL), rel=0.01)


@pytest.mark.parametrize("compliance", [0.25, 0.5])
def test_a_wheel_slips_to_the_side_as_one_whose_surface_has_that_slip(world, topics, compliance):
    wheel = SlippingWheel("wheel", "axle", 0.1, NORMAL, lateral=compliance)
    found, (slip, _) = sideways(world, wheel)
    other = World()
    other.spawn(ground_plane())
    model = other.spawn_urdf("r", ROLLER, Pose((0.0, 0.0, 0.1)), str)
    link = model.link_in_body("wheel")[0]
    for _ in range(1300):
        model.body.set_slip(link, slip, 0.0)
        model.apply_wrench(model.root, (0.0, PUSH, 0.0), (0.0, 0.0, 0.0))
        other.step(1)
    wanted = model.link_state("base")[1][1]
    other.close()
    assert wanted > 0.02 and found == pytest.approx(wanted, rel=0.06)


def test_the_compliance_of_wheels_is_reconfigured(world, topics):
    wheel = SlippingWheel("wheel", "axle", 0.1, NORMAL, longitudinal=0.1)
    values = {
        "slip_compliance_unitless_lateral": 0.5,
        "slip_compliance_unitless_longitudinal": -1.0,
    }
    _, slips = sideways(world, wheel, values)
    assert slips == pytest.approx((ROLLING * 0.5 / NORMAL, ROLLING * 0.1 / NORMAL), rel=0.01)
