"""What watches sends the same bytes of steps that were recorded as it does after each step."""

import collections

import pytest
from bullet_bridge.loop.clock import SimClock
from bullet_bridge.loop.server import Server
from bullet_bridge.node import Config
from bullet_bridge.plugins import states, transforms
from bullet_bridge.plugins.base import ROS_SIDE, RosPart
from bullet_bridge.plugins.states import StateTopics
from bullet_bridge.robots import Robots
from bullet_bridge.transport.senders import sender
from bullet_sim.formats.sdf import world as sdf
from bullet_sim.plugins.drives import PlanarMovePlugin
from bullet_sim.pose import Pose
from bullet_sim.robots import Robot
from bullet_sim.world import World
from fake_impl import FakeCameras, FakeReceivedCounts, fake_publishers
from geometry_msgs.msg import Twist, Vector3
from test_server import Jobs, Wall

from bullet_bridge import robots

STEPS = 130
BATCH = 20
AXES = "".join(
    f'<{axis}><noise type="gaussian"><mean>0.1</mean><stddev>0.{number}</stddev>{{0}}</noise>'
    f"</{axis}>"
    for number, axis in enumerate("xyz", 2)
)
NOISE = (
    f"<angular_velocity>{AXES}</angular_velocity><linear_acceleration>{AXES}</linear_acceleration>"
)
IMU = """<gazebo reference="{link}"><sensor name="{name}" type="imu">
<update_rate>{rate}</update_rate><imu>{noise}</imu>
<plugin name="{name}" filename="libgazebo_ros_imu_sensor.so">
<topicName>{topic}</topicName><frameName>f</frameName><updateRateHZ>{rate}</updateRateHZ>
{tags}</plugin></sensor></gazebo>"""
IMUS = "".join(
    IMU.format(name=name, topic=topic, link=link, rate=rate, noise=noise, tags=tags)
    for name, topic, link, rate, noise, tags in (
        ("plain", "plain", "arm", 1000, "", ""),
        ("noisy", "noisy", "pad", 1000, NOISE.format(""), "<rpyOffset>0.1 0.2 0.3</rpyOffset>"),
        ("all", "all", "arm", 250, NOISE.format(""), "<gaussianNoise>0.1</gaussianNoise>"
         "<initialOrientationAsReference>true</initialOrientationAsReference>"),
        ("drifts", "drifts", "arm", 1000, NOISE.format("<bias_mean>1</bias_mean>"), ""),
        ("one", "shared", "base", 1000, "", ""),
        ("other", "shared", "arm", 500, "", ""),
    )
)  # fmt: skip
PLUGINS = "".join(
    f'<gazebo><plugin name="{name}" filename="lib{library}.so"><topicName>{name}</topicName>{tags}'
    "</plugin></gazebo>"
    for name, library, tags in (
        ("truth", "gazebo_ros_p3d", "<bodyName>arm</bodyName>"),
        ("noisy_truth", "gazebo_ros_p3d", "<bodyName>pad</bodyName><xyzOffsets>1 2 3</xyzOffsets>"
         "<gaussianNoise>0.1</gaussianNoise><twistFrame>child</twistFrame>"),
        ("placed", "gazebo_ros_p3d", "<bodyName>arm</bodyName><xyzOffset>1 2 3</xyzOffset>"
         "<rpyOffset>0.1 0.2 0.3</rpyOffset>"),
        ("relative", "gazebo_ros_p3d", "<bodyName>arm</bodyName><frameName>base</frameName>"),
        ("slow", "gazebo_ros_p3d", "<bodyName>arm</bodyName><updateRate>70</updateRate>"),
        ("model_imu", "gazebo_ros_imu", "<bodyName>arm</bodyName>"),
        ("hector", "hector_gazebo_ros_imu", "<bodyName>arm</bodyName>"
         "<accelDrift>1 1 1</accelDrift>"),
        ("gps", "hector_gazebo_ros_gps", "<bodyName>base</bodyName><updateRate>400</updateRate>"),
        ("field", "hector_gazebo_ros_magnetic", "<bodyName>arm</bodyName>"),
        ("joints", "gazebo_ros_joint_state_publisher", "<jointName>hinge</jointName>"
         "<updateRate>1000</updateRate>"),
        ("transforms", "paddock_state_publisher", "<updateRate>500</updateRate>"
         "<frameName>world</frameName><frameRate>1000</frameRate>"),
    )
)  # fmt: skip
LINKS = "".join(
    f'<link name="{name}"><inertial><origin xyz="0.1 0.2 0.3" rpy="0.3 0.2 0.1"/><mass value="1"/>'
    '<inertia ixx="0.1" iyy="0.2" izz="0.15" ixy="0.01" ixz="0" iyz="0"/></inertial></link>'
    for name in ("base", "arm", "pad")
)
ROBOT = f"""<robot name="bot">{LINKS}
<joint name="hinge" type="continuous"><parent link="base"/><child link="arm"/>
<origin xyz="0 0 0.5" rpy="0.4 0 0"/><axis xyz="0 1 0"/></joint>
<joint name="weld" type="fixed"><parent link="arm"/><child link="pad"/>
<origin xyz="0.2 0 0" rpy="0 0.3 0"/></joint>
<transmission name="t"><type>transmission_interface/SimpleTransmission</type><joint name="hinge">
<hardwareInterface>hardware_interface/EffortJointInterface</hardwareInterface></joint>
<actuator name="a"/></transmission>
<gazebo><plugin name="control" filename="libgazebo_ros_control.so"/></gazebo>
{IMUS}{PLUGINS}</robot>"""
NESTED = """<sdf version="1.6"><model name="outer"><link name="l"/>
<model name="inner"><pose>1 0 0 0 0 0</pose><link name="l"/></model></model></sdf>"""
CONTROLLERS = {
    "arm": {
        "type": "effort_controllers/JointPositionController",
        "joint": "hinge",
        "pid": {"p": 30.0, "i": 5.0, "d": 1.0},
    },
    "states": {"type": "joint_state_controller/JointStateController", "publish_rate": 1000},
}


