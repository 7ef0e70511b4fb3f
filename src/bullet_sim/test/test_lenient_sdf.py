"""Bad values in SDF: each costs itself and one warning, and what is used is what Gazebo uses."""

import numpy as np
import pytest
from sdf_texts import FALLEN, MASS, fallen, model, read, weighing, world_of


def place(world):
    """Where the odd model is."""
    return next(pose for found, pose in world.models if found.name == "m").position


def link(world):
    """The odd model's link."""
    return read(world).links["a"]


def mass(world):
    """Its mass."""
    return link(world).mass


def moments(world):
    """Its moments of inertia."""
    return np.diag(link(world).inertia).tolist()


def shapes(world):
    """Sizes of its visuals."""
    return [shape.geometry.size for shape in link(world).visuals]


def looks(world):
    """Colour of its visual."""
    return link(world).visuals[0].color


def drawn(geometry, extra=""):
    """A model with a visual."""
    visual = f'<visual name="v"><geometry>{geometry}</geometry>{extra}</visual>'
    return model(link=visual)


def hinged(content, kind="revolute", parent="a", child="b"):
    """A model of two links and a joint."""
    joint = f"<parent>{parent}</parent><child>{child}</child>{content}"
    other = f'<link name="b"><pose>0 0 1 0 0 0</pose>{MASS}</link>'
    return model(f'{other}<joint name="j" type="{kind}">{joint}</joint>')


def joint(world):
    """The odd model's joint."""
    return read(world).joints["j"]


def stopped(lower, upper):
    """A model with stops."""
    limit = f"<limit><lower>{lower}</lower><upper>{upper}</upper></limit>"
    return hinged(f"<axis><xyz>0 0 1</xyz>{limit}</axis>")


def stops(world):
    """Stops of the joint."""
    return joint(world).lower, joint(world).upper


def physics(content):
    """A <physics>."""
    return f"<physics>{content}</physics>"


def step(world):
    """Physics step of the world."""
    return world.step


CUBE = "<box><size>1 1 1</size></box>"
GREY = (1.0, 1.0, 1.0, 1.0)
FRAME = '<pose relative_to="nose">1 0 0 0 0 0</pose>'

