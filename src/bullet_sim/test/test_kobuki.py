"""The base of a TurtleBot 2, libgazebo_ros_kobuki.so: drive, odometry, IMU and events."""

import math
import types

import pytest
from bullet_sim.formats.sdf import world as sdf
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.parts.base import PARTS, PartContext
from bullet_sim.plugins.kobuki import TAGS, KobukiSpec
from bullet_sim.plugins.rules import NEAREST, FramePrefix
from bullet_sim.pose import Pose
from urdf_texts import joint, link, robot

SENSOR = '<gazebo reference="{}"><sensor name="{}" type="{}"><update_rate>50</update_rate>{}'
END = "</sensor></gazebo>"
RAYS = (
    "<ray><scan><horizontal><samples>3</samples><min_angle>-0.04</min_angle><max_angle>0.04"
    "</max_angle></horizontal></scan><range><min>0.01</min><max>0.15</max></range></ray>"
)
VALUES = {
    "left_wheel_joint_name": "left_joint",
    "right_wheel_joint_name": "right_joint",
    "wheel_separation": 0.23,
    "wheel_diameter": 0.07,
    "torque": 1.0,
    "velocity_command_timeout": 0.6,
    "cliff_detection_threshold": 0.04,
    "cliff_sensor_left_name": "cliff_left",
    "cliff_sensor_center_name": "cliff_center",
    "cliff_sensor_right_name": "cliff_right",
    "bumper_name": "bumpers",
    "imu_name": "imu",
    "wheel_drop_left_sensor_name": "drop_left",
    "wheel_drop_right_sensor_name": "drop_right",
}


def base(**changes):
    """A robot with the plugin; changes: of the VALUES, None: not there."""
    values = {name: text for name, text in {**VALUES, **changes}.items() if text is not None}
    tags = "".join(f"<{name}>{text}</{name}>" for name, text in values.items())
    wheel = '<cylinder radius="0.035" length="0.02"/>'
    links = [
        '<link name="base_footprint"/>',
        joint("fixed", "fixed", "base_footprint", "base", "0 0 0.01"),
        '<link name="base"><inertial><origin xyz="0 0 0.06"/><mass value="2.4"/><inertia '
        'ixx="0.02" iyy="0.02" izz="0.03" ixy="0" ixz="0" iyz="0"/></inertial><collision '
        'name="hull"><origin xyz="0 0 0.065"/><geometry><cylinder radius="0.17" length="0.06"/>'
        "</geometry></collision></link>",
        link("ball", 0.1, 1e-4, '<sphere radius="0.009"/>'),
        joint("ball_joint", "fixed", "base", "ball", "-0.1 0 0"),
        link("ball2", 0.1, 1e-4, '<sphere radius="0.009"/>'),
        joint("ball2_joint", "fixed", "base", "ball2", "0.1 0 0"),
        "".join(
            f'<gazebo reference="{name}"><mu1>0</mu1><mu2>0</mu2></gazebo>'
            for name in ("ball", "ball2")
        ),
    ]
    for side, y in (("left", 0.115), ("right", -0.115)):
        links += [
            link(side, 0.1, 1e-4, wheel, rpy="1.5708 0 0"),
            joint(f"{side}_joint", "continuous", "base", side, f"0 {y} 0.025"),
            SENSOR.format(side, f"drop_{side}", "contact",
                          f"<contact><collision>{side}_collision</collision></contact>") + END,
        ]  # fmt: skip
    for number, place in enumerate(("left", "center", "right")):
        at = f"0.13 {0.1 * (1 - number)} 0.02"
        links += [
            f'<link name="eye_{place}"/><joint name="eye_{place}_joint" type="fixed"><origin '
            f'xyz="{at}" rpy="0 1.5708 0"/><parent link="base"/><child link="eye_{place}"/>'
            "</joint>",
            SENSOR.format(f"eye_{place}", f"cliff_{place}", "ray", RAYS) + END,
        ]
    hull = "base_footprint_fixed_joint_lump__hull_collision"
    links += [
        SENSOR.format("base", "bumpers", "contact",
                      f"<contact><collision>{hull}</collision></contact>") + END,
        SENSOR.format("base", "imu", "imu", "") + END,
        f'<gazebo><plugin name="k" filename="libgazebo_ros_kobuki.so">{tags}</plugin></gazebo>',
    ]  # fmt: skip
    return robot(*links)


def twist(forward, turn=0.0):
    vector = types.SimpleNamespace
    return vector(linear=vector(x=forward, y=0.0), angular=vector(z=turn))


class Recorded:
    """What a part sends on a topic: (time, *values) of each message."""

    def __init__(self):
        self.sent, self.variances = [], None

    def has_subscribers(self):
        return True

    def send(self, time, *values, **_):
        self.sent.append((time, *values))

    def set_variances(self, *variances):
        self.variances = variances

    def numbers(self):
        """Of each message of kobuki_msgs, without its time."""
        return [tuple(value[0] for value in values) for _, *values in self.sent]


