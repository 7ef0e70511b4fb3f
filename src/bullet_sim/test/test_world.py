"""The world on the real engine."""

import math
import pickle

import numpy as np
import pytest
from bullet_sim.description.model import Geometry, Link, ModelDescription, Shape
from bullet_sim.engine.api import Rays
from bullet_sim.errors import ModelError, WorldError
from bullet_sim.formats.sdf import world as sdf
from bullet_sim.pose import Pose
from bullet_sim.world import World
from urdf_texts import CONTROL, joint, link, robot, tags

CART = robot(
    link("base", 2, 0.02, '<box size="0.4 0.2 0.1"/>'),
    *(
        link(name, 0.1, 1e-4, '<cylinder radius="0.08" length="0.04"/>', f"{math.pi / 2} 0 0")
        + joint(f"{name}_joint", "continuous", "base", name, f"{x} {y} 0",
                more='<limit effort="5" velocity="100"/>')
        + tags(name, mu1=0.7, mu2=0.7)
        for name, x, y in (("fl", 0.15, 0.15), ("fr", 0.15, -0.15), ("rl", -0.15, 0.15),
                           ("rr", -0.15, -0.15))
    ),
    CONTROL,
    name="cart",
)  # fmt: skip
WHEELS = ("fl", "fr", "rl", "rr")
SOLVERS = ("ode", "bullet")


def box(name="box", size=0.2, friction=None, mass=1.0):
    """A cube."""
    link = Link("link", mass, inertia=mass * size**2 / 6 * np.eye(3))
    link.collisions.append(Shape(Geometry("box", (size,) * 3)))
    link.surface.friction = link.surface.friction2 = friction
    return ModelDescription(name, {"link": link}, root="link")


def with_cart(world, height=0.085):
    """Spawn ground and cart, start a controller per wheel."""
    world.spawn(sdf.ground_plane())
    cart = world.spawn_urdf("cart", CART, Pose((0.0, 0.0, height)), str)
    for name in WHEELS:
        cart.manager.load(
            name, {"type": "velocity_controllers/JointVelocityController", "joint": f"{name}_joint"}
        )
    cart.manager.switch(WHEELS, [])
    return cart


def drive(world, cart, steps=400):
    """Drive a curve; the bytes of all joint states and poses on the way."""
    trail = []
    for step in range(steps):
        for name in WHEELS:
            cart.manager.command(name, [10.0 + 5.0 * math.sin(0.01 * step) * (name[1] == "l")])
        world.step()
        trail.append(
            b"".join(values.tobytes() for values in cart.joints.arrays())
            + np.array(cart.pose.position + cart.pose.orientation).tobytes()
        )
    return trail


def test_spawn_and_delete(world):
    model = world.spawn(box(), Pose((1.0, 2.0, 3.0)))
    assert world.model("box") is model and model.pose.position == pytest.approx((1, 2, 3))
    world.delete("box")
    assert world.models == {}


def test_names_taken_empty_and_unknown(world):
    world.spawn(box())
    with pytest.raises(ModelError, match="'box' exists already; models are box"):
        world.spawn(box())
    with pytest.raises(ModelError, match="needs a name"):
        world.spawn(box(""))
    for call in (world.delete, world.model):
        with pytest.raises(WorldError, match="'gone' does not exist; models are box"):
            call("gone")
    assert list(world.models) == ["box"]


def test_time_goes_by_in_steps():
    world = World(time_step=0.002)
    for _ in range(500):
        world.step()
    assert (world.time_step, world.step_count) == (0.002, 500)
    assert world.time == pytest.approx(1.0)
    world.reset(time=False)
    assert world.step_count == 500
    world.reset()
    assert world.time == 0
    world.close()


def test_a_world_with_a_state_starts_there_and_is_reset_to_its_poses(world):
    link = '<link name="l"/>'
    world.load(
        sdf.parse_world(
            '<sdf version="1.6"><world name="w"><gravity>0 0 0</gravity>'
            f'<model name="a"><pose>1 0 0 0 0 0</pose>{link}</model>'
            f'<model name="b"><pose>2 0 0 0 0 0</pose><static>1</static>{link}</model>'
            '<state world_name="w"><model name="a"><pose>5 6 7 0 0 0</pose></model>'
            '<model name="b"><pose>0 0 8 0 0 0</pose></model></state></world></sdf>',
            str,
        )
    )
    assert [model.pose.position for model in world.models.values()] == [(5, 6, 7), (0, 0, 8)]
    world.step(3)
    assert world.model("a").pose.position == pytest.approx((5, 6, 7))
    world.reset_models()
    assert [model.pose.position for model in world.models.values()] == [(1, 0, 0), (2, 0, 0)]
    world.model("a").set_state(Pose((3.0, 3.0, 3.0)))
    world.reset()
    assert world.model("a").pose.position == (1, 0, 0)


