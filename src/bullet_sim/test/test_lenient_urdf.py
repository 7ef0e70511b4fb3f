"""URDFs with bad values: each costs its own element and one warning, and the rest is as it was.

Where urdfdom 1.0 refuses all of a robot it comes up nevertheless; of a link it reads what is before
the first fault, which gz sdf -p of Gazebo 11.1 prints.
"""

import math

import numpy as np
import pytest
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.pose import Pose
from bullet_sim.world import World

MASS = (
    '<inertial><mass value="1"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/>'
    "</inertial>"
)
INERTIA = MASS[len("<inertial>") : -len("</inertial>")]
INERTIA = INERTIA.replace('mass value="1"', 'mass value="{}"').replace('ixy="0"', 'ixy="{}"')
SOUND = (
    f'<link name="base">{MASS}<collision><geometry><box size="1 1 0.2"/></geometry></collision>'
    f'</link><link name="wheel">{MASS}</link><joint name="axle" type="continuous">'
    '<parent link="base"/><child link="wheel"/><origin xyz="0 1 0"/><axis xyz="0 1 0"/></joint>'
)


def robot(content):
    """A URDF of the sound parts and others, one line each."""
    return f'<robot name="r">\n{SOUND}\n{content}\n</robot>'


def arm(content="", inertial=MASS, attributes='type="revolute"', limit=True):
    """A link on a joint of its own."""
    stops = '<limit lower="-1" upper="2" effort="3" velocity="4"/>' if limit else ""
    return (
        f'<link name="arm">{inertial}</link><joint name="j" {attributes}><parent link="base"/>'
        f'<child link="arm"/>{stops}{content}</joint>'
    )


def inertial(mass='value="2"', inertia='ixx="1" iyy="2" izz="2.5"', origin=""):
    """An arm with an <inertial>."""
    return arm(inertial=f"<inertial>{origin}<mass {mass}/><inertia {inertia}/></inertial>")


def shape(geometry, tag="visual", extra=""):
    """A link with one shape on a fixed joint."""
    return (
        f'<link name="arm">{MASS}<{tag}>{extra}<geometry>{geometry}</geometry></{tag}></link>'
        '<joint name="j" type="fixed"><parent link="base"/><child link="arm"/></joint>'
    )


def joint(model):
    """The joint of the arm."""
    return model.joints["j"]


def link(model):
    """The link of the arm."""
    return model.links["arm"]


def visual_sizes(model):
    """Sizes of the arm's visuals."""
    return [shape.geometry.size for shape in link(model).visuals]


def mass(model):
    """The arm's mass."""
    return link(model).mass


def moments(model):
    """The arm's moments of inertia."""
    return np.diag(link(model).inertia).tolist()


def color(model):
    """Colour of the arm's visual."""
    return link(model).visuals[0].color


def place(model):
    """Where the arm's joint is."""
    return joint(model).origin.position


def axis(model):
    """Axis of the arm's joint."""
    return joint(model).axis


def stops(model):
    """Stops of the arm's joint."""
    return joint(model).lower, joint(model).upper


def limits(model):
    """Effort and velocity of the arm's joint."""
    return joint(model).effort, joint(model).velocity


def limited(text):
    """An arm with a <limit>."""
    return arm(f"<limit {text}/>", limit=False)


def at(text):
    """An arm at a place."""
    return arm(f'<origin xyz="{text}"/>')


def painted(text):
    """An arm with a coloured box."""
    material = f'<material name="m"><color rgba="{text}"/></material>'
    return shape('<box size="1 1 1"/>', extra=material)


ODD_INERTIA = inertial(inertia='ixx="nan" iyy="2" izz="2.5"')
ODD_ORIGIN = inertial(origin='<origin xyz="0 nan 0"/>')
ODD_WORDS = ["link 'arm' inertial origin xyz", "'0 nan 0'"]
UNIT_WORDS = ["joint 'j'", "origin xyz", "'1m 0 0'", "3 finite", "0 0 0 is used", "line 3"]