# what is wrong: text, what is read of it, what it is, words of the one warning
VALUES = {
    "five numbers": (model(pose="1 2 3 0 0"), place, (1, 2, 3), ["'1 2 3 0 0'", "1 2 3 0 0 0 is"]),
    "three numbers": (model(pose="1 2 3"), place, (1, 2, 3), ["'1 2 3'", "must be 6"]),
    "two numbers": (model(pose="1 2"), place, (0, 0, 0), ["'1 2'", "0 0 0 0 0 0 is used"]),
    "seven numbers": (model(pose="1 2 3 0 0 0 9"), place, (1, 2, 3), ["1 2 3 0 0 0 is used"]),
    "commas": (model(pose="1,2,3,0,0,0"), place, (0, 0, 0), ["'1,2,3,0,0,0'", "line 4"]),
    "a pose with NaN": (model(pose="1 nan 3 0 0 0"), place, (0, 0, 0), ["'1 nan 3 0 0 0'"]),
    "a turn with NaN": (model(pose="1 2 3 0 0 nan"), place, (1, 2, 3), ["nan"]),
    "an empty pose": (model(pose=" "), place, (0, 0, 0), []),
    "tabs and lines": (model(pose="\t1\r\n2\n\t 3 0 0 0\n"), place, (1, 2, 3), []),
    "a mass of a unit": (weighing("<mass>1.5kg</mass>"), mass, 1.5, ["'1.5kg'", "1.5 is used"]),
    "a decimal comma": (weighing("<mass>2,5</mass>"), mass, 2, ["'2,5'", "2 is used"]),
    "a mass of a word": (weighing("<mass>heavy</mass>"), mass, 1, ["<mass> is 'heavy'", "1 is"]),
    "an empty mass": (weighing("<mass/>"), mass, 1, []),
    "no mass": (weighing(""), mass, 1, []),
    "a negative mass": (weighing("<mass>-3</mass>"), mass, 1, ["-3.0", "1 is used"]),
    "an inertia of a word": (
        weighing(inertia="<inertia><ixx>x</ixx></inertia>"),
        moments,
        [0, 1, 1],
        ["'x'"],
    ),
    "no geometry": (drawn(""), shapes, [], ["has no geometry"]),
    "an unknown geometry": (drawn("<cone/>"), shapes, [], ["<cone>", "left out"]),
    "a box of a word": (drawn("<box><size>big</size></box>"), shapes, [(1, 1, 1)], ["'big'"]),
    "a flat box": (drawn("<box><size>2 3 0</size></box>"), shapes, [(2, 3, 0.001)], ["becomes"]),
    "a box of no size": (drawn("<box><size>0 0 0</size></box>"), shapes, [], ["left out"]),
    "a negative box": (drawn("<box><size>-2 3 1</size></box>"), shapes, [(2, 3, 1)], ["-2.0"]),
    "a box without size": (drawn("<box/>"), shapes, [(1, 1, 1)], []),
    "a mesh without a file": (drawn("<mesh/>"), shapes, [], ["mesh ''", "left out"]),
    "a mesh that is missing": (
        drawn("<mesh><uri>model://x/y.dae</uri></mesh>"),
        shapes,
        [],
        ["model://x/y.dae"],
    ),
    "a colour of two": (
        drawn(CUBE, "<material><diffuse>1 0</diffuse></material>"),
        looks,
        GREY,
        ["'1 0'"],
    ),
    "transparency of a word": (
        drawn(CUBE, "<transparency>half</transparency>"),
        looks,
        GREY,
        ["'half'"],
    ),
    "an axis of zero": (
        hinged("<axis><xyz>0 0 0</xyz></axis>"),
        lambda w: joint(w).axis,
        (0, 0, 1),
        ["axis is zero"],
    ),
    "an axis of two": (
        hinged("<axis><xyz>1 0</xyz></axis>"),
        lambda w: joint(w).axis,
        (0, 0, 1),
        ["'1 0'"],
    ),
    "no axis": (hinged(""), lambda w: joint(w).axis, (0, 0, 1), []),
    "stops the wrong way round": (stopped(1, -1), stops, (None, None), ["lower limit 1.0"]),
    "endless stops": (stopped("-inf", "1e16"), stops, (None, None), []),
    "a stop of a word": (stopped("-1", "far"), stops, (-1, 1e9), ["'far'"]),
    "an unknown joint": (
        hinged("", "glue"),
        lambda w: joint(w).kind,
        "fixed",
        ["'glue'", "fixed, revolute, prismatic"],
    ),
    "a gearbox without its reference body": (
        hinged("", "gearbox"),
        lambda w: list(read(w).joints),
        [],
        ["reference body ''"],
    ),
    "a joint in capitals": (hinged("", "Fixed"), lambda w: joint(w).kind, "fixed", ["'Fixed'"]),
    "no such frame": (
        f'<model name="m"><link name="a">{FRAME}{MASS}</link></model>',
        lambda w: read(w).root_pose.position,
        (1, 0, 0),
        ["no frame 'nose'", "frames are a"],
    ),
    "a word for true": (model("<static>yes please</static>"), lambda w: read(w).static, False, []),
    "true in capitals": (model("<static>TRUE</static>"), lambda w: read(w).static, True, []),
    "true as a number": (model("<static> 1 </static>"), lambda w: read(w).static, True, []),
    "no time step": (physics("<max_step_size>0</max_step_size>"), step, 0.001, ["is 0.0", "1e-06"]),
    "a negative step": (physics("<max_step_size>-1</max_step_size>"), step, 0.001, ["-1.0"]),
    "a step of NaN": (physics("<max_step_size>nan</max_step_size>"), step, 0.001, ["'nan'"]),
    "a step of a day": (physics("<max_step_size>86400</max_step_size>"), step, 0.001, ["86400"]),
    "gravity of two": ("<gravity>0 0</gravity>", lambda w: w.gravity, (0, 0, -9.8), ["'0 0'"]),
    "a rate below 0": (
        physics("<real_time_update_rate>-1</real_time_update_rate>"),
        lambda w: w.real_time_factor,
        0,
        [],
    ),
}


@pytest.mark.parametrize("text, get, expected, words", VALUES.values(), ids=VALUES)
def test_a_bad_value_costs_itself(text, get, expected, words):
    world = world_of(text)
    assert get(world) == expected
    assert len(world.warnings) == (1 if words else 0), world.warnings
    for word in words:
        assert word in world.warnings[0]
    assert [found.name for found, _ in world.models][:2] == ["ground_plane", "sound"]


def test_what_is_left_runs():
    """All of it in one world; the models touch nothing and fall side by side."""
    assert fallen("".join(row[0] for row in VALUES.values())) == pytest.approx(FALLEN, abs=0.01)


@pytest.mark.parametrize("size", ["1 1 0", "0 0 1", "0 0 0"])
def test_a_collision_of_size_0_touches_nothing_unless_it_is_static(size):
    """As ODE's shapes of size 0, dropped in Gazebo on a plane, and a ball dropped on them."""
    shape = f'<collision name="c"><geometry><box><size>{size}</size></box></geometry></collision>'
    for static in (0, 1):
        found = read(world_of(model(f"<static>{static}</static>", link=shape)))
        kept = [shape.geometry.size for shape in found.links["a"].collisions]
        flat = tuple(float(value) or 1e-3 for value in size.split())
        assert kept == ([flat] if static and any(map(float, size.split())) else [])