def test_a_state_inserts_and_deletes_models_and_lights(world):
    """As Gazebo 11.1 was seen to do: it inserts unless the name is taken, moves, then deletes."""

    def model(name, x, y):
        pose = f"<pose>{x} {y} 1 0 0 0</pose>"
        return f'<model name="{name}"><static>1</static>{pose}<link name="l"/></model>'

    def light(name, z):
        return f'<light name="{name}" type="point"><pose>0 0 {z} 0 0 0</pose></light>'

    inserted = model("new", 4, 0) + model("swap", 1, 5) + model("twice", 2, 5) + light("more", 7)
    described = sdf.parse_world(
        '<sdf version="1.6"><world name="w">'
        + "".join(model(name, x, 0) for x, name in enumerate(("gone", "swap", "twice")))
        + light("lamp", 3)
        + light("sun", 9)
        + '<state world_name="w"><model name="new"><pose>9 9 9 0 0 0</pose></model><insertions>'
        + f"{inserted + light('sun', 1)}</insertions><deletions><name>gone</name><name>swap</name>"
        "<name>lamp</name><name>nothing</name></deletions></state></world></sdf>",
        str,
    )
    lights = [(light.name, light.position[2]) for light in described.scene.lights]
    assert lights == [("sun", 9), ("more", 7)]
    world.load(described)
    found = {name: model.pose.position for name, model in world.models.items()}
    assert found == {"twice": (2, 0, 1), "new": (9, 9, 9)}
    world.reset_models()
    assert world.model("new").pose.position == (4, 0, 1)


def started(model, state):
    """A world that starts with a model and a <state> of it, after 50 steps, and the model."""
    text = (
        f'<sdf version="1.6"><world name="w"><gravity>0 0 -9.8</gravity><model name="b">{model}'
        f'</model><state world_name="w"><model name="b">{state}</model></state></world></sdf>'
    )
    world = World()
    world.load(sdf.parse_world(text, str))
    world.step(50)
    return world, world.model("b")


def test_links_start_with_the_velocities_and_the_wrench_of_a_state():
    """The numbers are those of Gazebo 11.1: the wrench acts in the first step, along the world's
    axes, and a model whose state has no pose is at the origin."""
    inertial = (
        "<inertial><pose>0.1 0 0 0 0 0</pose><mass>1</mass><inertia><ixx>0.01</ixx>"
        "<iyy>0.01</iyy><izz>0.02</izz></inertia></inertial>"
    )
    world, model = started(
        f'<pose>9 9 2 0 0 1</pose><link name="l"><pose>0 0 0 0 0 0.5</pose>{inertial}</link>',
        '<link name="l"><pose>0 0 2 0 0 1.5</pose><velocity>1 0 0 0 0 2</velocity>'
        "<acceleration>7 0 0 0 0 0</acceleration><wrench>5 0 0 0 0 1</wrench></link>",
    )
    pose, linear, angular = model.link_state("l")
    arm = pose.matrix @ (0.1, 0.0, 0.0)
    center = (0.0573237201668, 0.0997494986604, 1.987505)
    assert pose.position + arm == pytest.approx(center, abs=1e-9)
    assert pose.rpy == pytest.approx((0.0, 0.0, 1.60249996), abs=1e-7)
    assert linear + np.cross(angular, arm) == pytest.approx((1.005, 0.0, -0.49), abs=1e-9)
    assert angular == pytest.approx((0.0, 0.0, 2.05), abs=1e-9)
    world.reset_models()
    world.step()
    assert model.link_state("l")[2] == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)
    world.close()