# what is wrong: text, what is read of it, what it is, words of the one warning
VALUES = {
    "a unit": (at("1m 0 0"), place, (0, 0, 0), UNIT_WORDS),
    "commas": (at("1,2,3"), place, (0, 0, 0), ["'1,2,3'"]),
    "a decimal comma": (inertial('value="1,5"'), mass, 1, ["'1,5'", "1 is used"]),
    "a unit behind": (inertial('value="1.5kg"'), mass, 1.5, ["'1.5kg'", "1.5 is used"]),
    "a word": (inertial('value="heavy"'), mass, 0, ["'heavy'", "0 is used"]),
    "no value": (inertial('value=""'), mass, 0, ["mass value is ''"]),
    "a mass that is NaN": (inertial('value="nan"'), mass, 0, ["'nan'"]),
    "an endless mass": (inertial('value="inf"'), mass, 0, ["'inf'"]),
    "a mass out of range": (inertial('value="1e999"'), mass, 0, ["'1e999'"]),
    "a negative mass": (inertial('value="-1"'), mass, 0, ["-1.0", "0 or more"]),
    "left by xacro": (inertial('value="${m}"'), mass, 0, ["'${m}'", "process the file"]),
    "an inertia that is NaN": (ODD_INERTIA, moments, [0, 2, 2.5], ["ixx is 'nan'"]),
    "an origin with NaN": (ODD_ORIGIN, lambda m: link(m).center.tolist(), [0, 0, 0], ODD_WORDS),
    "two numbers": (arm('<axis xyz="0 1"/>'), axis, (1, 0, 0), ["'0 1'"]),
    "four numbers": (arm('<axis xyz="0 1 0 5"/>'), axis, (0, 1, 0), ["'0 1 0 5'"]),
    "an axis of zero": (arm('<axis xyz="0 0 0"/>'), axis, (1, 0, 0), ["is zero", "1 0 0 is used"]),
    "stops the wrong way round": (
        limited('lower="2" upper="-1" effort="1" velocity="1"'),
        stops,
        (-1, 2),
        ["lower limit 2.0", "upper -1.0", "exchanged"],
    ),
    "a stop that is no number": (
        limited('lower="left" upper="1" effort="1" velocity="1"'),
        stops,
        (-1e9, 1),
        ["'left'", "nothing is used"],
    ),
    "no limit": (arm(limit=False), stops, (None, None), ["has no <limit>"]),
    "no effort": (limited('lower="-1" upper="1" velocity="5"'), limits, (0, 5), ["no effort"]),
    "no velocity": (limited('lower="-1" upper="1" effort="5"'), limits, (5, 0), ["no velocity"]),
    "an unknown type": (
        arm(attributes='type="hinge"'),
        lambda m: joint(m).kind,
        "fixed",
        ["'hinge'", "revolute, continuous, prismatic, fixed", "fixed is used"],
    ),
    "a type in capitals": (
        arm(attributes='type="Revolute"'),
        lambda m: (joint(m).kind, joint(m).upper),
        ("revolute", 2),
        ["'Revolute'", "revolute is used"],
    ),
    "no type": (arm(attributes=""), lambda m: joint(m).kind, "fixed", ["type 'None'"]),
    "damping in words": (
        arm('<dynamics damping="some" friction="0.2"/>'),
        lambda m: (joint(m).damping, joint(m).friction),
        (0, 0.2),
        ["'some'"],
    ),
    "a box of two sides": (shape('<box size="1 2"/>'), visual_sizes, [], ["'1 2'", "3 finite"]),
    "a box without size": (shape("<box/>"), visual_sizes, [], ["box without size", "left out"]),
    "a flat box": (shape('<box size="1 2 0"/>'), visual_sizes, [(1, 2, 0.001)], ["it becomes"]),
    "a flat box that touches": (
        shape('<box size="1 2 0"/>', "collision"),
        lambda m: link(m).collisions,
        [],
        ["link 'arm' collision", "left out"],
    ),
    "a negative box": (shape('<box size="1 -2 3"/>'), visual_sizes, [(1, 2, 3)], ["than 0"]),
    "a sphere of no size": (
        shape('<sphere radius="0"/>', "collision"),
        lambda m: link(m).collisions,
        [],
        ["link 'arm' collision", "sphere", "greater than 0", "left out"],
    ),
    "a sphere of a word": (shape('<sphere radius="r"/>'), visual_sizes, [], ["radius is 'r'"]),
    "a cylinder without length": (
        shape('<cylinder radius="1"/>'),
        visual_sizes,
        [],
        ["cylinder without length", "left out"],
    ),
    "a shape of another world": (shape("<cone/>"), visual_sizes, [], ["<cone>", "left out"]),
    "a shape in capitals": (shape('<Box size="1 1 1"/>'), visual_sizes, [], ["<Box>"]),
    "no geometry": (shape(""), visual_sizes, [], ["has no geometry"]),
    "a colour of two": (painted("1 0"), color, None, ["'m'", "'1 0'", "3 or 4"]),
    "a colour in 0..255": (painted("255 0 0 1"), color, (1, 0, 0, 1), []),
    "tabs and lines": (at("\t1\n 2\r\n\t3 "), place, (1, 2, 3), []),
    "other ways to write numbers": (at("+1 .5 2.e-1"), place, (1, 0.5, 0.2), []),
}


