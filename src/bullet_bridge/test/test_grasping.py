"""Grippers that hold objects, links that are attached by service, lifts and floats, no master."""

import builtins
import math

import pytest
from bullet_bridge.services import attaching
from bullet_bridge.services.attaching import FIELDS, LinkAttacher, attach_type
from bullet_sim.formats.sdf import world as sdf
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.pose import Pose
from fake_impl import FakeReceivedCounts, plugin_of
from std_msgs.msg import String
from urdf_texts import inertial

INERTIA = inertial("{0}", 0.01)
BOX = '<collision><geometry><box size="{0}"/></geometry></collision>'


def finger(side, x):
    return (
        f'<link name="{side}">{INERTIA.format(0.2)}{BOX.format("0.02 0.06 0.1")}</link><joint '
        f'name="{side}_joint" type="prismatic"><parent link="palm"/><child link="{side}"/><origin '
        f'xyz="{x} 0 -0.1"/><axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="99" '
        'velocity="9"/></joint>'
    )


def gripper(tags="", arm=True):
    """A palm that a joint lifts, with two fingers below it."""
    arm = (
        "<arm><arm_name>hand</arm_name><palm_link>palm</palm_link><gripper_link>left</gripper_link>"
        "<gripper_link>right</gripper_link></arm>"
        if arm
        else ""
    )
    return (
        f'<robot name="bot"><link name="world"/><link name="palm">{INERTIA.format(1)}</link><joint '
        'name="up" type="prismatic"><parent link="world"/><child link="palm"/><axis xyz="0 0 1"/>'
        '<limit lower="-1" upper="2" effort="999" velocity="9"/></joint>'
        f"{finger('left', -0.08)}{finger('right', 0.08)}<gazebo><plugin name='g' "
        f'filename="libgazebo_grasp_fix.so">{arm}{tags}</plugin></gazebo></robot>'
    )


BALL = (
    f'<robot name="ball"><link name="l">{INERTIA.format(0.1)}<collision><geometry><box '
    'size="0.08 0.04 0.04"/></geometry></collision></link></robot>'
)


def held(world, topics, tags=""):
    """A gripper around a box on a table that closes; with its plugin."""
    assert topics == {}
    table = (
        '<model name="t"><static>true</static><link name="l"><collision name="c"><pose>0 0 -0.5 '
    )
    table += (
        "0 0 0</pose><geometry><box><size>2 2 1</size></box></geometry></collision></link></model>"
    )
    world.spawn_sdf("table", table, Pose(), str)
    bot = world.spawn_urdf("bot", gripper(tags), Pose((0.0, 0.0, 0.15)), str)
    ball = world.spawn_urdf("ball", BALL, Pose((0.0, 0.0, 0.02)), str)
    plugin = plugin_of(world, bot, bot.description.sensors[0])
    bot.joints.set_motor("up", 0.0, 999.0)
    squeeze(bot, 0.2)
    return bot, ball, plugin


def squeeze(bot, speed):
    bot.joints.set_motor("left_joint", speed, 5.0)
    bot.joints.set_motor("right_joint", -speed, 5.0)


def run(world, plugin, seconds):
    for _ in range(round(seconds / world.time_step)):
        world.step()
        plugin.update(world.time, world.time_step)


def test_what_is_pressed_is_held_and_let_go_when_the_fingers_leave(world, topics):
    bot, ball, plugin = held(world, topics)
    run(world, plugin, 0.9)
    assert plugin._held == {}  # up to five decisions in a second do not suffice
    run(world, plugin, 0.8)
    assert plugin._held == {"hand": (ball.body.number, ball.root)}
    there = bot.link_state("palm")[0].inverse() * ball.pose
    bot.joints.set_motor("left_joint", 0.0, 0.0)  # no force at all, but a finger that stays
    bot.joints.set_motor("up", 0.5, 999.0)
    run(world, plugin, 0.4)
    assert ball.pose.position[2] > 0.15
    now = bot.link_state("palm")[0].inverse() * ball.pose
    assert now.position == pytest.approx(there.position, abs=5e-3)
    bot.joints.set_motor("up", 0.0, 999.0)
    squeeze(bot, -0.2)
    run(world, plugin, 2.0)
    assert plugin._held == {}
    assert ball.pose.position[2] == pytest.approx(0.02, abs=0.01)


