"""Any robot as an environment: spaces, commands, observations, tasks, errors; without ROS."""

import importlib.util
import math
import pathlib
import subprocess
import sys

import gymnasium
import numpy as np
import pytest
import yaml
from bullet_sim.pose import Pose
from gymnasium.utils.env_checker import check_env
from paddock_gym.envs.robot import RobotEnv
from paddock_gym.envs.robots import RobotsEnv
from paddock_gym.envs.tasks import Lane, Task
from paddock_gym.envs.worlds import RobotWorldsEnv
from paddock_gym.errors import GymError, RewardError
from paddock_gym.simulation.recipe import Recipe, Spawn
from paddock_gym.simulation.robot_world import RobotWorld
from pettingzoo.test import parallel_api_test

import paddock_gym  # noqa: F401  registers its environments

CART = str(pathlib.Path(__file__).resolve().parents[1] / "examples" / "cart.urdf")
ON_GROUND = (0.0, 0.0, 0.1, 0.0, 0.0, 0.0)
TOPICS = ("scan", "odom", "imu", "joint_states", "camera/image_raw", "bumper", "truth")
ARM = """<robot name="arm"><link name="world"/><link name="base"><inertial><mass value="1"/>
<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="held" type="fixed"><parent link="world"/><child link="base"/></joint>
<link name="rod"><inertial><mass value="1"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0"
iyz="0"/></inertial></link><joint name="elbow" type="revolute"><parent link="base"/>
<child link="rod"/><axis xyz="0 0 1"/><limit lower="-1" upper="2" effort="30" velocity="3"/></joint>
<gazebo><plugin name="c" filename="libgazebo_ros_control.so"/></gazebo>TRANSMISSION</robot>"""
TRANSMISSION = """<transmission name="t"><type>transmission_interface/SimpleTransmission</type>
<joint name="elbow"><hardwareInterface>hardware_interface/EffortJointInterface</hardwareInterface>
</joint><actuator name="m"/></transmission>"""
ARM = ARM.replace("TRANSMISSION", TRANSMISSION + TRANSMISSION.replace("Effort", "Velocity"))
WALLS = """<sdf version="1.6"><world name="default"><include><uri>model://ground_plane</uri></include>
<model name="wall"><static>true</static><pose>2 0 0.5 0 0 0</pose><link name="l">
<collision name="c"><geometry><box><size>0.2 8 1</size></box></geometry></collision></link></model>
</world></sdf>"""


@pytest.fixture(name="make")
def _make():
    """Function: options -> RobotEnv of the cart; all are closed."""
    made = []

    def make(**options):
        if not {"urdf", "sdf", "world", "launch"} & set(options):
            options = {"urdf": CART, "pose": ON_GROUND, **options}
        made.append(RobotEnv(**options))
        return made[-1]

    yield make
    for env in made:
        env.close()


def test_every_observation_is_in_its_space_and_changes(make):
    env = make(observation=TOPICS, task="goal")
    assert isinstance(env.observation_space, gymnasium.spaces.Dict)
    first, _ = env.reset(seed=1)
    changed = {name: False for name in first}
    for _ in range(25):
        seen, *_ = env.step((0.5, 0.7))
        assert env.observation_space.contains(seen)
        for name, values in seen.items():
            changed[name] |= not np.array_equal(values, first[name])
    del changed["bumper"]  # it touches nothing
    assert all(changed.values()), changed


def test_a_command_moves_it_as_it_says(make):
    env = make(observation="odom:linear", vary=())
    env.reset()
    for _ in range(30):
        seen, *_ = env.step((0.5, 0.0))
    assert seen == pytest.approx((0.5, 0.0, 0.0), abs=0.01)
    assert env.state.robot.forward == pytest.approx(0.5, abs=0.01)
    assert env.state.robot.x == pytest.approx(0.5 * 3.0, abs=0.1)


def test_gymnasiums_checker_has_nothing_to_say(make):
    check_env(make(observation="scan", task="goal"), skip_render_check=True)


def test_a_run_repeats_to_the_bit(make):
    env = make(observation=("scan", "odom:position", "imu"), task="goal",
               vary=("friction", "mass", "delay", "noise"))  # fmt: skip
    actions = np.random.default_rng(1).uniform(-1.0, 1.0, (20, 2))
    runs = []
    for _ in range(2):
        seen = [env.reset(seed=3)[0], *(env.step(action)[0] for action in actions)]
        runs.append([{name: values.copy() for name, values in each.items()} for each in seen])
    for one, other in zip(*runs):
        assert all(np.array_equal(one[name], other[name]) for name in one)
    other = env.reset(seed=4)[0]
    assert not np.array_equal(other["scan"], runs[0][0]["scan"])