@pytest.mark.parametrize("text, read, expected, words", VALUES.values(), ids=VALUES)
def test_a_bad_value_costs_itself(text, read, expected, words):
    model = parse_urdf(robot(text), str, "car", "keep")
    assert read(model) == expected
    assert len(model.warnings) == (1 if words else 0), model.warnings
    for word in words:
        assert word in model.warnings[0]
    assert list(model.links) == ["base", "wheel", "arm"] and list(model.joints) == ["axle", "j"]
    assert model.joints["axle"].origin.position == (0, 1, 0)


TIP = f'<link name="tip">{MASS}</link>'
RED = '<material name="m"><color rgba="1 0 0 1"/></material>'


def hold(name="j", parent="base", child="tip"):
    """A joint."""
    ends = f'<parent link="{parent}"/><child link="{child}"/>'
    return f'<joint name="{name}" type="fixed">{ends}</joint>'


# what is wrong: text, links and joints beside the sound ones, words of the one warning
PARTS = {
    "a link without a name": ("<link/>", "", "", ["link '' of 'car'", "no name"]),
    "two links of one name": (TIP + TIP + hold(), "tip", "j", ["link 'tip'", "two of that name"]),
    "two joints of one name": (TIP + hold() + hold(), "tip", "j", ["joint 'j'", "two joints"]),
    "a joint without a name": (TIP + hold() + hold(""), "tip", "j", ["joint ''", "no name"]),
    "two parents": (TIP + hold() + hold("k"), "tip", "j", ["'tip'", "more than one parent"]),
    "a joint to itself": (TIP + hold() + hold("k", "base", "base"), "tip", "j", ["a loop"]),
    "a loop": (TIP + hold() + hold("k", "tip", "base"), "tip", "j", ["joint 'k'", "a loop"]),
    "no such child": (hold(child="nose"), "", "", ["child link 'nose'", "links are base, wheel"]),
    "no such parent": (hold(parent="nose", child="base"), "", "", ["parent link 'nose'"]),
    "a joint without ends": ('<joint name="j" type="fixed"/>', "", "", ["parent link 'None'"]),
    "tags of xacro": ("<xacro:wheel prefix='l'/>", "", "", ["<xacro:wheel>", "xacro first"]),
    "prefixes of old": ("<sensor:camera/><interface:audio/>", "", "", []),
    "tags in capitals": ("<Link name='x'/><JOINT name='y'/>", "", "", []),
    "a material without a colour": ('<material name="m"/>', "", "", []),
    "two materials of one name": (RED + RED, "", "", []),
    "a gazebo tag for no link": (
        '<gazebo reference="nose"><mu1>1</mu1></gazebo>',
        "",
        "",
        ["'nose'", "no link and no joint"],
    ),
    "a plugin without a name": ("<gazebo><plugin/></gazebo>", "", "", ["plugin 'None'"]),
}


BOX = '<geometry><box size="1 1 1"/></geometry>'
TWO = "<visual>{0}</visual><visual>{0}</visual><collision>{0}</collision><collision>{0}</collision>"


BOTH = TWO.format(BOX)


def tip(inertial=MASS, shapes=BOTH):
    """The link 'tip' of a robot with the sound parts, and the warnings."""
    model = parse_urdf(robot(f'<link name="tip">{inertial}{shapes}</link>{hold()}'), str, "car")
    return model.links["tip"], model.warnings


# an inertial: the mass that is read, words of the one warning; the link has no shapes
FAULTS = {
    '<mass value="3"/>': (3, ["no <inertia>"]),
    "<mass value='3'/><box_inertia m='1'/>": (3, ["no <inertia>", "<box_inertia>"]),
    '<mass value="3"/><inertia ixx="1" iyy="1" izz="1"/>': (3, ["inertia without ixy"]),
    INERTIA.format("1", "x"): (1, ["inertia ixy is 'x'"]),
    INERTIA.format("1.0 ", "0"): (0, ["mass value is '1.0 '"]),
    INERTIA.format("1kg", "0"): (0, ["'1kg'"]),
    INERTIA.format("${m}", "0"): (0, ["'${m}'", "process the file"]),
    '<origin xyz="0 0"/>' + INERTIA.format("1", "0"): (0, ["origin xyz is '0 0'"]),
    "<mass/>": (0, ["mass without value"]),
    "": (0, ["no <mass>"]),
}


@pytest.mark.parametrize("text, mass, words", [(k, *v) for k, v in FAULTS.items()], ids=FAULTS)
def test_an_inertial_with_a_fault_costs_what_comes_after_it_in_its_link(text, mass, words):
    link, warnings = tip(f"<inertial>{text}</inertial>")
    assert link.mass == mass and not link.inertia.any()
    assert link.visuals == [] and link.collisions == []
    (warning,) = warnings
    for word in ("link 'tip'", "as in Gazebo", *words):
        assert word in warning