def test_a_held_object_collides_with_nothing_if_that_is_wanted(world, topics):
    tags = "<disable_collisions_on_attach>true</disable_collisions_on_attach><update_rate>20"
    _, ball, plugin = held(world, topics, tags + "</update_rate>")
    while not plugin._held and world.time < 1.0:
        run(world, plugin, 0.01)
    assert plugin._held
    world.step(2)
    assert ball.body.contacts(ball.root) == []


def test_its_parameters(world, topics):
    tags = (
        "<forces_angle_tolerance>100</forces_angle_tolerance><update_rate>4</update_rate>"
        "<max_grip_count>8</max_grip_count><release_tolerance>0.01</release_tolerance>"
    )
    (spec,) = parse_urdf(gripper(tags), str, "bot").sensors
    assert (spec.decisions, spec.most, spec.threshold, spec.tolerance) == (4.0, 8, 4, 0.01)
    assert spec.angle == pytest.approx(math.radians(100)) and spec.passes is False
    (spec,) = parse_urdf(
        gripper("<grip_count_threshold>2</grip_count_threshold>"), str, "b"
    ).sensors
    assert (spec.decisions, spec.most, spec.threshold, spec.tolerance) == (5.0, 10, 2, 0.005)
    model = parse_urdf(gripper(arm=False), str, "bot")
    assert model.sensors == [] and "has no <arm> that it can use" in model.warnings[0]


SDF_GRIPPER = """<sdf version="1.6"><model name="bot"><link name="palm">{inertial}</link>
<joint name="hold" type="fixed"><parent>world</parent><child>palm</child></joint>
<link name="shelf"><pose>0 0 -0.2 0 0 0</pose>{inertial}<collision name="c"><geometry><box><size>
0.3 0.3 0.02</size></box></geometry></collision></link><joint name="down" type="prismatic"><parent>
palm</parent><child>shelf</child><axis><xyz>0 0 1</xyz><limit><lower>-2</lower><upper>2</upper>
</limit></axis></joint><gripper name="g"><palm_link>palm</palm_link>
<gripper_link>{finger}</gripper_link><grasp_check><attach_steps>1</attach_steps>
<detach_steps>{detach}</detach_steps><min_contact_count>{least}</min_contact_count></grasp_check>
</gripper></model></sdf>"""
MASS = (
    "<inertial><mass>1</mass><inertia><ixx>.1</ixx><iyy>.1</iyy><izz>.1</izz></inertia></inertial>"
)


def sdf_gripper(**values):
    values = {"inertial": MASS, "finger": "shelf", "detach": 1, "least": 2, **values}
    return SDF_GRIPPER.format(**values)


def test_a_gripper_of_sdf_holds_what_rests_on_it(world, topics):
    assert topics == {}
    bot = world.spawn_sdf("bot", sdf_gripper(), Pose((0.0, 0.0, 2.0)), str)
    ball = world.spawn_urdf("ball", BALL, Pose((0.0, 0.0, 1.835)), str)
    (spec,) = bot.description.sensors
    plugin = plugin_of(world, bot, spec)
    bot.joints.set_motor("down", 0.0, 1e4)
    run(world, plugin, 6.0)
    assert world.engine.attachments() == {}  # it has to rest for ten decisions
    run(world, plugin, 3.5)
    assert list(world.engine.attachments()) == [("gripper", "bot", "g")]
    height = ball.pose.position[2]
    bot.joints.set_motor("down", -1.0, 1e4)
    run(world, plugin, 0.5)
    assert ball.pose.position[2] == pytest.approx(height, abs=1e-3)  # the palm has it
    run(world, plugin, 2.0)
    assert world.engine.attachments() == {} and ball.pose.position[2] < height - 0.1


def test_parameters_of_a_gripper_of_sdf(world):
    bot = world.spawn_sdf("bot", sdf_gripper(detach=7, least=3), Pose(), str)
    (spec,) = bot.description.sensors
    assert (spec.attach, spec.detach, spec.least, spec.fingers) == (1, 7, 3, ("shelf",))
    other = world.spawn_sdf("other", sdf_gripper(finger="x"), Pose(), str)
    assert other.description.sensors == []
    assert any("must be links of the model" in text for text in other.description.warnings)