def test_several_worlds_are_each_as_it_is_alone(make):
    options = dict(urdf=CART, pose=ON_GROUND, observation="scan", task="goal")
    vector = RobotWorldsEnv(num_envs=2, **options)
    alone = make(**options)
    seen, _ = vector.reset(seed=7)
    single, _ = alone.reset(seed=8)
    assert all(np.array_equal(seen[name][1], single[name]) for name in single)
    for k in range(5):
        action = np.array([[0.3, 0.1 * k], [0.4, -0.1 * k]], np.float32)
        seen, rewards, *_ = vector.step(action)
        single, reward, *_ = alone.step(action[1])
        assert rewards[1] == reward
        assert all(np.array_equal(seen[name][1], single[name]) for name in single)
    vector.close()


def test_the_order_of_spawning_makes_no_difference(make):
    """What parts hold in a model from the start, such as brakes, is there after it was sorted."""
    text = pathlib.Path(CART).read_text(encoding="utf-8")
    carts = [
        Spawn(name, text, Pose((x, 0.0, 0.1)), f"/{name}") for name, x in (("a", 0.0), ("b", 1.0))
    ]
    seen = []
    for spawns in (carts, carts[::-1]):
        env = make(launch=Recipe(spawns=tuple(spawns)), action="a/cmd_vel", observation="truth:a",
                   settle=0.0)  # fmt: skip
        env.reset(seed=1)
        seen.append([env.step((0.5, 0.5))[0] for _ in range(3)])
    assert np.array_equal(*seen)


def test_it_is_registered():
    made = gymnasium.make("Paddock/Robot-v0", urdf=CART, pose=ON_GROUND, observation="truth")
    assert made.reset(seed=1)[0].shape == (13,)
    made.close()


def test_controllers_of_a_yaml_file_take_commands_with_their_limits(make, tmp_path):
    (tmp_path / "arm.urdf").write_text(ARM)
    kinds = {
        "position": ("effort_controllers/JointPositionController", (-1.0, 2.0), "rad"),
        "velocity": ("velocity_controllers/JointVelocityController", (-3.0, 3.0), "rad/s"),
        "effort": ("effort_controllers/JointEffortController", (-30.0, 30.0), "N m"),
    }
    for kind, (type_name, (low, high), unit) in kinds.items():
        entry = {"type": type_name, "joint": "elbow"}
        if kind == "position":
            entry["pid"] = {"p": 50.0, "d": 10.0}
        states = {"type": "joint_state_controller/JointStateController", "publish_rate": 100}
        (tmp_path / "c.yaml").write_text(yaml.safe_dump({"joints": states, "elbow": entry}))
        env = make(urdf=str(tmp_path / "arm.urdf"), controllers=str(tmp_path / "c.yaml"),
                   observation="joint_states:position")  # fmt: skip
        assert (env.action_space.low, env.action_space.high) == (low, high)
        assert unit in env.actions.names[0]
        env.reset(seed=1)
        before = env.step([0.5])[0]
        assert env.step([0.5])[0] != before, kind


@pytest.mark.parametrize(
    "option, default, other, more, seen",
    [
        (
            "massless_links", "leave_out", "keep",
            '<link name="flag"/><joint name="pole" type="continuous"><parent link="base"/>'
            '<child link="flag"/></joint>',
            lambda robot: "flag" in robot.bodies,
        ),
        (
            "fixed_joints", "keep", "merge",
            '<link name="world"/><joint name="held" type="fixed"><parent link="world"/>'
            '<child link="base"/></joint>',
            lambda robot: robot.body.is_fixed,
        ),
    ],
)  # fmt: skip
def test_choices_are_those_of_the_node(
    make, tmp_path, monkeypatch, option, default, other, more, seen
):
    text = pathlib.Path(CART).read_text(encoding="utf-8")
    path = tmp_path / "cart.urdf"
    path.write_text(text.replace("</robot>", f"{more}</robot>"))
    for given, expected in (({}, False), ({option: other}, True)):
        env = make(urdf=str(path), pose=ON_GROUND, **given)
        assert seen(env.world.world.models["robot"]) == expected
    read = pytest.importorskip("paddock_gym.simulation.launch_file").from_launch
    launch, node = tmp_path / "cart.launch", '<node name="gazebo" pkg="bullet_bridge" type="bridge"'
    launch.write_text(f'<launch>{node}><param name="{option}" value="{other}"/></node></launch>')
    assert getattr(read(str(launch)), option) == other
    launch.write_text(f"<launch>{node}/></launch>")
    assert getattr(read(str(launch)), option) == default
    monkeypatch.setenv(f"PADDOCK_{option.upper()}", other)
    assert getattr(read(str(launch)), option) == other