class Bot:
    """A base on the ground of a world, and what it sends."""

    def __init__(self, world, z=0.0, **changes):
        self.world, self.topics = world, {}
        self.model = world.spawn_urdf("bot", base(**changes), Pose((0.0, 0.0, z)), str)
        [self.spec] = self.model.description.sensors

        def connect(output):
            return self.topics.setdefault(output.topic.rpartition("/")[2], Recorded())

        context = PartContext(world, self.model, self.spec, connect=connect)
        self.part = PARTS.of(self.spec)(context)
        self.part.reset(world.time)

    def run(self, seconds, command=None):
        for step in range(round(seconds / self.world.time_step)):
            if command is not None and step % 100 == 0:
                self.part._on_command(command)
            self.world.step()
            self.part.update(self.world.time, self.world.time_step)

    def place(self, x, z):
        self.model.set_state(Pose((x, 0.0, z)), (0.0,) * 3, (0.0,) * 3)


@pytest.fixture(name="bot")
def _bot(world):
    world.spawn(sdf.ground_plane())
    bot = Bot(world)
    bot.run(0.3)
    return bot


def test_a_base_is_read_with_its_sensors():
    model = parse_urdf(base(publish_tf=1, update_rate=50, robotNamespace="/"), str, "mobile_base")
    assert model.warnings == [], "a sensor that the plugin reads needs no topic"
    [spec] = model.sensors
    assert isinstance(spec, KobukiSpec) and set(spec.sensors) == set(TAGS)
    assert (spec.left, spec.right) == (("left_joint",), ("right_joint",))
    assert (spec.separation, spec.diameter, spec.timeout) == (0.23, 0.07, 0.6)
    assert (spec.rate, spec.publish_tf, spec.threshold) == (50.0, True, 0.04)
    assert spec.command_topic == "/mobile_base/commands/velocity"
    assert (spec.topic, spec.states_topic) == ("/odom", "/joint_states")
    assert (spec.frame_id, spec.child_frame_id) == ("odom", "base_footprint")
    [spec] = parse_urdf(base(robotNamespace="tb"), str, "robot").sensors
    prefix = FramePrefix(NEAREST, "tb")
    assert {frame.prefix for frame in (spec.frame_id, spec.child_frame_id)} == {prefix}
    [spec] = parse_urdf(base(), str, "robot").sensors
    assert (spec.topic, spec.rate, spec.publish_tf) == ("/robot/odom", 0.0, False)
    assert spec.command_topic == "/robot/mobile_base/commands/velocity"


@pytest.mark.parametrize("tag", VALUES)
def test_without_a_tag_the_plugin_is_left_out_as_upstream(tag):
    model = parse_urdf(base(**{tag: None}), str, "bot")
    assert model.sensors == []
    assert any("libgazebo_ros_kobuki.so" in text for text in model.warnings), model.warnings


@pytest.mark.parametrize(
    "changes, words",
    [
        ({"bumper_name": "imu"}, ["bumper_name 'imu'", "sensor of type contact", "bumpers"]),
        ({"imu_name": "other"}, ["'other'", "type imu in base_footprint", "are imu"]),
        ({"cliff_sensor_left_name": "eye"}, ["'eye'", "cliff_left, cliff_center, cliff_right"]),
        ({"left_wheel_joint_name": "gone"}, ["joints gone", "left_joint, right_joint"]),
        ({"wheel_diameter": 0}, ["wheelDiameter 0.0, must not be 0"]),
    ],
)
def test_a_name_of_nothing_is_told(changes, words):
    model = parse_urdf(base(**changes), str, "bot")
    assert model.sensors == []
    assert all(word in " ".join(model.warnings) for word in words), model.warnings


def test_it_drives_until_its_commands_are_too_old(bot):
    bot.run(2.0, twist(0.2))
    x = bot.model.pose.position[0]
    assert x == pytest.approx(0.4, abs=0.02)
    _, position, _, linear, angular = bot.topics["odom"].sent[-1]
    assert position[0] == pytest.approx(x, abs=0.01) and position[2] == 0.0
    assert linear == pytest.approx((0.2, 0.0, 0.0), abs=0.005) and angular[:2] == (0.0, 0.0)
    bot.run(0.4)
    assert bot.topics["odom"].sent[-1][3][0] == pytest.approx(0.2, abs=0.005), "0.5 s after it"
    bot.run(0.3)
    assert bot.topics["odom"].sent[-1][3][0] == pytest.approx(0.0, abs=0.005), "0.8 s after it"


