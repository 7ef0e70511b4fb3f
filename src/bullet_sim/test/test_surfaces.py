"""<bounce>, <torsional> and <max_contacts>, as Gazebo's ODE has them."""

import math

import pytest
from bullet_sim.description.model import Surface, Torsion
from bullet_sim.formats.sdf.world import parse_model, parse_world
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.pose import Pose
from bullet_sim.world import World

pytestmark = pytest.mark.usefixtures("sketches")

G, RADIUS, INERTIA = 9.8, 0.1, 0.004
BALL = f"<sphere><radius>{RADIUS}</radius></sphere>"
BOX = "<box><size>0.4 0.3 0.2</size></box>"
PLANE = "<plane><normal>0 0 1</normal></plane>"
FAST = "<contact><ode><max_vel>100</max_vel></ode></contact>"  # bounces are not bounded


def model(name, shape, surface="", more="", static=False):
    mass = "<inertial><mass>1</mass><inertia>" + "".join(
        f"<{axis}>{INERTIA}</{axis}>" for axis in ("ixx", "iyy", "izz")
    )
    text = (
        f'<sdf version="1.7"><model name="{name}"><static>{int(static)}</static><link name="l">'
        f'{mass}</inertia></inertial><collision name="c"><geometry>{shape}</geometry>{more}'
        f"<surface>{surface}</surface></collision></link></model></sdf>"
    )
    return parse_model(text, str)[0]


@pytest.fixture(name="world")
def _world():
    made = World(gravity=(0.0, 0.0, -G))
    yield made
    made.close()


def bounce(restitution, threshold):
    return (
        f"<bounce><restitution_coefficient>{restitution}</restitution_coefficient>"
        f"<threshold>{threshold}</threshold></bounce>"
    )


def rebound(world, ground, ball, moving=False):
    """Speed with which a ball that falls at 2 m/s leaves a ground [m/s]."""
    if moving:
        world.spawn(model("ground", "<box><size>4 4 2</size></box>", ground), Pose((0, 0, -1)))
        world.spawn(model("floor", PLANE, static=True), Pose((0, 0, -2)))
        world.step(50)
    else:
        world.spawn(model("ground", PLANE, ground, static=True))
    found = world.spawn(model("ball", BALL, ball), Pose((0, 0, RADIUS + 0.004)))
    found.set_state(found.pose, linear=(0.0, 0.0, -2.0))
    fastest = 0.0
    for _ in range(20):
        world.step(1)
        fastest = max(fastest, found.link_motion("l")[2][2])
    return fastest


@pytest.mark.parametrize("restitution", [0.3, 0.8, 1.0])
def test_a_ball_comes_back_with_a_part_of_its_speed(world, restitution):
    surface = bounce(restitution, 0.1) + FAST
    speed = rebound(world, surface, surface)
    assert speed == pytest.approx(2.0 * restitution, abs=0.03)


@pytest.mark.parametrize(
    "ground, ball, expected",
    [
        ("", bounce(0.8, 0) + FAST, 0.0),  # the lower restitution counts
        (bounce(0.8, 3) + FAST, bounce(0.8, 5) + FAST, 0.0),  # slower than the lower threshold
        (bounce(0.8, 0.1), bounce(0.4, 9) + FAST, 0.8),
        (bounce(0.8, 0), bounce(0.8, 0), 0.01),  # max_vel of the ball bounds it
    ],
)
def test_what_decides_whether_it_comes_back(world, ground, ball, expected):
    assert rebound(world, ground, ball) == pytest.approx(expected, abs=0.03)


def test_a_ball_comes_back_from_what_moves(world):
    surface = bounce(0.5, 0.1) + FAST
    # of both masses alike: they part with half of the speed with which they met
    assert rebound(world, surface, surface, moving=True) > 0.2


def turning(radius_tags, coefficient=0.5):
    torsion = f"<torsional><coefficient>{coefficient}</coefficient>{radius_tags}</torsional>"
    return f"<friction>{torsion}</friction>"


def slowing(world, ball, ground=""):
    """How fast a ball that turns about the vertical loses speed [rad/s^2]."""
    world.spawn(model("ground", PLANE, ground, static=True))
    found = world.spawn(model("ball", BALL, ball), Pose((0, 0, RADIUS)))
    world.step(200)
    found.set_state(found.pose, angular=(0.0, 0.0, 50.0))
    world.step(100)
    first = found.link_motion("l")[3][2]
    world.step(100)
    return (first - found.link_motion("l")[3][2]) / (100 * world.time_step)