FLOAT = (
    '<gazebo><plugin name="p" filename="libBuoyancyPlugin.so"><fluid_density>2e3</fluid_density>'
    '</plugin><plugin name="f" filename="libgazebo_ros_f3d.so"><bodyName>base</bodyName>'
    '<topicName>force</topicName></plugin><plugin name="hog" '
    'filename="libgazebo_ros_hand_of_god.so"><linkName>base</linkName></plugin></gazebo></robot>'
)


SONAR = (
    '<gazebo reference="base"><sensor name="sonar" type="ray"><pose>0.2 0 0.1 0 0.5 0</pose>'
    "<update_rate>20</update_rate><ray><scan><horizontal><samples>3</samples><min_angle>-0.1"
    "</min_angle><max_angle>0.1</max_angle></horizontal></scan><range><min>0.1</min><max>3</max>"
    '</range></ray><plugin name="sonar" filename="libgazebo_ros_range.so"><topicName>sonar'
    "</topicName><frameName>base</frameName><gaussianNoise>0.01</gaussianNoise></plugin></sensor>"
    "</gazebo></robot>"
)


def test_a_range_has_the_32_bits_of_its_message(make, tmp_path):
    text = pathlib.Path(CART).read_text(encoding="utf-8").replace("</robot>", SONAR)
    (tmp_path / "cart.urdf").write_text(text)
    env = make(urdf=str(tmp_path / "cart.urdf"), pose=ON_GROUND, observation="sonar:range")
    env.reset(seed=1)
    seen = [env.step((0.1, 0.0))[0][0] for _ in range(5)]
    assert len(set(seen)) == 5 and all(0.1 < value < 3.0 for value in seen), seen
    assert seen == [float(np.float32(value)) for value in seen]


def test_plugins_act_as_in_the_node_but_those_that_need_ros():
    floating = pathlib.Path(CART).read_text().replace("</robot>", FLOAT)
    world = RobotWorld(Recipe(spawns=(Spawn("cart", floating, Pose((0.0, 0.0, 0.1))),)))
    world.observe(("/force",))
    world.advance(200)
    assert world.world.model("cart").pose.position[2] > 0.15, "the fluid lifts it"
    assert np.any(world.topics["/force"].fields["wrench.force"])
    assert [text for text in world.warnings if "ROS alone" in text] == [
        "model 'cart': hog acts with ROS alone"
    ]
    world.close()


def test_a_robot_is_spawned_with_positions_of_its_joints():
    world = RobotWorld(Recipe(spawns=(Spawn("arm", ARM, joints={"elbow": 0.75}),)))
    assert world.world.model("arm").joints.positions_of(("elbow",)) == pytest.approx((0.75,))
    world.close()


def test_scaled_actions_and_limits(make):
    env = make(limits={"cmd_vel": ((0.0, -1.0), (0.5, 1.0))}, scaled=True)
    assert (env.action_space.low == -1.0).all() and (env.action_space.high == 1.0).all()
    assert env.actions.numbers((0.0, 1.0)).tolist() == [0.25, 1.0]


def test_goal_pays_the_way_and_ends_there_or_at_an_obstacle(make):
    env = make(observation="scan", task="goal", task_options={"obstacles": 3})
    ends = set()
    for seed in range(3):
        env.reset(seed=seed)
        goal, memory = env.state.memory["goal"], env.state.memory
        first, gained = memory["distance"], 0.0
        for _ in range(300):
            turn = math.atan2(*(g - r for g, r in zip(goal[::-1], env.state.robot[1::-1])))
            turn = math.remainder(turn - env.state.robot.yaw, 2.0 * math.pi)
            _, reward, terminated, _, info = env.step((0.5 * (abs(turn) < 0.5), 2.0 * turn))
            gained += reward
            if terminated:
                break
        ends.add(info["end"])
        bonus = {"reached": 5.0, "crashed": -5.0}[info["end"]]
        steps = env.state.steps
        assert gained == pytest.approx(first - memory["distance"] - 0.01 * steps + bonus)
    assert "reached" in ends