class Control(Robot):
    """A robot's controllers, without their services."""

    def __init__(self, _jobs, world, model, namespace, received, _run):
        super().__init__(world, model, namespace, lambda out: sender(RosPart(received), out))
        for name, parameters in CONTROLLERS.items():
            self.manager.load(name, parameters)
            self.add(name)
        self.manager.switch(list(CONTROLLERS), [])
        self.manager.command("arm", [2.0])
        self.refresh()


def spawn_thrown(world):
    """A robot that is thrown; the model with parts."""
    model = world.spawn_urdf("bot", ROBOT, Pose((0.0, 0.0, 5.0), (0.1, 0.2, 0.3, 0.9)), str)
    model.set_state(model.pose, (1.0, 2.0, 3.0), (0.4, 0.5, 0.6))
    world.spawn_sdf("outer", NESTED, Pose((3.0, 0.0, 5.0)), str)
    return model


def recorded(monkeypatch, limit, spawn=spawn_thrown, commands=None):
    """Messages {topic: [bytes]} of a robot, in batches of at most some steps; how many steps each
    batch had, and of which classes the parts are that watch.

    Args:
        spawn: function of the World -> the robot's Model.
        commands: step after which one is sent -> what the drive gets.
    """
    topics = fake_publishers(monkeypatch, states, transforms)
    monkeypatch.setattr(transforms, "_fixed", transforms.FixedTransforms())
    monkeypatch.setattr(robots, "RobotControl", Control)
    world, wall = World(), Wall()
    batches = []
    step = world.step
    monkeypatch.setattr(world, "step", lambda *given: (batches.append(given[0]), step(*given)))
    try:
        world.spawn(sdf.ground_plane())
        model = spawn(world)
        jobs = Jobs(wall)
        jobs.call = lambda job: job()
        cameras = FakeCameras()
        cameras.set_sources = cameras.flush = lambda *_: None
        made = Robots(jobs, world, cameras, 7, FakeReceivedCounts())
        made.connect(model)
        config = Config(niceness=0, real_time_factor=0.0)
        clock = SimClock(0.0, world.time_step, lambda _times: None)
        server = Server(world, jobs, made, config, clock, wall.now)
        server.add_reporter(StateTopics("/gazebo", world, 0.0))
        ends = [*(commands or {}), STEPS]
        for end in ends:
            while world.step_count < end:
                server.advance(min(limit, end - world.step_count), throttle=True)
            if end in (commands or {}):
                drive = next(part for part in made.parts if isinstance(part, PlanarMovePlugin))
                drive._on_command(commands[end])
        watching = {type(part) for part in made.parts if part.watches}
    finally:
        world.close()
    return {name: topic.messages for name, topic in topics.items()}, batches, watching


def test_messages_of_recorded_steps_are_those_of_single_steps(monkeypatch):
    single, batches, watching = recorded(monkeypatch, 1)
    assert batches == [1] * STEPS
    several, batches, _ = recorded(monkeypatch, BATCH)
    assert max(batches) == BATCH
    assert {name: len(messages) for name, messages in single.items() if messages} == {
        name: len(messages) for name, messages in several.items() if messages
    }
    differing = [name for name, messages in single.items() if messages != several[name]]
    assert not differing
    known = {part for part in ROS_SIDE.values() if part.watches is True}
    assert watching == known, "each part that watches is in the robot above"
    counts = collections.Counter(len(messages) for messages in single.values())
    assert counts[STEPS] >= 12, counts