def test_heading_of_the_odometry_is_that_of_the_imu(bot):
    bot.run(2.0, twist(0.1, 0.5))
    yaw = 2.0 * math.asin(bot.model.pose.orientation[2])
    _, _, orientation, _, angular = bot.topics["odom"].sent[-1]
    assert 0.8 < yaw < 1.05, "wheels slip"
    assert 2.0 * math.asin(orientation[2]) == pytest.approx(yaw, abs=0.02)
    time, turned, rate, force = bot.topics["imu_data"].sent[-1]
    assert angular[2] == rate[2] == pytest.approx(0.48, abs=0.04)
    assert force[2] == pytest.approx(9.8, abs=0.2) and turned[3] < 0.95
    rates = {values[2] for values in bot.topics["imu_data"].sent if values[0] > time - 0.0195}
    assert len(rates) <= 2, "it measures 50 times a second, whenever it publishes"
    assert bot.topics["imu_data"].variances == ([1e6, 1e6, 0.05], [1e6, 1e6, 0.05], [0.0] * 3)


def test_motors_are_switched_and_the_odometry_is_put_to_zero(bot):
    power = types.SimpleNamespace
    bot.part._on_power(power(state=0))
    bot.part._on_restart(None)
    x = bot.model.pose.position[0]
    bot.run(0.5, twist(0.2))
    assert bot.model.pose.position[0] == pytest.approx(x, abs=0.002)
    bot.part._on_power(power(state=7))  # neither
    bot.run(0.3, twist(0.2))
    assert bot.model.pose.position[0] == pytest.approx(x, abs=0.002)
    bot.part._on_power(power(state=1))
    bot.run(1.0, twist(0.2))
    assert bot.topics["odom"].sent[-1][1][0] == pytest.approx(0.2, abs=0.02)
    bot.part._on_restart(None)
    bot.run(0.001)
    assert bot.topics["odom"].sent[-1][1][0] < 0.001


def test_wheels_and_cliffs_are_told_when_it_is_lifted(bot):
    for topic in ("wheel_drop", "cliff"):
        bot.topics[topic].sent.clear()
    bot.place(0.0, 0.5)
    bot.run(0.1)
    assert bot.topics["wheel_drop"].numbers() == [(0, 1), (1, 1)]
    infinite = int(76123.0 * math.atan2(0.995, math.inf))
    assert bot.topics["cliff"].numbers() == [(number, 1, infinite) for number in range(3)]
    assert bot.topics["core"].numbers()[-1] == (0, 7, 3)
    bot.place(0.0, 0.0)
    bot.run(0.4)
    assert bot.topics["wheel_drop"].numbers()[2:] == [(0, 0), (1, 0)]
    readings = [numbers[2] for numbers in bot.topics["cliff"].numbers()[3:]]
    reading = int(76123.0 * math.atan2(0.995, 0.03)) & 0xFFFF
    assert len(readings) == 3 and readings == pytest.approx([reading] * 3, abs=200)
    assert bot.topics["core"].numbers()[-1] == (0, 0, 0)


WALL = (
    "<sdf version='1.6'><model name='wall'><static>true</static><pose>{} 0 0.5 0 0 {}</pose><link "
    "name='l'><collision name='c'><geometry><box><size>0.1 2 1</size></box></geometry></collision>"
    "</link></model></sdf>"
)


@pytest.mark.parametrize("turn, number", [(0.0, 1), (-0.8, 2), (0.8, 0)])
def test_a_bumper_is_told_by_the_direction_of_the_contact(bot, turn, number):
    bot.world.spawn_sdf("wall", WALL.format(0.4, turn), Pose(), str)
    bot.topics["bumper"].sent.clear()
    bot.run(1.5, twist(0.2))
    assert bot.topics["bumper"].numbers()[0] == (number, 1)
    pressed = [core[0] for core in bot.topics["core"].numbers()]
    assert (4, 2, 1)[number] in pressed
    bot.run(1.0, twist(-0.2))
    assert bot.topics["bumper"].numbers()[-1][1] == 0
    assert bot.topics["core"].numbers()[-1][0] == 0


def test_it_publishes_at_its_rate(world):
    world.spawn(sdf.ground_plane())
    bot = Bot(world, update_rate=30)
    bot.run(1.0)
    stamps = [round(values[0], 3) for values in bot.topics["odom"].sent]
    assert stamps[:3] == [0.034, 0.068, 0.102], "each period from the message before"
    assert {len(bot.topics[topic].sent) for topic in ("joint_states", "imu_data", "core")} == {
        len(stamps)
    }


def test_a_state_is_restored_to_the_bit(bot):
    bot.run(0.5, twist(0.1, 0.3))
    saved = bot.world.save_state(), bot.part.get_state()
    sent = []
    for _ in range(2):
        bot.world.restore_state(saved[0])
        bot.part.set_state(saved[1])
        for topic in bot.topics.values():
            topic.sent.clear()
        bot.run(0.3, twist(0.2, -0.3))
        sent.append({name: repr(topic.sent) for name, topic in bot.topics.items()})
    assert sent[0] == sent[1]
