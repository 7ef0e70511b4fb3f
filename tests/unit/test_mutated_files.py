"""Files of the project changed at random: read, or refused in a sentence; no crash, soon.

`MUTATIONS=500 ./run exec python -m pytest tests/unit/test_mutated_files.py` tries more of them.
"""

import contextlib
import os
import pathlib
import subprocess
import sys

import mutations
import pytest
from bullet_bridge.resolve import RosPackages
from bullet_sim.errors import SimError
from bullet_sim.formats.resolve import Resolver
from bullet_sim.formats.sdf.world import parse_world
from bullet_sim.pose import Pose
from bullet_sim.world import World
from cybertruck.trailer.geometry import TrailerError
from cybertruck.trailer.steering import read_map
from mutation_rig import problems
from paddock_gym.errors import GymError
from paddock_gym.sweep import spec as sweep
from track_model.files import writer
from track_model.spec import TrackError

from paddock_common import yaml_file
from track_model import geometry, source

pytestmark = pytest.mark.isolated  # mutation_rig forks

ROOT = pathlib.Path(__file__).resolve().parents[2]
COUNT = int(os.environ.get("MUTATIONS", "40"))  # of the files of a kind
SEED = os.environ.get("MUTATION_SEED", "1")
STEPS = 3  # of the physics
XACRO = ROOT / "src" / "standins" / "xacro" / "xacro"
SWEEP = b"""of: pursuit
search: tpe
trials: 4
fixed: {track: easy}
over:
  speed: {low: 0.5, high: 2.0}
  lookahead: [0.4, 0.8]
"""


@pytest.fixture(scope="module", name="resolve")
def _resolve():
    return Resolver(RosPackages())


@pytest.fixture(scope="module", name="robots")
def _robots():
    """Robots' URDF by name."""
    found = {path.stem: path.read_bytes() for path in (ROOT / "tests" / "ros").glob("*_bot.urdf")}
    for path in ("track_model/urdf/racecar", "cybertruck/urdf/cybertruck"):
        command = [sys.executable, str(XACRO), str(ROOT / "src" / f"{path}.urdf.xacro")]
        found[path.split("/")[-1]] = subprocess.run(command, check=True, stdout=-1).stdout
    return found


def changed(files, change):
    """Changed copies of the files of a kind, name -> bytes, with a name for each."""
    count = max(1, COUNT // len(files))
    return [
        (f"{name} #{number}", content)
        for name, data in files.items()
        for number, content in mutations.mutations(data, change, count, f"{SEED}/{name}")
    ]


def named(*patterns):
    """Files of the repository: path -> bytes."""
    paths = sorted(path for pattern in patterns for path in ROOT.glob(pattern))
    assert paths
    return {str(path.relative_to(ROOT)): path.read_bytes() for path in paths}


def simulated(load):
    """A function of a content that loads it into a world and makes some steps."""

    def run(content):
        world = World()
        try:
            load(world, content)
            world.step(STEPS)
            world.reset()
            world.step(STEPS)
        finally:
            world.close()

    return run


def test_urdf(robots, resolve):
    def spawn(world, content):
        model = world.spawn_urdf("m", content, Pose(), resolve)
        assert all(isinstance(warning, str) for warning in model.description.warnings)

    items = changed(robots, mutations.xml_changed)
    assert problems(items, simulated(spawn), SimError) == []


def test_sdf_models(resolve):
    def spawn(world, content):
        world.spawn_sdf("m", content, Pose(), resolve)

    items = changed(named("tests/**/*.sdf"), mutations.xml_changed)
    assert problems(items, simulated(spawn), SimError) == []


def test_worlds(resolve):
    def load(world, content):
        world.load(parse_world(content, resolve, "m.world"))

    items = changed(named("src/**/*.world", "tests/**/*.world"), mutations.xml_changed)
    assert problems(items, simulated(load), SimError) == []


CONTROLLERS = {
    "src/track_model/config/agent_control.yaml": "racecar",
    "src/cybertruck/config/controllers.yaml": "cybertruck",
    "tests/ros/actions.yaml": "arm_bot",
    "tests/ros/diff_drive.yaml": "diff_bot",
    "tests/ros/effort_controllers.yaml": "effort_bot",
    "tests/ros/lidar_bot_control.yaml": "lidar_bot",
}


def configurations(value, name=""):
    """Pairs (name, configuration) of the controllers in what a YAML file holds."""
    if isinstance(value, dict):
        if "type" in value:
            yield str(name), value
        for key, inner in value.items():
            yield from configurations(inner, key)


@pytest.mark.parametrize("path", CONTROLLERS)
def test_controllers(path, robots, resolve):
    def load(world, content):
        manager = world.spawn_urdf("m", robots[CONTROLLERS[path]], Pose(), resolve).manager
        loaded, value = [], held(content, path)
        for name, config in configurations(value):
            try:
                manager.load(name, config)
                loaded.append(name)
            except SimError as error:
                assert name in str(error) and len(str(error)) < 5000
        for name in loaded:
            with contextlib.suppress(SimError):  # its joints are claimed by another
                manager.switch([name], [])
        world.step(30)

    items = changed(named(path), mutations.yaml_changed)[:: len(CONTROLLERS)]
    assert problems(items, simulated(load), SimError) == []


def held(content, path):
    """What a YAML text holds; None where it is no YAML."""
    try:
        return yaml_file.parse(content, path)
    except ValueError as error:
        assert path in str(error)
        return None


def test_tracks(tmp_path):
    def load(content):
        spec = source.load("t.yaml", content)
        geometry.lane(spec)
        writer.write(spec, str(tmp_path), str(tmp_path))

    items = changed(named("src/track_model/tracks/*.yaml"), mutations.yaml_changed)
    assert problems(items, load, TrackError) == []


def test_a_steering_map(tmp_path):
    path = tmp_path / "map.yaml"

    def load(content):
        path.write_bytes(content)
        read_map(path)

    items = changed(named("src/cybertruck/config/steering_map.yaml"), mutations.yaml_changed)
    assert problems(items, load, TrailerError) == []


def test_a_sweep(tmp_path):
    path = tmp_path / "sweep.yaml"

    def load(content):
        path.write_bytes(content)
        sweep.load(str(path))

    items = changed({"sweep.yaml": SWEEP}, mutations.yaml_changed)
    assert problems(items, load, GymError) == []