BUMPER = """<sensor name="{name}" type="contact"><update_rate>{rate}</update_rate>
<contact><collision>{collision}</collision></contact>
<plugin name="{name}" filename="libgazebo_ros_bumper.so"><bumperTopicName>{name}</bumperTopicName>
<frameName>base</frameName></plugin></sensor>"""
BOX = """<collision name="{name}"><pose>{x} 0 0 0 0 0</pose><geometry><box><size>{size}</size></box>
</geometry></collision>"""
INERTIAL = """<inertial><mass>{0}</mass>
<inertia><ixx>{1}</ixx><iyy>{1}</iyy><izz>{1}</izz></inertia></inertial>"""
P3D = """<plugin name="{0}" filename="libgazebo_ros_p3d.so"><bodyName>base</bodyName>
<topicName>{0}</topicName></plugin>"""
OMNI = f"""<sdf version="1.6"><model name="omni"><pose>0 0 0.0499 0 0 0.3</pose><link name="base">
{INERTIAL.format(5, 0.1)}{BOX.format(name="c", x=0, size="0.4 0.3 0.1")}
{BOX.format(name="nose", x=0.22, size="0.04 0.1 0.1")}
{BUMPER.format(name="every_step", rate=1000, collision="c")}
{BUMPER.format(name="nose_bumper", rate=300, collision="nose")}</link>
<link name="lid"><pose>0 0 0.1 0 0 0</pose>{INERTIAL.format(1, 0.01)}
{BOX.format(name="c", x=0, size="0.2 0.2 0.05")}
{BUMPER.format(name="lid_bumper", rate=1000, collision="c")}</link>
<joint name="hinge" type="revolute"><parent>base</parent><child>lid</child>
<axis><xyz>0 0 1</xyz></axis></joint>
{{before}}<plugin name="drive" filename="libgazebo_ros_planar_move.so">
<commandTopic>cmd_vel</commandTopic><odometryTopic>odom</odometryTopic><odometryFrame>odom</odometryFrame><cmdTimeout>0.043</cmdTimeout>
<odometryRate>70</odometryRate><robotBaseFrame>base</robotBaseFrame></plugin>
{P3D.format("after")}</model></sdf>"""
THING = """<sdf version="1.6"><model name="thing"><static>{0}</static><link name="l">{1}
{2}</link></model></sdf>"""
COMMANDS = {
    5: Twist(Vector3(1.0, 0.2, 0.0), Vector3(0.0, 0.0, 1.0)),
    40: Twist(Vector3(1.5, -0.3, 0.0), Vector3(0.0, 0.0, -2.0)),
    47: Twist(Vector3(1.5, 0.0, 0.0), Vector3(0.0, 0.0, 0.0)),
}


def spawn_omni(before=""):
    """Function that spawns a base that planar_move drives against things; before: plugins."""

    def spawn(world):
        box = BOX.format(name="c", x=0, size="0.2 0.2 0.2")
        moving = THING.format(0, INERTIAL.format(0.5, 0.002), box)
        world.spawn_sdf("loose", moving, Pose((0.36, 0.06, 0.101)), str)
        world.spawn_sdf("above", moving, Pose((0.0, 0.0, 0.28)), str)
        world.spawn_sdf("post", THING.format(1, "", box), Pose((0.3, 0.25, 0.1)), str)
        return world.spawn_sdf("omni", OMNI.format(before=before), Pose(), str)

    return spawn


def test_a_base_that_follows_its_commands_needs_no_step_of_its_own(monkeypatch):
    single, batches, _ = recorded(monkeypatch, 1, spawn_omni(), COMMANDS)
    assert batches == [1] * STEPS
    several, batches, watching = recorded(monkeypatch, BATCH, spawn_omni(), COMMANDS)
    assert max(batches) >= 10 and len(batches) < STEPS / 4, batches
    assert {kind.__name__ for kind in watching} >= {"ContactSensor"}
    assert not [name for name, messages in single.items() if messages != several[name]]
    told = {name: len(messages) for name, messages in several.items()}
    assert told["/every_step"] == told["/lid_bumper"] == told["/after"] == STEPS
    pairs = {
        (state.collision1_name, state.collision2_name)
        for topic in ("/every_step", "/lid_bumper", "/nose_bumper")
        for message in several[topic]
        for state in message.states
    }
    assert len(pairs) >= 4, pairs  # with the ground, and with things of which either is first
    assert {one.split("::")[0] for one, _ in pairs} > {"omni"}, pairs
    speeds = [message.twist.twist.linear.x for message in several["/after"]]
    assert max(speeds) > 0.9 and speeds[-1] == 0.0  # it has stopped by its time-out


@pytest.mark.parametrize("rate, most", [(1000, 1), (100, 10)])
def test_what_tells_velocities_before_they_are_set_ends_a_batch(monkeypatch, rate, most):
    before = P3D.format("before").replace(
        "<bodyName>", f"<updateRate>{rate}</updateRate><bodyName>"
    )
    single, _, _ = recorded(monkeypatch, 1, spawn_omni(before), COMMANDS)
    several, batches, _ = recorded(monkeypatch, BATCH, spawn_omni(before), COMMANDS)
    assert max(batches) == most
    assert single == several
    assert several["/before"][-1].twist != several["/after"][-1].twist