@pytest.mark.parametrize("patch, coefficient", [(0.02, 0.5), (0.05, 0.2), (0.0, 1.0)])
def test_torsional_friction_of_a_patch(world, patch, coefficient):
    found = slowing(world, turning(f"<patch_radius>{patch}</patch_radius>", coefficient))
    moment = 3.0 * math.pi / 16.0 * patch * coefficient * G  # of 1 kg
    assert found == pytest.approx(moment / INERTIA, rel=0.01, abs=1e-9)


def test_the_larger_patch_and_the_smaller_coefficient_count(world):
    ground = turning("<patch_radius>0.04</patch_radius>", 0.1)
    found = slowing(world, turning("<patch_radius>0.01</patch_radius>", 0.5), ground)
    assert found == pytest.approx(3.0 * math.pi / 16.0 * 0.04 * 0.1 * G / INERTIA, rel=0.01)


def test_torsional_friction_by_the_depth(world):
    """The radius is that of the surface times the depth, which stiffness gives."""
    tags = "<use_patch_radius>false</use_patch_radius><surface_radius>0.1</surface_radius>"
    soft = "<contact><ode><kp>1e4</kp><kd>100</kd><max_vel>100</max_vel></ode></contact>"
    found = slowing(world, turning(tags) + soft)
    depth = RADIUS - world.models["ball"].pose.position[2]
    assert depth == pytest.approx(G / 1e4, rel=0.05)
    moment = 3.0 * math.pi / 16.0 * math.sqrt(0.1 * depth) * 0.5 * G
    assert found == pytest.approx(moment / INERTIA, rel=0.02)


def test_slip_lets_a_ball_go_on_turning(world):
    """It turns as fast as slip times the moment of the friction allows."""
    tags = "<patch_radius>0.05</patch_radius><ode><slip>%s</slip></ode>"
    both = turning(tags % 1e4)
    assert slowing(world, both, both) < 0.2 * slowing_without(tags % 0)


def slowing_without(tags):
    other = World(gravity=(0.0, 0.0, -G))
    found = slowing(other, turning(tags), turning(tags))
    other.close()
    return found


@pytest.mark.parametrize(
    "own, its, of_world, count",
    [(10, 10, 20, 4), (3, 10, 20, 3), (10, 1, 20, 1), (10, 10, 2, 2), (0, 10, 20, 0)],
)
def test_number_of_contacts_of_a_pair(own, its, of_world, count):
    described = parse_world(
        '<sdf version="1.7"><world name="w"><physics type="ode">'
        f"<max_contacts>{of_world}</max_contacts></physics></world></sdf>",
        str,
    )
    assert described.warnings == []
    for kind in (PLANE, "<box><size>9 9 2</size></box>"):
        world = World()
        world.load(described)
        most = [f"<max_contacts>{number}</max_contacts>" for number in (own, its)]
        place = Pose((0, 0, 0 if kind is PLANE else -1))
        world.spawn(model("ground", kind, more=most[1], static=True), place)
        box = world.spawn(model("box", BOX, more=most[0]), Pose((0, 0, 0.0999)))
        world.step(1)
        found = len(box.body.contacts(box.root))
        world.close()
        assert found == count


def test_what_a_urdf_says():
    text = (
        '<robot name="r"><link name="a"><collision><geometry><sphere radius="1"/></geometry>'
        '</collision></link><gazebo reference="a"><maxContacts>3</maxContacts></gazebo></robot>'
    )
    model_ = parse_urdf(text, str)
    assert model_.warnings == [] and model_.links["a"].surface == Surface(most=3)
    more = (
        f"<collision><surface>{bounce(0.5, 2)}{turning('<patch_radius>1</patch_radius>')}"
        "</surface></collision></gazebo>"
    )
    surface = parse_urdf(text.replace("</gazebo>", more), str).links["a"].surface
    assert surface == Surface(
        most=3, bounce=0.5, bounce_speed=2.0, torsion=Torsion(0.5, patch_radius=1.0)
    )
