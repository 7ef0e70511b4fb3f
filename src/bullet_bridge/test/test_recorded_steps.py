"""What watches sends the same bytes of steps that were recorded as it does after each step."""

import collections

from bullet_bridge.loop.clock import SimClock
from bullet_bridge.loop.server import Server
from bullet_bridge.node import Config
from bullet_bridge.plugins import states, transforms
from bullet_bridge.plugins.base import ROS_SIDE, RosPart
from bullet_bridge.plugins.states import StateTopics
from bullet_bridge.robots import Robots
from bullet_bridge.transport.senders import sender
from bullet_sim.formats.sdf import world as sdf
from bullet_sim.pose import Pose
from bullet_sim.robots import Robot
from bullet_sim.world import World
from fake_impl import FakeCameras, FakeReceivedCounts, fake_publishers
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


def recorded(monkeypatch, limit):
    """Messages {topic: [bytes]} of a robot that is thrown, in batches of at most some steps; how
    many steps each batch had, and of which classes the parts are that watch."""
    topics = fake_publishers(monkeypatch, states, transforms)
    monkeypatch.setattr(transforms, "_fixed", transforms.FixedTransforms())
    monkeypatch.setattr(robots, "RobotControl", Control)
    world, wall = World(), Wall()
    batches = []
    step = world.step
    monkeypatch.setattr(world, "step", lambda *given: (batches.append(given[0]), step(*given)))
    try:
        world.spawn(sdf.ground_plane())
        model = world.spawn_urdf("bot", ROBOT, Pose((0.0, 0.0, 5.0), (0.1, 0.2, 0.3, 0.9)), str)
        model.set_state(model.pose, (1.0, 2.0, 3.0), (0.4, 0.5, 0.6))
        world.spawn_sdf("outer", NESTED, Pose((3.0, 0.0, 5.0)), str)
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
        while world.step_count < STEPS:
            server.advance(min(limit, STEPS - world.step_count), throttle=True)
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
    known = {part for part in ROS_SIDE.values() if part.watches}
    assert watching == known, "each part that watches is in the robot above"
    counts = collections.Counter(len(messages) for messages in single.values())
    assert counts[STEPS] >= 12, counts
