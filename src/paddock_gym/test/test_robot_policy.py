"""What a policy's file says of a Robot-v0: observations by topic, actions as messages."""

from pathlib import Path

import numpy as np
import pytest
from networks import write
from paddock_gym.envs.describe import policy_description
from paddock_gym.envs.robot import RobotEnv
from paddock_gym.errors import GymError
from paddock_gym.policy.description import PolicyDescription, RobotActions
from paddock_gym.policy.onnx_policy import OnnxPolicy

CART = str(Path(__file__).resolve().parents[1] / "examples" / "cart.urdf")
SEEN = ("scan", "odom:linear", "imu", "truth")


@pytest.fixture(scope="module")
def env():
    made = RobotEnv(urdf=CART, action="cmd_vel", observation=SEEN, task="goal", scaled=True)
    yield made
    made.close()


def test_each_observation_names_its_topic(env):
    about = policy_description(env)
    assert about.observations == (*SEEN, "goal") and about.control_rate == 10.0
    scan, linear, imu = (about.sources[name] for name in SEEN[:3])
    assert (scan["topic"], scan["message"]) == ("/scan", "sensor_msgs/LaserScan")
    assert scan["fields"] == {"ranges": [24], "intensities": [24]} and scan["most"] == 6.0
    assert linear["fields"] == {"linear": [3]} and linear["message"] == "nav_msgs/Odometry"
    assert list(imu["fields"]) == ["orientation", "angular_velocity", "linear_acceleration"]
    assert about.sources["truth"] == {"link": "robot::base"}
    assert about.sources["goal"] == {"link": "robot::base", "area": 3.0}
    assert PolicyDescription.of_text(about.text()).text() == about.text()


@pytest.mark.parametrize("scaled", [True, False])
def test_actions_become_the_numbers_that_the_environment_sends(scaled):
    env = RobotEnv(urdf=CART, action="cmd_vel", scaled=scaled, limits={"cmd_vel": (-0.5, (1, 2))})
    actions = PolicyDescription.of_text(policy_description(env).text()).actions
    rng = np.random.default_rng(0)
    for action in rng.uniform(-1.5, 1.5, (20, 2)):
        [(topic, message, numbers)] = actions.command(action)
        assert (topic, message) == ("/cmd_vel", "geometry_msgs/Twist")
        assert numbers == env.actions.numbers(action).tolist()
    env.close()


def test_numbers_are_dealt_to_topics_in_their_order():
    topics = (("/a", "std_msgs/Float64", 1), ("/b", "std_msgs/Float64MultiArray", 2))
    actions = RobotActions(topics, (-9.0,) * 3, (9.0,) * 3, False)
    assert [values for _, _, values in actions.command((1.0, 2.0, 3.0))] == [[1.0], [2.0, 3.0]]


def test_a_file_of_a_robot_is_refused_for_another_one(tmp_path):
    env = RobotEnv(urdf=CART, action="cmd_vel", observation="scan")
    path = write(tmp_path / "p.onnx", np.ones((2, 24)), (9, 9), policy_description(env), (24,))
    env.close()
    with pytest.raises(GymError, match="was trained on robot; it must be of deepracer"):
        OnnxPolicy(path)
    policy = OnnxPolicy(path, "robot")
    assert (policy.act(np.ones(24, np.float32)) == 1.0).all()  # tanh, within the topic's bounds


def test_what_a_robot_cannot_observe_is_named():
    lane = {"points": [(0, 0), (1, 0), (1, 1)]}
    env = RobotEnv(urdf=CART, action="cmd_vel", task="lane", task_options=lane)
    with pytest.raises(GymError, match="a robot has nothing that gives lane of the task"):
        policy_description(env)
    env.close()