def test_a_lane_pays_the_way_and_ends_off_it(make):
    square = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)]
    env = make(observation="truth", task="lane", task_options={"points": square})
    seen, _ = env.reset(options={"start": (1.0, 0.0, 0.0)})
    assert seen["lane"] == pytest.approx((0.0, 0.0, 1.0, 0.0, 1.0), abs=0.03)
    total = sum(env.step((0.5, 0.0))[1] for _ in range(20))
    assert total == pytest.approx(env.state.robot.x - 1.0, abs=0.05)
    end = ""
    while not end:
        *_, info = env.step((0.5, 0.0))
        end = info["end"]
    assert end == "off_lane" and env.state.robot.x > 4.4


def test_a_lanes_arithmetic():
    lane = Lane([(0.0, 0.0), (2.0, 0.0), (2.0, 2.0)], closed=False)
    assert lane.length == 4.0
    assert lane.place(3.0) == pytest.approx((2.0, 1.0, math.pi / 2.0))
    assert lane.nearest(1.0, 0.25) == pytest.approx((1.0, 0.25))
    assert lane.nearest(2.25, 1.0) == pytest.approx((3.0, -0.25))


def test_wall_and_crash(make, tmp_path):
    (tmp_path / "walls.world").write_text(WALLS)
    env = make(urdf=CART, world=str(tmp_path / "walls.world"), pose=ON_GROUND, observation="scan",
               task="wall", task_options={"scan": "/scan", "distance": 0.7})  # fmt: skip
    env.reset(seed=1, options={"start": (1.2, -2.0, math.pi / 2.0)})
    rewards = [env.step((0.5, 0.0))[1] for _ in range(15)]
    assert rewards[-1] == pytest.approx(0.05, abs=0.01)  # along it, at the distance
    env.reset(seed=1, options={"start": (1.0, 0.0, 0.0)})
    info = {"end": ""}
    while not info["end"]:
        _, reward, _, _, info = env.step((0.5, 0.0))
    assert (info["end"], info["touched"]) == ("crashed", "wall") and reward < -0.9


class Own(Task):
    """Ends after three actions."""

    def end(self, state):
        return "three" if state.steps == 3 else ""


