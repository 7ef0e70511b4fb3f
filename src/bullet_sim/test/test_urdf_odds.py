"""URDFs as they are found: worlds as roots, odd joints, leftovers, odd numbers; none crashes."""

import numpy as np
import pytest
import trimesh
from bullet_sim.formats.joints import NOTHING
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.pose import Pose
from bullet_sim.world import World
from urdf_texts import inertial, robot

pytestmark = pytest.mark.usefixtures("sketches")

BOX = inertial("{m}", "{i}")
BOX += '<collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision>'
BODY = BOX.format(m=1, i=0.01)


def joint(kind, parent, child, extra="", name="j"):
    """A joint."""
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f"{extra}</joint>"
    )


def spawned(world, content, height=1.0):
    """A robot spawned at a height, after 0.2 s."""
    model = world.spawn_urdf("r", robot(content), Pose((0.0, 0.0, height)), str)
    world.step(200)
    return model


FALL = 0.5 * 9.81 * 0.2**2  # [m] in 0.2 s


def test_a_root_link_world_holds_the_robot(world):
    arm = (
        f'<link name="world"/><link name="base">{BODY}</link><link name="arm">{BODY}</link>'
        + joint("fixed", "world", "base", '<origin xyz="0 0 1"/>')
        + joint("continuous", "base", "arm", '<origin xyz="0.5 0 0"/><axis xyz="0 1 0"/>', "k")
    )
    model = spawned(world, arm, 0.0)
    assert model.link_state("base")[0].position == pytest.approx((0, 0, 1), abs=1e-6)
    assert model.description.warnings == []


@pytest.mark.parametrize("kind", ["floating", "planar"])
def test_a_free_joint_to_the_world_lets_it_fall(world, kind):
    # Gazebo 11.1 makes no joint of it, and the link starts at the model's pose
    model = spawned(
        world,
        f'<link name="world"/><link name="base">{BODY}</link>'
        + joint(kind, "world", "base", '<origin xyz="0 0 0.3"/>'),
    )
    assert model.pose.position[2] == pytest.approx(1 - FALL, abs=0.005)
    assert model.link_names == ("base",)