def test_its_state_is_saved_with_the_worlds(world, topics):
    _, ball, plugin = held(world, topics)
    run(world, plugin, 2.0)
    state, saved = world.save_state(), plugin.get_state()
    run(world, plugin, 0.3)
    there, counts = ball.pose, dict(plugin._counts)
    world.restore_state(state)
    plugin.set_state(saved)
    run(world, plugin, 0.3)
    assert (ball.pose, plugin._counts) == (there, counts)


# by service ------------------------------------------------------------------------------------
class Jobs:
    @staticmethod
    def call(work):
        return work()


@pytest.fixture(name="services", params=[False, True])
def _services(request, monkeypatch):
    """Service name -> handler; with the original's package, and without it."""
    made = {}
    monkeypatch.setattr(
        attaching.rospy, "Service", lambda name, kind, call: made.update({name: (kind, call)})
    )
    if request.param:
        really = builtins.__import__

        def without(name, *rest):
            if name.startswith("gazebo_ros_link_attacher"):
                raise ImportError(name)
            return really(name, *rest)

        monkeypatch.setattr(builtins, "__import__", without)
    return made


def test_links_are_attached_and_detached_by_service(world, services):
    post = BALL.replace("ball", "post")
    held = (
        '<link name="world"/><joint name="f" type="fixed"><parent link="world"/><child link="l"/>'
    )
    world.spawn_urdf("post", f"{post[:-8]}{held}</joint></robot>", Pose((0, 0, 2)), str)
    ball = world.spawn_urdf("ball", BALL, Pose((0.5, 0.0, 2.0)), str)
    LinkAttacher(world, Jobs)
    assert sorted(services) == ["/link_attacher_node/attach", "/link_attacher_node/detach"]

    def ask(name, *names):
        kind, call = services[f"/link_attacher_node/{name}"]
        assert kind._md5sum == attaching.MD5_SUM and kind._type == "gazebo_ros_link_attacher/Attach"
        request = kind._request_class(**dict(zip(FIELDS, names)))
        return kind._response_class(**call(request)).ok

    names = ("post", "l", "ball", "l")
    assert not ask("detach", *names)
    assert not ask("attach", "post", "l", "nobody", "l")
    assert not ask("attach", "post", "x", "ball", "l")
    assert ask("attach", *names)
    world.step(500)
    assert ball.pose.position == pytest.approx((0.5, 0.0, 2.0), abs=2e-3)
    assert ask("detach", *names) and ask("detach", *names)
    world.step(300)
    assert ball.pose.position[2] < 1.7
    assert ask("attach", *names)
    world.step(3000)
    assert ball.pose.position == pytest.approx((0.5, 0.0, 2.0), abs=5e-3)


def test_the_service_is_that_of_the_package_if_it_is_there():
    kind = attach_type()
    assert kind._request_class.__slots__ == list(FIELDS) and kind._response_class.__slots__ == [
        "ok"
    ]


def test_a_world_that_has_the_plugin():
    text = '<sdf version="1.6"><world name="w"><plugin name="a" filename="{}"/></world></sdf>'
    described = sdf.parse_world(text.format("libgazebo_ros_link_attacher.so"), str)
    assert (described.plugins, described.warnings) == (["gazebo_ros_link_attacher"], [])
    described = sdf.parse_world(text.format("libx.so"), str)
    assert described.plugins == [] and "'libx.so' is not known here" in described.warnings[0]


# a lift, a fluid ----------------------------------------------------------------------------------
LIFT = (
    f'<robot name="lift"><link name="world"/><link name="cabin">{INERTIA.format(800)}</link>'
    f'<link name="door">{INERTIA.format(1)}</link><joint name="up" type="prismatic"><parent '
    'link="world"/><child link="cabin"/><axis xyz="0 0 1"/></joint><joint name="slide" '
    'type="prismatic"><parent link="cabin"/><child link="door"/><axis xyz="0 1 0"/><limit '
    'lower="0" upper="1" effort="99" velocity="9"/><dynamics damping="2"/></joint><gazebo><plugin '
    'name="e" filename="libgazebo_ros_elevator.so"><lift_joint>up</lift_joint><door_joint>slide'
    "</door_joint><floor_height>2</floor_height><door_wait_time>1</door_wait_time>{0}</plugin>"
    "</gazebo></robot>"
)