@pytest.mark.parametrize(
    "state, inner, angle",
    [
        ("<pose>0 0 3 0 0 0</pose>", (1.1, 0.0, 2.987505), 0.0),
        (
            '<pose>0 0 3 0 0 0</pose><model name="n"><pose>5 1 4 0 0 0.5</pose></model>',
            (5.08775825619, 1.04794255386, 3.987505),
            0.5,
        ),
        (
            '<pose>0 0 3 0 0 0</pose><model name="n"><link name="l"><pose>5 1 4 0 0 0.5</pose>'
            "</link></model>",
            (5.0, 1.0, 3.987505),
            0.5,
        ),
    ],
)
def test_models_in_a_model_start_where_the_state_has_them(state, inner, angle):
    """The numbers are those of Gazebo 11.1."""
    link = (
        '<link name="{}"><pose>{} 0 0 0 0 0</pose><inertial><mass>1</mass></inertial></link>'
    ).format
    text = f'{link("l", 0)}<model name="n"><pose>1 0 0 0 0 0</pose>{link("l", 0.1)}</model>'
    world, model = started(f"<pose>0 0 2 0 0 0</pose>{text}", state)
    assert model.link_state("l")[0].position == pytest.approx((0.0, 0.0, 2.987505), abs=1e-9)
    pose = model.link_state("n::l")[0]
    assert pose.position == pytest.approx(inner, abs=1e-9)
    assert pose.rpy[2] == pytest.approx(angle, abs=1e-9)
    world.close()


def test_a_saved_world_goes_on_at_its_time_until_a_reset(world):
    state = "<state world_name='w'><sim_time>12 500000000</sim_time></state>"
    world.load(sdf.parse_world(f"<sdf version='1.6'><world name='w'>{state}</world></sdf>", str))
    assert world.time == pytest.approx(12.5)
    world.step(10)
    assert world.time == pytest.approx(12.51)
    world.reset()
    assert world.time == 0.0


MAST = robot(
    link("base", 2), link("mast", 0.5, 0.01),
    joint("turn", "continuous", "base", "mast", axis="0 0 1"),
)  # fmt: skip


def moved_mast(solver):
    """A world with a robot that was moved and turned, the robot, and its pose before."""
    world = World(gravity=(0.0, 0.0, 0.0), solver=solver)
    start = Pose.from_xyz_rpy((1.0, 2.0, 3.0), (0.0, 0.0, 0.5))
    model = world.spawn_urdf("r", MAST, start, str)
    model.joints.set_positions({"turn": 0.8})
    model.set_state(Pose((4.0, 4.0, 4.0)), (1, 0, 0), (0, 0, 2))
    return world, model, start


@pytest.mark.parametrize("solver", ["bullet", "ode"])
def test_reset_models_puts_back_poses_and_stops_but_keeps_joints_and_time(solver):
    world, model, start = moved_mast(solver)
    world.forces.apply_effort(model, "turn", 0.1, (0, 50))
    world.step(100)
    turned = model.joints.arrays()[0][0]
    assert turned != pytest.approx(0.8, abs=1e-3) and abs(model.joints.arrays()[1][0]) > 1e-3
    world.reset_models()
    assert world.step_count == 100
    assert model.pose.position == pytest.approx(start.position)
    assert model.pose.orientation == pytest.approx(start.orientation)
    positions, velocities, _ = model.joints.arrays()
    assert positions[0] == pytest.approx(turned, abs=1e-9) and velocities[0] == 0.0
    for name in ("base", "mast"):
        _, linear, angular = model.link_state(name)
        np.testing.assert_allclose([linear, angular], np.zeros((2, 3)), atol=1e-9)
    world.step(100)
    assert model.pose.position == pytest.approx(start.position, abs=1e-6)
    assert model.joints.arrays()[0][0] == pytest.approx(turned, abs=1e-6)
    world.close()


@pytest.mark.parametrize("solver", ["bullet", "ode"])
def test_start_over_puts_joints_back_too_and_wrenches_go_on_in_their_time(solver):
    world, model, start = moved_mast(solver)
    world.forces.apply_wrench(model, "base", (5, 0, 0), (0, 0, 0), (150, 200))
    world.step(100)
    world.start_over()
    assert world.step_count == 0
    assert model.pose.position == pytest.approx(start.position)
    positions, velocities, _ = model.joints.arrays()
    assert positions[0] == pytest.approx(0.0, abs=1e-9) and velocities[0] == 0.0
    world.step(149)
    assert model.pose.position == pytest.approx(start.position, abs=1e-6)
    world.step(100)
    assert model.link_state("base")[1][0] > 0.05, "pushed from 0.15 s of the new time on"
    world.start_over(time=False)
    assert world.step_count == 249
    world.close()


