"""<population>: where its models are, and what they are called."""

import math

import numpy as np
import pytest
from bullet_sim.errors import ModelError
from bullet_sim.formats.sdf import population
from bullet_sim.formats.sdf.world import parse_world

BOX = "<box><size>4 2 1</size></box>"
CYLINDER = "<cylinder><radius>3</radius><length>2</length></cylinder>"
MODEL = '<model name="stone"><pose>9 9 9 1 1 1</pose><static>1</static><link name="l"/></model>'


def world_of(text, pose="<pose>10 20 0.5 0 0 0</pose>", name="p"):
    population = f'<population name="{name}">{MODEL}{pose}{text}</population>'
    last = '<model name="last"><link name="l"/></model>'
    return parse_world(f'<sdf version="1.6"><world name="w">{population}{last}</world></sdf>', str)


def spots(text, **options):
    """Positions (n, 3) of the clones, which must be all models but the last of the file."""
    world = world_of(text, **options)
    assert world.warnings == []
    names = [model.name for model, _ in world.models]
    assert names == ["last", *(f"stone_clone_{i}" for i in range(len(names) - 1))]
    poses = [pose for _, pose in world.models[1:]]
    assert all(pose.orientation == (0, 0, 0, 1) for pose in poses), "positions alone are given"
    return np.array([pose.position for pose in poses])


def kind(name, count=None):
    tag = "" if count is None else f"<model_count>{count}</model_count>"
    return f"{tag}<distribution><type>{name}</type></distribution>"


@pytest.mark.parametrize(
    "rows, cols, first",
    [(2, 3, (9.0, 19.5, 0.5)), (3, 2, (9.5, 19.0, 0.5)), (1, 1, (10.0, 20.0, 0.5))],
)
def test_a_grid_goes_row_by_row_about_its_pose(rows, cols, first):
    text = (
        f"<distribution><type>grid</type><rows>{rows}</rows><cols>{cols}</cols><step>1 1 7</step>"
        "</distribution>"
    )
    found = spots(text)
    expected = [(first[0] + j, first[1] + i, first[2]) for i in range(rows) for j in range(cols)]
    np.testing.assert_allclose(found, expected, atol=1e-12)


@pytest.mark.parametrize("axis, name", list(enumerate(("linear-x", "linear-y", "linear-z"))))
def test_a_line_along_an_axis_begins_at_the_side_of_the_box(axis, name):
    found = spots(BOX + kind(name, 4))
    expected = np.tile((10.0, 20.0, 0.5), (4, 1))
    size = (4.0, 2.0, 1.0)[axis]
    expected[:, axis] += np.arange(4) * size / 4 - size / 2
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_a_turned_pose_turns_offsets_but_not_the_corner_as_in_gazebo():
    found = spots(BOX + kind("linear-x", 2), pose=f"<pose>0 0 0 0 0 {math.pi / 2}</pose>")
    # from the corner (-2, -1, -0.5): offsets (0, 1, 0.5) and (2, 1, 0.5) turned to the left
    np.testing.assert_allclose(found, [(-3, -1, 0), (-3, 1, 0)], atol=1e-12)


@pytest.mark.parametrize("name", ["random", "uniform"])
def test_places_in_a_box(name):
    found = spots(BOX + kind(name, 40)) - (10, 20, 0.5)
    assert (np.abs(found) <= (2, 1, 0.5)).all() and len(np.unique(found, axis=0)) == 40
    assert (found == spots(BOX + kind(name, 40)) - (10, 20, 0.5)).all(), "at each start the same"
    assert not (found == spots(BOX + kind(name, 40), name="q") - (10, 20, 0.5)).all()
    gaps = np.linalg.norm(found[:, None] - found[None], axis=-1) + np.diag(np.full(40, np.inf))
    assert (gaps.min() > 0.25) == (name == "uniform"), "of 8 m^3 each has 0.2 for itself"


@pytest.mark.parametrize("name", ["random", "uniform"])
def test_places_in_a_cylinder_are_above_its_pose(name):
    found = spots(CYLINDER + kind(name, 30)) - (10, 20, 0.5)
    assert (np.hypot(found[:, 0], found[:, 1]) <= 3).all()
    assert (found[:, 2] >= 0).all() and (found[:, 2] <= 2).all() and len(found) == 30


def test_without_a_count_and_a_type_there_is_one_anywhere():
    assert len(spots(BOX + "<distribution/>")) == 1


@pytest.mark.parametrize(
    "text, pose, word",
    [
        (BOX + kind("spiral", 2), None, "'spiral'"),
        (kind("random", 2), None, "no <box> and no <cylinder>"),
        (BOX + kind("random", 0), None, "<model_count> is 0"),
        (BOX + kind("random", -3), None, "<model_count> is -3"),
        (BOX + kind("random", "many"), None, "<model_count> is many"),
        (BOX.replace("2", "0") + kind("random", 2), None, "must be above 0"),
        (CYLINDER.replace("3", "0") + kind("random", 2), None, "<cylinder/radius> is 0"),
        (CYLINDER + kind("linear-x", 2), None, "in a <cylinder>"),
        (kind("grid"), None, "no <rows>"),
        (BOX + kind("random", 2), "", "no <pose>"),
    ],
)
def test_a_faulty_one_is_left_out_by_name(text, pose, word):
    world = world_of(text) if pose is None else world_of(text, pose=pose)
    assert [model.name for model, _ in world.models] == ["last"]
    (warning,) = world.warnings
    assert word in warning and "population 'p'" in warning


def test_models_may_come_from_a_file(tmp_path):
    (tmp_path / "s.sdf").write_text(f'<sdf version="1.6">{MODEL}</sdf>')
    text = (
        '<sdf version="1.6"><world name="w"><population name="p"><include><uri>s</uri></include>'
        f"<pose>1 0 0 0 0 0</pose>{BOX}{kind('linear-y', 2)}</population></world></sdf>"
    )
    world = parse_world(text, lambda _: str(tmp_path / "s.sdf"))
    assert [model.name for model, _ in world.models] == ["stone_clone_0", "stone_clone_1"]


def test_a_region_takes_as_many_as_it_has_places_and_no_more():
    places, rng = np.arange(12.0).reshape(4, 3), np.random.default_rng(0)
    found = population._even(places, 4, "population 'p'", rng)
    assert sorted(found.tolist()) == places.tolist()
    with pytest.raises(ModelError, match="has 5 models, its region holds at most 4"):
        population._even(places, 5, "population 'p'", rng)