def test_tasks_of_ones_own(make, tmp_path, monkeypatch):
    (tmp_path / "my_task.py").write_text("def speed(state):\n    return state.robot.forward\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    env = make(task=Own, reward="my_task:speed")
    env.reset(seed=1)
    results = [env.step((0.5, 0.0)) for _ in range(3)]
    assert [row[2] for row in results] == [False, False, True]
    assert results[-1][1] == env.state.robot.forward > 0.1


@pytest.mark.parametrize(
    "options, text",
    [
        ({"observation": "scam"}, r"observation is '/scam', must be one of .*did you mean '/scan'"),
        ({"observation": "scan:range"}, "field of /scan is 'range', must be one of ranges"),
        ({"observation": "truth:car"}, "model of an observation is 'car', must be one of"),
        ({"observation": "truth:robot::arm"}, "link of 'robot' is 'arm', must be one of base"),
        ({"action": "cmd_val"}, "action is '/cmd_val', must be one of /cmd_vel"),
        ({"limits": {"cmd_vel": (0.0, (1.0, 1.0, 1.0))}}, "limits of /cmd_vel are"),
        ({"task": "gaol"}, "task is 'gaol', must be one of none, goal"),
        ({"task": "goal", "task_options": {"size": 1}}, "task_options are"),
        ({"reward": "no_such_module:f"}, "reward is 'no_such_module:f'"),
        ({"reward": "speed"}, "reward is 'speed', must be an object or 'module:function'"),
        ({"vary": ("wind",)}, "vary has 'wind'; there are friction"),
        ({"control_rate": math.nan}, "control_rate is nan"),
        ({"urdf": "none.urdf"}, "urdf is 'none.urdf': there is no such file"),
        ({"urdf": CART, "world": "none.world"}, "world is 'none.world'"),
        ({"urdf": CART, "sdf": CART}, "urdf and sdf are both given"),
        ({"urdf": CART, "pose": (1.0,)}, r"pose is \(1.0,\), must be six numbers"),
        ({"urdf": CART, "controllers": CART}, "controllers is"),
        ({"urdf": CART, "launch": "a b.launch"}, "launch and urdf are given"),
        ({"urdf": "", "launch": ""}, "launch, urdf, sdf or world has to be given"),
        ({"render_mode": "ansi"}, "render_mode is 'ansi'"),
        ({"massless_links": "drop"}, "massless_links is .drop., must be one of leave_out, keep"),
        ({"fixed_joints": "drop"}, "fixed_joints is .drop., must be one of keep, merge"),
        ({"robot": "husky"}, "robot is 'husky'; models are ground_plane, robot"),
    ],
)
def test_wrong_options_are_named(make, options, text):
    with pytest.raises(GymError, match=text):
        make(**options)


def test_wrong_actions_and_rewards_are_named(make):
    env = make(reward=lambda state: math.nan)
    env.reset(seed=1)
    with pytest.raises(GymError, match=r"action has the shape \(3,\), must be \(2,\): /cmd_vel"):
        env.step((1.0, 2.0, 3.0))
    with pytest.raises(GymError, match=r"action is \[nan, 0.0\], must be finite numbers"):
        env.step((math.nan, 0.0))
    with pytest.raises(RewardError, match="reward is nan, must be a finite number"):
        env.step((0.0, 0.0))
    env.task.reward = lambda state: state.nothing
    with pytest.raises(RewardError, match="reward of the task raised AttributeError"):
        env.step((0.0, 0.0))
    with pytest.raises(GymError, match="reset has 'place'; there is start"):
        env.reset(options={"place": 1})


def test_plain_files_import_nothing_of_ros():
    script = (
        "import sys, paddock_gym.envs.robot as robot; "
        f"robot.RobotEnv(urdf={CART!r}, observation='scan'); "
        "print([name for name in ('rospy', 'roslaunch', 'rosgraph', 'rospkg', 'roslib') "
        "if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.stdout.strip() == "[]", done.stderr


def test_a_launch_file_needs_ros(make, monkeypatch):
    monkeypatch.setitem(sys.modules, "roslaunch", None)
    with pytest.raises(GymError, match="launch is 'a b.launch', which needs ROS"):
        make(launch="a b.launch")


@pytest.mark.skipif(not importlib.util.find_spec("roslaunch"), reason="there is no ROS here")
def test_a_launch_file_that_is_not_there(make, tmp_path):
    with pytest.raises(GymError, match=r"launch is 'gazebo_ros none.launch': .*none.launch"):
        make(launch="gazebo_ros none.launch")
    path = tmp_path / "lacks.launch"
    path.write_text('<launch><include file="$(find no_such_package)/a.launch"/></launch>')
    with pytest.raises(GymError, match=r"lacks.launch': .*no_such_package"):
        make(launch=str(path))


def test_a_robot_whose_motion_is_not_finite_is_named(make):
    env = make(observation="imu")
    env.reset(seed=1)
    link_motion = env.world.world.model("robot").body.link_motion
    body = env.world.world.model("robot").body
    body.link_motion = lambda link, _=None: ((0.0,) * 3, (0.0,) * 4, *link_motion(link)[2:])
    with pytest.raises(GymError, match=r"model 'robot' cannot be measured at .* not finite"):
        env.step((0.0, 0.0))


def test_robots_of_one_world_pass_pettingzoos_test():
    carts = two_carts({"observation": "a/scan", "task": "explore"},
                      {"observation": ("b/odom", "truth:b")})  # fmt: skip
    parallel_api_test(carts, num_cycles=60)
    carts.close()


def two_carts(*options):
    """RobotsEnv of the carts a and b, two metres apart, b in front of a."""
    text = pathlib.Path(CART).read_text(encoding="utf-8")
    spawns = [
        Spawn(name, text, Pose((x, 0.0, 0.1)), f"/{name}") for name, x in (("a", 0.0), ("b", 2.0))
    ]
    return RobotsEnv(dict(zip("ab", options)), launch=Recipe(spawns=tuple(spawns)), max_steps=100)


def test_robots_of_one_world_touch_each_other():
    carts = two_carts({"observation": "truth:b"}, {"observation": "truth:b"})
    seen, _ = carts.reset(seed=1)
    assert np.array_equal(seen["a"], seen["b"])
    forward, still = np.array((0.8, 0.0)), np.zeros(2)
    infos, terminated = {}, {"a": False}
    while not terminated["a"]:
        _, _, terminated, _, infos = carts.step({"a": forward, "b": still})
    assert infos["a"]["touched"] == "b" and infos["b"]["touched"] == "a"
    assert carts.agents == []
    with pytest.raises(GymError, match="actions of b are missing"):
        carts.reset(seed=1)
        carts.step({"a": forward})
    carts.close()


@pytest.mark.parametrize(
    "robots, text",
    [
        ({}, "robots is empty"),
        ({"c": {}}, "robot is 'c'; models are"),
        ({"a": {"sensor": 1}}, "options of a robot: .*sensor"),
    ],
)
def test_wrong_options_of_several_robots_are_named(robots, text):
    cart = Spawn("a", pathlib.Path(CART).read_text(encoding="utf-8"), Pose(), "/a")
    with pytest.raises(GymError, match=text):
        RobotsEnv(robots, launch=Recipe(spawns=(cart,)))