@pytest.mark.parametrize("mass", [" 1", "1.", "+1e0"])
def test_what_urdfdom_reads_of_a_mass(mass):
    link, warnings = tip(f"<inertial>{INERTIA.format(mass, '0')}</inertial>")
    assert link.mass == 1 and len(link.collisions) == 2 and warnings == []


# shapes: how many visuals and collisions are read, a word of the one warning
LOST = {
    f"<visual>{BOX}</visual><visual><geometry><cone/></geometry></visual>": (1, 0, "<cone>"),
    "<visual><geometry><sphere/></geometry></visual>": (0, 0, "sphere without radius"),
    "<visual/>": (0, 0, "no geometry"),
    f"<visual>{BOX}<material/></visual>": (0, 0, "<material> without a name"),
    f'<visual><origin xyz="1 1"/>{BOX}</visual>': (0, 0, "origin xyz is '1 1'"),
    '<visual><geometry><mesh filename="a.stl" scale="1"/></geometry></visual>': (0, 0, "scale"),
    "<visual><geometry><mesh/></geometry></visual>": (0, 0, "without filename"),
    '<collision><geometry><box size="1 1 1 1"/></geometry></collision>': (2, 0, "'1 1 1 1'"),
    f"<collision>{BOX}</collision><collision/>": (2, 1, "no geometry"),
}


@pytest.mark.parametrize("text, visuals, collisions, word", [(k, *v) for k, v in LOST.items()])
def test_a_shape_with_a_fault_costs_the_shapes_that_urdfdom_reads_after_it(
    text, visuals, collisions, word
):
    link, warnings = tip(shapes=text + BOTH)
    assert (len(link.visuals), len(link.collisions)) == (visuals, collisions)
    (warning,) = warnings
    assert word in warning and "as in Gazebo" in warning


@pytest.mark.parametrize("text, links, joints, words", PARTS.values(), ids=PARTS)
def test_a_bad_part_costs_itself(text, links, joints, words):
    model = parse_urdf(robot(text), str, "car")
    assert list(model.links) == ["base", "wheel", *links.split()]
    assert list(model.joints) == ["axle", *joints.split()]
    assert len(model.warnings) == (1 if words else 0), model.warnings
    for word in words:
        assert word in model.warnings[0]


def test_what_is_left_falls_and_turns():
    """Each base falls as it should, whatever hangs on it, and nothing leaves for the sky."""
    world = World()
    try:
        rows = (*VALUES.values(), *PARTS.values())
        models = [
            world.spawn_urdf(f"car{number}", robot(row[0]), Pose((20.0 * number, 0.0, 10.0)), str)
            for number, row in enumerate(rows)
        ]
        world.step(100)
        for number, model in enumerate(models):
            for name in model.description.links:
                off = np.subtract(model.link_state(name)[0].position, (20.0 * number, 0, 10))
                assert all(map(math.isfinite, off)) and np.linalg.norm(off) < 10, rows[number]
            fall = 10 - model.pose.position[2]
            assert fall == pytest.approx(0.5 * 9.81 * 0.1**2, abs=0.01), rows[number]
    finally:
        world.close()


INDEFINITE = (
    'ixx="1" iyy="1" izz="1" ixy="5"',
    'ixx="-1" iyy="-1" izz="-1"',
    'ixx="0" iyy="0" izz="0"',
    'ixx="1e300" iyy="1e300" izz="1e300" ixy="1e300"',
)
UNEVEN = 'ixx="1" iyy="1" izz="100"', 'ixx="1e-9" iyy="1e-9" izz="1"'


@pytest.mark.parametrize(
    "inertia, solver",
    [
        *((inertia, solver) for inertia in INDEFINITE for solver in ("ode", "bullet")),
        *((inertia, "bullet") for inertia in UNEVEN),
    ],
)
def test_inertias_that_no_body_has_turn_without_a_bang(inertia, solver):
    """Also where one moment is more than the two others together, which Gazebo takes as it is."""
    world = World(solver=solver)
    try:
        text = robot(inertial(inertia=inertia))
        model = world.spawn_urdf("car", text, Pose((0.0, 0.0, 10.0)), str)
        model.set_state(Pose((0.0, 0.0, 10.0)), angular=(1.0, 2.0, 3.0))
        world.step(200)
        position, turning = model.pose.position, model.link_state("arm")[2]
        assert all(map(math.isfinite, position)) and np.linalg.norm(position) < 20
        assert np.linalg.norm(turning) < 50
    finally:
        world.close()
