"""Long chains of links, and files with many mistakes: time that grows with their length alone."""

import time

import pytest
from bullet_sim.description.warnings import LONGEST
from bullet_sim.formats.sdf.world import parse_model, parse_world
from bullet_sim.pose import Pose
from bullet_sim.world import World
from urdf_texts import inertial

LIMIT = 20.0  # [s] of a loaded machine; 3,000 fixed links took 80, 400 hinges 50
INERTIAL = inertial(0.01, 1e-5)


def chain(count: int, kind: str, last: str = "") -> str:
    links = "".join(f'<link name="l{n}">{INERTIAL}</link>' for n in range(count))
    joints = "".join(
        f'<joint name="j{n}" type="{kind}"><parent link="l{n}"/><child link="l{n + 1}"/>'
        f'<origin xyz="0 0 0.01"/><axis xyz="1 0 0"/>{last if n == count - 2 else ""}</joint>'
        for n in range(count - 1)
    )
    return f'<robot name="c">{links}{joints}</robot>'


@pytest.mark.parametrize(
    ("text", "bodies"),
    [
        (chain(800, "continuous"), 800),
        (chain(300, "continuous", '<mimic joint="j1"/>'), 300),
        (chain(3000, "fixed"), 1),
    ],
    ids=["hinges", "mimic", "fixed"],
)
def test_a_long_chain_is_spawned_in_seconds(text, bodies):
    world, begin = World(), time.monotonic()
    model = world.spawn_urdf("c", text, Pose(), str)
    assert len(model.bodies) == bodies
    assert time.monotonic() - begin < LIMIT
    world.close()


def test_a_long_chain_of_an_sdf_is_read_in_seconds():
    links = "".join(f'<link name="l{n}"/>' for n in range(3000))
    joints = "".join(
        f'<joint name="j{n}" type="fixed"><parent>l{n}</parent><child>l{n + 1}</child></joint>'
        for n in range(2999)
    )
    begin = time.monotonic()
    model, _ = parse_model(
        f'<sdf version="1.6"><model name="m">{links}{joints}</model></sdf>', str, "m"
    )
    assert len(model.joints) == 2999 and not model.loose
    assert time.monotonic() - begin < LIMIT


def posed(count: int, last: str) -> str:
    """A world of links, each posed relative to the next."""
    links = "".join(
        f'<link name="l{n}"><pose relative_to="{f"l{n + 1}" if n < count - 1 else last}">1 0 0 0 0 '
        "0</pose></link>"
        for n in range(count)
    )
    return f'<sdf version="1.6"><world name="w"><model name="m">{links}</model></world></sdf>'


def test_links_are_posed_relative_to_each_other_however_many():
    world = parse_world(posed(5000, ""), str, "rope.world")
    ((model, _),) = world.models
    assert model.root_pose.position[0] == 5000.0
    assert not world.warnings


def test_a_long_circle_of_poses_is_one_short_warning():
    (warning,) = parse_world(posed(5000, "l0"), str, "ring.world").warnings
    assert "frames of model 'm' are relative to each other in a circle: l0, l1" in warning
    assert warning.endswith("the model's frame is used") and len(warning) <= LONGEST


def test_many_mistakes_make_no_long_log():
    links = "".join(
        f'<link name="{"x" * 60}{n}"><pose relative_to="nowhere{n}"/></link>' for n in range(2500)
    )
    text = f'<sdf version="1.6"><world name="w"><model name="m">{links}</model></world></sdf>'
    begin = time.monotonic()
    warnings = parse_world(text, str, "warnings.world").warnings
    assert len(warnings) == 2500 and max(map(len, warnings)) <= LONGEST
    assert "has no frame 'nowhere7'; frames are xxx" in warnings[7]
    assert time.monotonic() - begin < LIMIT