def test_a_lift_goes_to_a_floor_and_opens_its_door_there(world, topics):
    model = world.spawn_urdf("lift", LIFT.replace("{0}", ""), Pose(), str)
    received = FakeReceivedCounts()
    plugin = plugin_of(world, model, model.description.sensors[0], received=received)
    assert received.topic == "/elevator" and topics == {}
    run(world, plugin, 0.5)
    received.take(String("1"))
    received.take(String("5"))  # it is busy
    seen = []
    for _ in range(90):
        run(world, plugin, 0.1)
        positions = model.joints.state()[0]
        seen.append((positions["up"], positions["slide"]))
    assert seen[0][1] < 0.06 and max(door for _, door in seen) > 0.9 and seen[-1][1] < 0.1
    sunk = 800.0 * 9.81 / 1e5  # its weight over the gain
    assert seen[-1][0] == pytest.approx(2.0 - sunk, abs=0.01)
    for text in ("nowhere", "9" * 400, "-" + "0" * 500 + "2147483649"):
        received.take(String(text))
    received.take(String(" 0th"))
    run(world, plugin, 3.0)
    assert model.joints.state()[0]["up"] == pytest.approx(-sunk, abs=0.01)


def test_its_topic_and_defaults():
    text = LIFT.replace("<floor_height>2</floor_height><door_wait_time>1</door_wait_time>", "")
    (spec,) = parse_urdf(text.replace("{0}", "<topic>t</topic>"), str, "l").sensors
    assert (spec.topic, spec.height, spec.wait) == ("/t", 3.0, 5.0)
    names = "<topic>t</topic><robotNamespace>zz</robotNamespace>"
    (spec,) = parse_urdf(text.replace("{0}", names), str, "l").sensors
    assert spec.topic == "/zz/t"


@pytest.mark.parametrize(
    "shape, volume",
    [
        ('<box size="0.1 0.2 0.3"/>', 0.006),
        ('<sphere radius="0.1"/>', 4.0 / 3.0 * math.pi * 1e-3),
        ('<cylinder radius="0.1" length="0.2"/>', math.pi * 2e-3),
    ],
)
def test_what_displaces_its_own_weight_floats(world, topics, shape, volume):
    assert topics == {}
    body = f"<link name='l'>{INERTIA.format(2)}<collision><geometry>{shape}</geometry></collision>"
    text = (
        f"<robot name='r'>{body}</link><gazebo><plugin name='b' filename='libBuoyancyPlugin.so'>"
        f"<fluid_density>{2.0 / volume}</fluid_density></plugin></gazebo></robot>"
    )
    model = world.spawn_urdf("r", text, Pose((0.0, 0.0, 1.0)), str)
    plugin = plugin_of(world, model, model.description.sensors[0])
    plugin.update(0.0, 0.0)
    run(world, plugin, 0.5)
    assert model.pose.position == pytest.approx((0.0, 0.0, 1.0), abs=1e-6)


def test_a_volume_that_is_given_and_its_center(world, topics):
    assert topics == {}
    given = (
        "<fluid_density>1000</fluid_density><link name='l'><center_of_volume>0.1 0 0"
        "</center_of_volume><volume>0.002</volume></link><link name='x'/>"
    )
    text = (
        f"<robot name='r'><link name='l'>{INERTIA.format(2)}</link><gazebo><plugin name='b' "
        f"filename='libBuoyancyPlugin.so'>{given}</plugin></gazebo></robot>"
    )
    model = world.spawn_urdf("r", text, Pose(), str)
    assert any("'x' has volume 0" in text for text in model.description.warnings)
    plugin = plugin_of(world, model, model.description.sensors[0])
    plugin.update(0.0, 0.0)
    world.step()
    _, linear, angular = model.link_state("l")
    assert linear[2] == pytest.approx(0.0, abs=1e-9)
    assert angular[1] == pytest.approx(-2.0 * 9.81 * 0.1 / 0.01 * 1e-3, rel=1e-3)
