"""<bounce>, <torsional> and <max_contacts>, as Gazebo's ODE has them."""

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


WORLD = {"gravity": (0.0, 0.0, -G)}


def bounce(restitution, threshold):
    return (
        f"<bounce><restitution_coefficient>{restitution}</restitution_coefficient>"
        f"<threshold>{threshold}</threshold></bounce>"
    )


def rebound(world, ground, ball):
    """Speed with which a ball that falls at 2 m/s leaves a ground [m/s]."""
    world.spawn(model("ground", PLANE, ground, static=True))
    found = world.spawn(model("ball", BALL, ball), Pose((0, 0, RADIUS + 0.004)))
    found.set_state(found.pose, linear=(0.0, 0.0, -2.0))
    fastest = 0.0
    for _ in range(20):
        world.step(1)
        fastest = max(fastest, found.link_motion("l")[2][2])
    return fastest


@pytest.mark.parametrize(
    "ground, ball, expected",
    [
        ("", bounce(0.8, 0) + FAST, 0.0),  # the lower restitution counts
        (bounce(0.8, 3) + FAST, bounce(0.8, 5) + FAST, 0.0),  # slower than the lower threshold
        (bounce(0.8, 0.1), bounce(0.4, 9) + FAST, 0.8),
        (bounce(1.0, 0.1) + FAST, bounce(1.0, 0.1) + FAST, 2.0),
        (bounce(0.8, 0), bounce(0.8, 0), 0.01),  # max_vel of the ball bounds it
    ],
)
def test_what_decides_whether_it_comes_back(world, ground, ball, expected):
    assert rebound(world, ground, ball) == pytest.approx(expected, abs=0.03)


def turning(radius_tags, coefficient=0.5):
    torsion = f"<torsional><coefficient>{coefficient}</coefficient>{radius_tags}</torsional>"
    return f"<friction>{torsion}</friction>"


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
