"""Parameters of controllers, by controller_parameters.yaml: their defaults and what is read."""

import copy
import dataclasses
import pathlib

import pytest
import yaml
from bullet_sim.controllers.base import configure
from bullet_sim.formats.urdf import parse_urdf
from fake_joints import COVARIANCES
from urdf_texts import joint, link

pytestmark = pytest.mark.usefixtures("sketches")

TABLE = yaml.safe_load(
    pathlib.Path(__file__).with_name("controller_parameters.yaml").read_text(encoding="utf-8")
)


def part(name, x, y, axis="0 1 0"):
    """A wheel of 0.1 m, or what steers one, on a joint of its name."""
    turning = joint(f"{name}_joint", "continuous", "base", name, f"{x} {y} 0", axis)
    return link(name, 1, 1, '<cylinder radius="0.1" length="0.05"/>') + turning


ROBOT = parse_urdf(
    '<robot name="r"><link name="base"/>'
    + part("left", 0, 0.2)
    + part("right", 0, -0.2)
    + part("rear_wheel", -0.3, 0)
    + part("front_steer", 0.3, 0, "0 0 1")
    + part("spare", 0.5, 0.3)
    + "".join(
        part(f"{end}{side}", x, y) + part(f"{end}{side}_steer", x, y, "0 0 1")
        for end, x in (("f", 0.3), ("r", -0.3))
        for side, y in (("l", 0.2), ("r", -0.2))
    )
    + "</robot>",
    str,
    "r",
    "keep",
)
PID = {"p": 1.0}
ONE, LIST = {"joint": "left_joint"}, {"joints": ["left_joint"]}
NEEDED = {  # of a controller's type
    "diff_drive_controller/DiffDriveController": {
        "left_wheel": "left_joint",
        "right_wheel": "right_joint",
        **COVARIANCES,
    },
    "ackermann_steering_controller/AckermannSteeringController": {
        "rear_wheel": "rear_wheel_joint",
        "front_steer": "front_steer_joint",
        **COVARIANCES,
    },
    "four_wheel_steering_controller/FourWheelSteeringController": {
        "front_wheel": ["fl_joint", "fr_joint"],
        "rear_wheel": ["rl_joint", "rr_joint"],
        "front_steering": ["fl_steer_joint", "fr_steer_joint"],
        "rear_steering": ["rl_steer_joint", "rr_steer_joint"],
        **COVARIANCES,
    },
    "joint_state_controller/JointStateController": {"publish_rate": 50},
    "position_controllers/JointTrajectoryController": LIST,
    "effort_controllers/JointTrajectoryController": {**LIST, "gains": {"left_joint": PID}},
    "effort_controllers/JointPositionController": {**ONE, "pid": PID},
    "effort_controllers/JointVelocityController": {**ONE, "pid": PID},
    "velocity_controllers/JointPositionController": {**ONE, "pid": PID},
    "effort_controllers/JointGroupPositionController": {**LIST, "left_joint": {"pid": PID}},
    "effort_controllers/JointGroupEffortController": LIST,
    "position_controllers/JointGroupPositionController": LIST,
    "velocity_controllers/JointGroupVelocityController": LIST,
}


def with_key(values, path, value):
    """A copy of nested mappings with a value at a path of keys, "a/b"."""
    copied = copy.deepcopy(values)
    at, (*outer, last) = copied, path.split("/")
    for key in outer:
        at = at.setdefault(key, {})
    at[last] = value
    return copied


def flat(found, name=""):
    """All attributes of a configuration and of what is in it, by their paths, as YAML has them."""
    if dataclasses.is_dataclass(found):
        parts = {each.name: getattr(found, each.name) for each in dataclasses.fields(found)}
        of = f"{name}.{{}}".lstrip(".")
    elif isinstance(found, (tuple, list)) and found and dataclasses.is_dataclass(found[0]):
        parts, of = dict(enumerate(found)), f"{name}[{{}}]"
    elif isinstance(found, dict):
        parts, of = found, f"{name}[{{}}]"
    elif hasattr(found, "__dict__") and not callable(found):
        parts, of = vars(found), f"{name}.{{}}"
    else:
        return {name: plain(found)}
    return {
        inner: value
        for key, item in parts.items()
        for inner, value in flat(item, of.format(key)).items()
    }


def plain(found):
    return [plain(item) for item in found] if isinstance(found, (tuple, list)) else found


@pytest.mark.parametrize("kind, key", [(kind, key) for kind, keys in TABLE.items() for key in keys])
def test_a_parameter_and_its_default(kind, key):
    given, besides, attribute, default, wanted = TABLE[kind][key]
    values = {**NEEDED.get(kind, ONE), "type": kind}
    for path, value in besides.items():
        values = with_key(values, path, value)
    for config, expected in ((values, default), (with_key(values, key, given), wanted)):
        found = flat(configure("c", config, tuple(ROBOT.joints), ROBOT)[1]).get(attribute)
        if isinstance(expected, float):
            expected = pytest.approx(expected)
        elif isinstance(expected, list) and all(isinstance(item, float) for item in expected):
            expected = pytest.approx(expected)
        assert found == expected
