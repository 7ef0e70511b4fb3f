"""World files as the bridge loads them: those that cannot be loaded, and what is logged."""

import logging

import pytest
from bullet_bridge.resolve import GAZEBO_WORLDS, RosPackages, load_world, log_warnings
from bullet_sim.description.model import ModelDescription
from bullet_sim.description.warnings import is_loss
from bullet_sim.formats.resolve import Resolver

from bullet_bridge import resolve

WORLD = """<sdf version="1.6"><world name="w"><physics><max_step_size>0.002</max_step_size>
<real_time_update_rate>{}</real_time_update_rate></physics>{}</world></sdf>"""


@pytest.fixture(name="logged")
def _said(monkeypatch):
    """Lists of what is logged: (warnings, errors)."""
    warnings, errors = [], []
    for name, into in (("logwarn", warnings), ("logerr", errors)):
        monkeypatch.setattr(
            resolve.rospy, name, lambda text, *values, into=into: into.append(text % values)
        )
    return warnings, errors


def test_a_relative_file(tmp_path, monkeypatch, world, logged):
    (tmp_path / "w.world").write_text(WORLD.format(1000, ""))
    monkeypatch.setenv("GAZEBO_RESOURCE_PATH", str(tmp_path))
    described = load_world(world, "w.world", Resolver(RosPackages()))
    assert world.name == "w" and described.real_time_factor == 2.0 and logged == ([], [])


def test_no_path_loads_nothing(world, logged):
    assert load_world(world, "", Resolver(RosPackages())) is None
    assert not world.models and logged == ([], [])


@pytest.mark.parametrize(
    "name, content, words",
    [
        ("gone.world", None, ["gone.world", "No such file"]),
        ("w.world", "", ["w.world", "not well-formed"]),
        ("w.world", "<sdf version='1.6'><world", ["w.world", "not well-formed", "line 1"]),
        ("w.world", "<sdf version='1.6'/>", ["w.world", "no <world>"]),
        ("w.world", "<robot name='r'/>", ["w.world", "no <world>"]),
        ("w.world", "points: [1, 2]", ["w.world", "not well-formed"]),
    ],
)
def test_a_world_that_cannot_be_had_is_the_empty_one(tmp_path, world, logged, name, content, words):
    path = tmp_path / name
    if content is not None:
        path.write_text(content)
    described = load_world(world, str(path), Resolver(RosPackages()))
    assert list(world.models) == ["ground_plane"] and described.real_time_factor == 1.0
    (error,) = logged[1]
    for word in [*words, "empty world takes its place"]:
        assert word in error
    assert described.warnings == [error] and is_loss(described.warnings[0])
    assert logged[0] == []


def test_a_relative_world_that_is_nowhere(world, logged):
    load_world(world, "worlds/none.world", Resolver(RosPackages()))
    assert list(world.models) == ["ground_plane"]
    assert len(logged[1]) == 1 and "'worlds/none.world' is in none of" in logged[1][0]


class Taker:
    """Stands in for World: keeps the names of what it is to load."""

    names = ()

    def load(self, described):
        self.names = [model.name for model, _ in described.models]
        return []


def test_gazebos_own_worlds_are_one_warning(logged):
    taker, resolve = Taker(), Resolver(RosPackages())
    for number, name in enumerate(GAZEBO_WORLDS):
        load_world(taker, f"worlds/{name}.world", resolve)
        assert taker.names == ["ground_plane"] and logged[1] == []
        assert len(logged[0]) == number + 1 and f"worlds/{name}.world" in logged[0][-1]


@pytest.mark.parametrize(
    "name, models",
    [
        ("empty", ["ground_plane"]),
        ("empty_world", ["ground_plane"]),
        ("empty_sky", ["ground_plane"]),
        ("blank", []),
        ("shapes", ["ground_plane", "box", "sphere", "cylinder"]),
    ],
)
def test_worlds_of_the_stand_in(logged, name, models):
    taker = Taker()
    load_world(taker, f"worlds/{name}.world", Resolver(RosPackages()))
    assert taker.names == models and logged == ([], [])


def test_causes_are_counted_and_details_go_to_the_file(tmp_path, world, logged, caplog):
    includes = "".join(f"<include><uri>model://gone_{n}</uri></include>" for n in range(56))
    path = tmp_path / "w.world"
    path.write_text(WORLD.format(500, includes + "<glitter/>"))
    with caplog.at_level(logging.INFO):
        load_world(world, str(path), Resolver(RosPackages()))
    assert logged[0][0] == "56 included models cannot be used: 'model://gone_0' and 55 more"
    assert len(logged[0]) == 2 and "<glitter>" in logged[0][1] and logged[1] == []
    details = [text for text in caplog.messages if "gone_" in text]
    assert len(details) == 56 and "gone_55" in details[-1]


def test_lines_about_a_model_name_it(logged):
    model = ModelDescription("car")
    model.warn("link 'a' is odd")
    model.warn("joint 'j' of 'car' is odd")
    log_warnings(model.warnings, "car")
    assert logged[0] == ["model 'car': link 'a' is odd", "joint 'j' of 'car' is odd"]
