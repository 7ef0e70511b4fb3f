"""<collide_without_contact>: what is in the way is told, and stops nothing."""

import pytest
from bullet_sim.pose import Pose
from bullet_sim.world import World

FLAG = "<collide_without_contact>{}</collide_without_contact>"
MASK = "<collide_without_contact_bitmask>{}</collide_without_contact_bitmask>"
INERTIAL = (
    "<inertial><mass>1</mass><inertia><ixx>0.01</ixx><iyy>0.01</iyy><izz>0.01</izz></inertia>"
    "</inertial>"
)


def box(name, size, contact, static=False, more=""):
    return (
        f'<model name="{name}"><static>{int(static)}</static><link name="link">{INERTIAL}'
        f'<collision name="c"><geometry><box><size>{size}</size></box></geometry><surface>'
        f"<contact>{contact}</contact></surface></collision>{more}</link></model>"
    )


WORLD = {"gravity": (0.0, 0.0, 0.0)}
SOLVERS = ("ode", "bullet")


def spawn(world, name, size, contact="", position=(0.0, 0.0, 0.0), **options):
    text = box(name, size, contact, **options)
    return world.spawn_sdf(name, text, Pose(position), str)


def pushed(world, puck):
    """Where a puck is that starts at 1 m/s along x, after 2 s."""
    puck.set_state(Pose(), (1.0, 0.0, 0.0))
    world.step(2000)
    return puck.pose.position[0]


@pytest.mark.parametrize("static", [True, False])
@pytest.mark.parametrize("on_puck", [True, False])
def test_it_stops_nothing_and_is_told(world, static, on_puck):
    flag = FLAG.format("true")
    gate = spawn(world, "gate", "0.4 2 1", "" if on_puck else flag, (1.0, 0, 0), static=static)
    puck = spawn(world, "puck", "0.2 0.2 0.2", flag if on_puck else "")
    assert gate.body.contacts(gate.root) == []
    puck.set_state(Pose(), (1.0, 0.0, 0.0))
    world.step(1000)
    for one, other in ((gate, puck), (puck, gate)):
        contacts = one.body.contacts(one.root)
        assert contacts, "while it is inside"
        assert {(each.body, each.link) for each in contacts} == {(other.body.number, other.root)}
        assert all(each.depth > 0.0 and not each.force.any() for each in contacts)
    world.step(1000)
    assert gate.body.contacts(gate.root) == []
    assert puck.pose.position[0] == pytest.approx(2.0, abs=1e-6)
    if not static:
        assert gate.pose.position == pytest.approx((1.0, 0.0, 0.0), abs=1e-9)


@pytest.mark.parametrize("flag", ["", FLAG.format("false"), FLAG.format("0")])
def test_without_it_the_puck_is_stopped(world, flag):
    spawn(world, "gate", "0.4 2 1", flag, (1.0, 0, 0), static=True)
    assert pushed(world, spawn(world, "puck", "0.2 0.2 0.2")) < 0.75


@pytest.mark.parametrize(
    "gate, puck, told", [("0x01", "0x01", True), ("0x02", "0x01", False), ("6", "2", True)]
)
def test_its_bitmask_says_whether_it_is_told(world, gate, puck, told):
    flag = FLAG.format("true") + MASK.format(gate)
    made = spawn(world, "gate", "0.4 2 1", flag, static=True)
    spawn(world, "puck", "0.2 0.2 0.2", MASK.format(puck))
    world.step(1)
    assert bool(made.body.contacts(made.root)) is told


def test_one_shape_of_a_link_may_push_and_another_not():
    world = World(gravity=(0.0, 0.0, 0.0), solver="ode")
    ring = (
        '<collision name="ring"><pose>0.5 0 0 0 0 0</pose><geometry><sphere><radius>0.3</radius>'
        f"</sphere></geometry><surface><contact>{FLAG.format('true')}</contact></surface></collision>"
    )
    puck = spawn(world, "puck", "0.2 0.2 0.2", more=ring)
    wall = spawn(world, "wall", "0.2 2 2", position=(1.0, 0, 0), static=True)
    puck.set_state(Pose(), (1.0, 0.0, 0.0))
    world.step(300)
    (contact,) = puck.body.contacts(puck.root)
    assert contact.body == wall.body.number and not contact.force.any()
    world.step(1700)
    assert puck.pose.position[0] == pytest.approx(0.8, abs=0.01), "the box is stopped"
    world.close()


def test_a_deleted_one_is_forgotten(world):
    spawn(world, "gate", "0.4 2 1", FLAG.format("true"), static=True)
    puck = spawn(world, "puck", "0.2 0.2 0.2")
    world.delete("gate")
    world.step(1)
    assert puck.body.contacts(puck.root) == []
    spawn(world, "gate", "0.4 2 1", FLAG.format("true"), static=True)
    world.reset()
    world.step(1)
    assert puck.body.contacts(puck.root)
