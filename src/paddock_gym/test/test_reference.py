"""docs/environments.md against the environments: spaces, names, bounds, ends."""

import inspect
import re
from pathlib import Path

import gymnasium
import numpy as np
import pytest
from paddock_gym.contract.actions import Continuous
from paddock_gym.envs import backing
from paddock_gym.envs.robot import RobotEnv
from paddock_gym.envs.tasks import TASKS
from paddock_gym.simulation.randomize import VARIABLE

import paddock_gym
from paddock_gym import course, observations

PAGE = Path(__file__).resolve().parents[3] / "docs" / "environments.md"
if not PAGE.is_file():
    pytest.skip("the documents are not installed", allow_module_level=True)
TEXT = PAGE.read_text(encoding="utf-8")
ROBOT, CAR, TRUCK = re.split(r"^## Paddock/", TEXT, flags=re.MULTILINE)[1:4]


def tables(text):
    """Rows of each table, a list of cells; the heads are first."""
    runs, rows = [], []
    for line in [*text.splitlines(), ""]:
        if line.startswith("|"):
            cells = [cell.strip() for cell in line.strip("|").split("|")]
            if not set("".join(cells)) <= set("- "):
                rows.append(cells)
        elif rows:
            runs.append(rows)
            rows = []
    return runs


def table(text, *head):
    """Rows below a table's head."""
    return next(rows[1:] for rows in tables(text) if tuple(rows[0]) == head)


def numbers(cell):
    """Numbers of a cell."""
    return [float(number) for number in re.findall(r"-?\d+(?:\.\d+)?", cell)]


@pytest.fixture(scope="module")
def truck():
    made = gymnasium.make(paddock_gym.IDS[1]).unwrapped
    yield made
    made.close()


def test_the_ids_are_those_that_are_registered():
    assert re.findall(r"^## (Paddock/\S+)", TEXT, re.MULTILINE) == [
        paddock_gym.ROBOT,
        *paddock_gym.IDS,
    ]


@pytest.mark.parametrize("options", [{"observation": "lidar"}, {"observation": "camera"}, {}])
def test_the_spaces_of_the_car(options):
    env = gymnasium.make(paddock_gym.IDS[0], **options).unwrapped
    assert f"`{env.action_space}`" in CAR
    assert f"`{options.get('observation', 'state')}`: `{env.observation_space}`" in CAR
    env.close()


def test_state_and_actions_of_the_car(env):
    rows = table(CAR, "index", "name", "min", "max")
    assert [int(row[0]) for row in rows] == list(range(env.observation_space.shape[0]))
    assert [row[1] for row in rows] == list(observations.NAMES)
    low, high = np.array([[float(cell) for cell in row[2:]] for row in rows]).T
    space = env.observation_space
    assert (low >= space.low).all() and (high <= space.high).all()
    rng = np.random.default_rng(0)
    for seed in range(4):
        observation, _ = env.reset(seed=seed)
        for _ in range(20):
            assert (observation >= low - 1e-6).all() and (observation <= high + 1e-6).all()
            observation, *_ = env.step(rng.uniform(-1.0, 1.0, 2))
    steering, speed = table(CAR, "index", "name", "min", "max", "unit")
    for row, (least, most) in ((steering, Continuous().steering), (speed, Continuous().speed)):
        assert numbers(row[2]) == [-1.0, least] and numbers(row[3]) == [1.0, most]


def test_objects_follow_the_state():
    env = gymnasium.make(paddock_gym.IDS[0], race="object_avoidance").unwrapped
    more = [
        int(number)
        for rows in tables(CAR)
        for row in rows
        if "with objects" in row[1]
        for number in row[0].split(", ")
    ]
    assert sorted(more) == list(range(14, env.observation_space.shape[0]))
    env.close()


def test_ranges_and_images():
    rows = table(CAR, "name", "index", "value", "min", "max")
    assert rows[0][1] == f"0 to {observations.RAYS - 1}" and rows[0][3:] == ["0", "1"]
    assert numbers(rows[1][1]) == [0, observations.HEIGHT - 1, 0, observations.WIDTH - 1, 0]


def test_ends_of_the_car():
    rows = table(CAR, '`info["end"]`', "")
    named = re.findall(r"`(\w+)`", " ".join(row[0] for row in rows))
    known = course.OFF_TRACK, course.CRASHED, course.STUCK, course.REVERSED, course.LAP
    assert named == list(known)
    assert [row[1].partition(":")[0] for row in rows] == ["terminated", "truncated"]


def test_spaces_and_ends_of_the_truck(truck):
    assert f"`{truck.action_space}`" in TRUCK and f"`{truck.observation_space}`" in TRUCK
    rows = table(TRUCK, "index", "name", "min", "max")
    assert [int(row[0]) for row in rows] == list(range(truck.observation_space.shape[0]))
    low, high = np.array([[float(cell) for cell in row[2:]] for row in rows]).T
    rng = np.random.default_rng(0)
    for seed in range(3):
        observation, _ = truck.reset(seed=seed)
        for _ in range(10):
            assert (observation >= low - 1e-6).all() and (observation <= high + 1e-6).all()
            observation, *_ = truck.step(rng.uniform(-1.0, 1.0, 2))
    ahead = [float(row[1].split()[1]) for row in rows if row[1].startswith("curvature")]
    assert ahead == backing.LOOKAHEADS.tolist()
    speed = table(TRUCK, "index", "action", "min", "max", "unit")[1]
    assert numbers(speed[3]) == [1.0, backing.TOP_SPEED]
    assert numbers(TRUCK.partition("| one action |")[2])[0] == pytest.approx(truck.period)
    named = re.findall(r"`(\w+)`", " ".join(r[0] for r in table(TRUCK, '`info["end"]`', "")))
    assert named == [backing.ARRIVED, backing.JACKKNIFED, backing.OFF_PATH]


def test_the_options_of_any_robot():
    named = set()
    for row in table(ROBOT, "argument", "default", ""):
        named |= set(re.findall(r"`(\w+)`", row[0]))
    assert named == set(inspect.signature(RobotEnv).parameters)
    (tasks_row,) = (row for row in table(ROBOT, "argument", "default", "") if "`task`" in row[0])
    assert set(TASKS) <= set(re.findall(r"`\"?(\w+)\"?`", " ".join(tasks_row)))
    (vary_row,) = (row for row in table(ROBOT, "argument", "default", "") if row[0] == "`vary`")
    assert set(VARIABLE) <= set(re.findall(r"`(\w+)`", vary_row[2]))