@pytest.mark.parametrize("kind", ["floating", "planar"])
def test_below_joints_that_gazebo_does_not_know_links_are_free_and_start_at_the_models_pose(
    world, kind
):
    content = (
        f'<link name="a">{BODY}</link><link name="b">{BODY}</link><link name="c">{BODY}</link>'
        + joint(kind, "a", "b", '<origin xyz="1 0 0"/>')
        + joint("fixed", "b", "c", '<origin xyz="0 1 0"/>', "held")
    )
    model = world.spawn_urdf("r", robot(content), Pose((0.0, 0.0, 1.0)), str)
    assert kind in model.description.warnings[0] and "'j'" in model.description.warnings[0]
    assert model.link_state("b")[0].position == pytest.approx((0.0, 0.0, 1.0))
    assert model.link_state("c")[0].position == pytest.approx((0.0, 1.0, 1.0))
    model.apply_wrench("b", (20.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    world.step(200)
    for name in "ab":
        assert model.link_state(name)[0].position[2] == pytest.approx(1 - FALL, abs=0.005)
    assert model.link_state("b")[0].position[0] > 1e-3 + model.link_state("a")[0].position[0]


@pytest.mark.parametrize(
    "mass, inertia, warned",
    [
        ("0", "0", True),
        ("1", "0", True),
        ("1", "-0.1", True),
        ("1", "1e-15", True),
        ("1", "0.01", False),
        ("1e-9", "1e-20", True),
    ],
)
def test_odd_masses_still_fall(world, mass, inertia, warned):
    model = spawned(world, f'<link name="a">{BOX.format(m=mass, i=inertia)}</link>')
    assert model.pose.position[2] == pytest.approx(1 - FALL, abs=0.005)
    assert bool(model.description.warnings) == warned


@pytest.mark.parametrize(
    "limit, expected",
    [
        ('<limit effort="inf" velocity="inf" lower="-1" upper="1"/>', (-1, 1, 0, 0)),
        ('<limit effort="5" velocity="1e16" lower="-inf" upper="inf"/>', (None, None, 5, 0)),
        ('<limit effort="5" velocity="2" lower="0"/>', (0, 0, 5, 2)),
        ('<limit effort="0" velocity="0" lower="2" upper="1"/>', (1, 2, NOTHING, NOTHING)),
        ('<limit effort="5" velocity="2" lower="-1" upper="inf"/>', (-1, 1e9, 5, 2)),
        ("", (None, None, 0, 0)),
    ],
)
def test_limits(limit, expected):
    text = robot('<link name="a"/><link name="b"/>' + joint("revolute", "a", "b", limit))
    read = parse_urdf(text, str).joints["j"]
    assert (read.lower, read.upper, read.effort, read.velocity) == expected


def test_names_beyond_ascii_and_comments(world):
    model = spawned(
        world,
        f'<!-- hé --><link name="Rad &amp; Träger"><!-- x -->{BODY}</link>'
        f"<link name=\"车轮 '1'\">{BODY}</link>"
        + joint("continuous", "Rad &amp; Träger", "车轮 '1'", name="Gelenk ü"),
    )
    assert model.link_names == ("Rad & Träger", "车轮 '1'")
    assert model.joints.names == ("Gelenk ü",) or list(model.joints.names) == ["Gelenk ü"]
    assert model.link_state("车轮 '1'")[0].position[2] < 1


def test_tags_that_mean_nothing_are_quiet():
    text = robot(
        '<link name="a"/><link name="b"/>'
        + joint(
            "revolute",
            "a",
            "b",
            (
                '<safety_controller k_velocity="1"/><calibration rising="0"/>'
                '<limit lower="-1" upper="1" effort="1" velocity="1"/>'
            ),
        )
    )
    assert parse_urdf(text, str).warnings == []


def test_origin_without_parts():
    text = robot('<link name="a"/><link name="b"/>' + joint("fixed", "a", "b", "<origin/>"))
    assert parse_urdf(text, str).joints["j"].origin == Pose()


@pytest.mark.parametrize("scale", ["0 1 1", "0 0 0"])
def test_mesh_of_no_size_is_left_out(tmp_path, scale):
    (tmp_path / "m.stl").write_bytes(b"")
    text = robot(
        f'<link name="a"><visual><geometry><mesh filename="{tmp_path}/m.stl" '
        f'scale="{scale}"/></geometry></visual></link>'
    )
    model = parse_urdf(text, str)
    assert model.links["a"].visuals == [] and "scale" in model.warnings[0]


def self_colliding(flag):
    """An arm of three boxes whose ends overlap."""
    ends = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial>'
    return (
        f'<link name="a">{BODY}</link><link name="b">{ends}</link><link name="c">{BODY}</link>'
        + joint("prismatic", "a", "b", '<axis xyz="1 0 0"/>')
        + joint("prismatic", "b", "c", '<origin xyz="0.1 0 0"/><axis xyz="1 0 0"/>', "k")
        + "".join(
            f'<gazebo reference="{link}"><selfCollide>{flag}</selfCollide></gazebo>'
            for link in "ac"
        )
    )


@pytest.mark.parametrize("flag, pushed", [("true", True), ("false", False)])
def test_self_collision(world, flag, pushed):
    model = spawned(world, self_colliding(flag))
    apart = np.subtract(model.link_state("c")[0].position, model.link_state("a")[0].position)
    assert (abs(apart[0] - 0.1) > 0.01) == pushed


def arch(tmp_path):
    """A URDF body with an arch in its front, in which a wheel on a kingpin stands free."""
    corners, faces = [], []
    for low, high in (((-1, -1, 0), (0, 1, 1)), ((0, -1, 0.9), (1, 1, 1))):
        box = trimesh.creation.box(bounds=(low, high))
        faces += [[len(corners) + i + 1 for i in face] for face in box.faces.tolist()]
        corners += box.vertices.tolist()
    (tmp_path / "body.obj").write_text(
        "".join("v {} {} {}\n".format(*corner) for corner in corners)
        + "".join("f {} {} {}\n".format(*face) for face in faces)
    )
    hub = '<inertial><mass value="1"/><inertia ixx="0.1" iyy="0.1" izz="0.1"/></inertial>'
    body = hub + (
        f'<collision><geometry><mesh filename="{tmp_path}/body.obj"/></geometry></collision>'
    )
    return (
        f'<link name="body">{body}</link><link name="pin">{hub}</link>'
        + f'<link name="wheel">{BODY}</link>'
        + joint("revolute", "body", "pin", '<origin xyz="0.5 0 0.4"/><axis xyz="0 0 1"/>')
        + joint("continuous", "pin", "wheel", '<axis xyz="0 1 0"/>', "axle")
        + "<gazebo><self_collide>true</self_collide></gazebo>"
    )


def test_a_wheel_in_the_hull_of_a_self_colliding_body_stays_where_it_is(world, tmp_path):
    """Gazebo collides meshes as they are: there the wheel touches nothing."""
    world.engine.set_gravity((0.0, 0.0, 0.0))
    model = spawned(world, arch(tmp_path))
    assert max(abs(s[1]) for s in model.body.joint_states()) < 1e-6
    (warning,) = (w for w in model.description.warnings if "convex hulls" in w)
    assert "'body'" in warning and "'wheel'" in warning


@pytest.mark.parametrize(
    "moments, solver, loaded",
    [
        ((0.14, 0.14, 1.4), "bullet", 1.4),
        ((1.4, 0.14, 0.14), "bullet", 0.7),
        ((0.2, 0.3, 0.4), "bullet", 0.4),
        ((0.14, 0.14, 1.4), "ode", 1.4),
        ((1.4, 0.14, 0.14), "ode", 0.14),
        ((0.2, 0.3, 0.4), "ode", 0.4),
    ],
)
def test_an_inertia_that_no_rigid_body_has(moments, solver, loaded):
    """A torque of 1 N m accelerates the link by 1 / I. Gazebo takes the moments as they are;
    PyBullet alone takes 0, so two of them grow."""
    world = World(solver=solver)
    disc = inertial(1, moments)
    model = world.spawn_urdf(
        "r",
        robot(
            f'<link name="world"/><link name="a">{disc}</link>'
            + joint("continuous", "world", "a", '<axis xyz="0 0 1"/>')
        ),
        Pose(),
        str,
    )
    for _ in range(100):
        model.body.motor(model.body.joints[0]).add_effort(1.0)
        world.step()
    velocity = model.body.joint_states()[0][1]
    assert velocity == pytest.approx(0.1 / loaded, rel=0.01)
    world.close()