def test_start_over_lets_controllers_go_on_with_their_commands(world):
    cart = with_cart(world)
    drive(world, cart)
    running = cart.manager.get_state()["_states"]
    world.start_over()
    assert math.hypot(*cart.pose.position[:2]) < 1e-6
    assert cart.manager.get_state()["_states"] == running
    for _ in range(500):
        world.step()
    assert math.hypot(*cart.pose.position[:2]) > 0.1, "it drives on"


def test_set_state(world):
    model = world.spawn(box())
    model.set_state(Pose((1.0, 1.0, 5.0)), (1, 2, 3), (0.1, 0.2, 0.3))
    pose, linear, angular = model.link_state("link")
    assert pose.position == pytest.approx((1, 1, 5))
    np.testing.assert_allclose([linear, angular], [[1, 2, 3], [0.1, 0.2, 0.3]], atol=1e-12)


def test_poses_have_double_precision(world):
    """PyBullet's own product of poses has single: 6 cm at 1,000 km."""
    text = (
        '<robot name="r"><link name="l"><inertial><origin xyz="0.1 0.2 0.3" rpy="0.3 0.2 0.1"/>'
        '<mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="2" iyz="0" izz="2"/></inertial>'
        "</link></robot>"
    )
    pose = Pose.from_xyz_rpy((123456.7890123, -0.1234567890123, 5.0), (0.1, -0.7, 3.0))
    model = world.spawn_urdf("r", text, pose, str)
    assert model.pose.position == pytest.approx(pose.position, rel=1e-14)
    np.testing.assert_allclose(model.pose.matrix, pose.matrix, atol=1e-14)


def test_load_of_a_world_file(world):
    text = (
        '<sdf version="1.6"><world name="w"><gravity>0 0 -1</gravity><physics><max_step_size>'
        "0.004</max_step_size></physics><include><uri>model://ground_plane</uri></include>"
        "<include><uri>/no/such.sdf</uri></include></world></sdf>"
    )
    warnings = world.load(sdf.parse_world(text, str))
    assert (world.name, world.time_step, world.gravity) == ("w", 0.004, (0, 0, -1))
    assert list(world.models) == ["ground_plane"]
    assert len(warnings) == 1 and "/no/such.sdf" in warnings[0]


def test_reset_keeps_gravity_and_step(world):
    world.load(sdf.WorldDescription(gravity=(0.0, 0.0, 0.0), step=0.002))
    model = world.spawn(box(), Pose((0.0, 0.0, 1.0)))
    world.reset()
    for _ in range(10):
        world.step()
    assert model.pose.position[2] == pytest.approx(1.0)
    assert world.time == pytest.approx(0.02)


def test_snapshot_can_be_pickled(world):
    with_cart(world)
    world.step()
    snapshot = world.snapshot()
    assert pickle.loads(pickle.dumps(snapshot)) == snapshot
    assert snapshot.step == 1 and len(snapshot.bodies) == 2
    assert [len(body.joints) for body in snapshot.bodies] == [0, 4]
    assert pickle.loads(pickle.dumps(world.sources())) == world.sources()


def test_many_spawns_and_deletes_leave_nothing_behind(world):
    with_cart(world)
    for _ in range(50):
        world.spawn_urdf("other", CART, Pose((3.0, 0.0, 0.1)), str)
        world.step()
        world.delete("other")
    assert len(world.snapshot().bodies) == len(world.sources()) == 2
    down = np.array([(0.0, 0.0, -1.0)])
    assert world.engine.cast_rays(Rays(np.array((3.0, 0.0, 5.0)), down, 0.0, 4.99)).tolist() == [
        math.inf
    ]


def test_keys_are_never_used_twice(world):
    keys = set()
    for _ in range(5):
        keys.add(world.spawn(box()).source.key)
        world.delete("box")
    assert len(keys) == 5


def test_link_that_does_not_exist(world):
    with pytest.raises(ModelError, match="'box' has no link 'nose'; links are link"):
        world.spawn(box()).link_state("nose")
