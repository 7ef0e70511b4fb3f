"""Properties changed at run time act, survive a reset, and refuse what is impossible."""

import math

import numpy as np
import pybullet
import pytest
from bullet_sim.errors import ModelError
from bullet_sim.models import changes
from bullet_sim.models.changes import step_range
from bullet_sim.pose import Pose
from bullet_sim.world import World
from driving import drive_velocities
from urdf_texts import joint, link, robot

URDF = robot(
    link("base", 100, 100), link("plate", 100, 100, center="1 0 0"),
    joint("weld", "fixed", "base", "plate"),
    link("arm", 1, (0.1, 0.2, 0.3)).replace('ixy="0"', 'ixy="0.01"'),
    joint("hinge", "revolute", "base", "arm", axis="0 0 1",
          more='<limit lower="-1" upper="1" effort="99" velocity="50"/>'),
    link("wheel"), joint("axle", "continuous", "base", "wheel", axis="0 0 1"),
)  # fmt: skip
ARM = np.array([[0.1, 0.01, 0], [0.01, 0.2, 0], [0, 0, 0.3]])


@pytest.fixture(name="world", params=["ode", "bullet"])
def _world(request):
    world = World(gravity=(0.0, 0.0, 0.0), solver=request.param)
    world.spawn_urdf("r", URDF, Pose(), str)
    yield world
    world.close()


@pytest.fixture(name="model")
def _model(world):
    return world.model("r")


def speed_after_push(world, model, joint, effort=0.3, seconds=0.1):
    """Speed of a joint after an effort from rest."""
    world.forces.apply_effort(
        model, joint, effort, step_range(world.step_count, 0.001, 0.0, seconds)
    )
    world.step(round(seconds / 0.001))
    return model.joints.arrays()[1][model.joints.names.index(joint)]


def test_link_properties(model):
    mass, center, inertia, gravity = changes.link_properties(model, "arm")
    assert (mass, tuple(center), gravity) == (1.0, (0, 0, 0), True)
    np.testing.assert_allclose(inertia, ARM)
    mass, center, inertia, _ = changes.link_properties(model, "base")  # with the plate
    assert (mass, tuple(center)) == (200.0, (0.5, 0, 0))
    np.testing.assert_allclose(np.diag(inertia), (200, 250, 250))
    assert changes.link_properties(model, "plate")[0] == 100.0
    with pytest.raises(ModelError, match="no link 'nose'"):
        changes.link_properties(model, "nose")


def test_a_mass_for_a_fixed_base_does_not_release_it(world):
    text = robot(
        '<link name="world"/>', link("base", 1, 1), link("arm", 1, 1),
        joint("weld", "fixed", "world", "base"), joint("hinge", "continuous", "base", "arm"),
    )  # fmt: skip
    model = world.spawn_urdf("held", text, Pose((0, 0, 5)), str)
    root = next(iter(model.rigid_parts))
    _, center, inertia, _ = changes.link_properties(model, root)
    changes.set_link_properties(model, root, 2.0, center, inertia, True)
    world.engine.set_gravity((0.0, 0.0, -9.81))
    world.step(200)
    assert changes.link_properties(model, root)[0] == 2.0
    assert model.link_state("base")[0].position == pytest.approx((0, 0, 5), abs=1e-9)


def test_a_new_inertia_counts_and_survives_a_reset(world, model):
    before = speed_after_push(world, model, "hinge")
    world.reset()
    changes.set_link_properties(model, "arm", 2.0, (0, 0, 0), 2 * ARM, True)
    assert changes.link_properties(model, "arm")[0] == 2.0
    half = speed_after_push(world, model, "hinge")
    world.reset()
    again = speed_after_push(world, model, "hinge")
    assert before == pytest.approx(0.3 * 0.1 / 0.3, rel=0.01)
    assert half == pytest.approx(before / 2, rel=0.01) and again == half


def test_gravity_is_switched_off_and_on_and_survives_a_reset(world):
    ball = world.spawn_urdf("b", robot(link("ball", 2, 1)), Pose((0, 9, 5)), str)
    world.engine.set_gravity((0.0, 0.0, -9.81))

    def fall():
        world.step(100)
        return ball.link_state("ball")[1][2]

    for is_on, wanted in ((False, 0.0), (True, -0.981)):
        changes.set_link_properties(ball, "ball", 2.0, (0, 0, 0), np.eye(3), is_on)
        assert changes.link_properties(ball, "ball")[3] is is_on
        for _ in range(2):
            world.reset()
            assert fall() == pytest.approx(wanted, abs=1e-6)


@pytest.mark.parametrize(
    "link, mass, center, inertia, gravity, reason",
    [
        ("arm", 0.0, (0, 0, 0), ARM, True, "mass is 0.0"),
        ("arm", math.nan, (0, 0, 0), ARM, True, "mass is nan"),
        ("arm", 1.0, (math.nan, 0, 0), ARM, True, "must be finite"),
        ("arm", 1.0, (0, 0, 0), -ARM, True, "not positive definite"),
        ("plate", 1.0, (0, 0, 0), ARM, True, "merged"),
        ("nose", 1.0, (0, 0, 0), ARM, True, "no link 'nose'"),
    ],
)
def test_impossible_masses_change_nothing(model, link, mass, center, inertia, gravity, reason):
    with pytest.raises(ModelError, match=reason):
        changes.set_link_properties(model, link, mass, center, inertia, gravity)
    assert changes.link_properties(model, "arm")[0] == 1.0


def test_a_center_of_mass_is_told_and_does_not_move(world, model):
    changes.set_link_properties(model, "arm", 1.0, (0.1, 0, 0), ARM, True)
    assert tuple(changes.link_properties(model, "arm")[1]) == (0.1, 0, 0)
    speed = speed_after_push(world, model, "hinge")
    assert speed == pytest.approx(0.3 * 0.1 / 0.3, rel=0.01), "about the center of before"


def test_an_inertia_with_other_axes_counts_where_the_solver_is_ode(world, model):
    other = np.array([[0.3, 0.0, 0.1], [0.0, 0.4, 0.0], [0.1, 0.0, 0.6]])
    if world.engine.settings is None:
        with pytest.raises(ModelError, match="other principal axes"):
            changes.set_link_properties(model, "arm", 1.0, (0, 0, 0), other, True)
        return
    changes.set_link_properties(model, "arm", 1.0, (0, 0, 0), other, True)
    np.testing.assert_array_equal(changes.link_properties(model, "arm")[2], other)
    assert speed_after_push(world, model, "hinge") == pytest.approx(0.3 * 0.1 / 0.6, rel=0.02)


def test_parameters_of_joints_that_ode_alone_has(world, model):
    def pushed(name):
        return speed_after_push(world, model, name, effort=0.3, seconds=0.2)

    if world.engine.settings is None:
        assert not changes.set_joint_parameter(model, "axle", "fmax", 0.2)
        return
    free = pushed("axle")
    world.reset()
    for _ in range(2):
        assert changes.set_joint_parameter(model, "axle", "fmax", 0.2)
        assert pushed("axle") == pytest.approx(free / 3.0, rel=0.01), "0.1 of 0.3 N m are left"
        world.reset()
    changes.set_joint_parameter(model, "axle", "vel", 1.5)
    world.step(2000)
    assert model.joints.arrays()[1][1] == pytest.approx(1.5, rel=0.01)
    with pytest.raises(ModelError, match="fmax is nan, must be finite"):
        changes.set_joint_parameter(model, "axle", "fmax", math.nan)


def test_stops(world, model):
    changes.set_joint_stops(model, "hinge", upper=0.2)
    world.forces.apply_effort(model, "hinge", 0.3, (0, math.inf))
    world.step(3000)
    assert model.joints.arrays()[0][0] == pytest.approx(0.2, abs=0.01)
    model.joints.set_positions({"hinge": 0.9})
    assert model.joints.arrays()[0][0] == pytest.approx(0.2, abs=1e-6)
    with pytest.raises(ModelError, match="nan"):
        changes.set_joint_stops(model, "hinge", math.nan)
    if world.engine.settings is None:
        with pytest.raises(ModelError, match="0.5 and 0.2"):
            changes.set_joint_stops(model, "hinge", 0.5)
        with pytest.raises(ModelError, match="'axle' of 'r' is continuous"):
            changes.set_joint_stops(model, "axle", -1, 1)
        return
    changes.set_joint_stops(model, "axle", upper=0.5)
    world.forces.apply_effort(model, "axle", 0.3, (0, math.inf))
    world.step(3000)
    assert model.joints.arrays()[0][1] == pytest.approx(0.5, abs=0.01)
    changes.set_joint_stops(model, "axle", lower=1.0, upper=-1.0)  # none, as in Gazebo
    world.step(3000)
    assert model.joints.arrays()[0][1] > 1.5


def test_damping_slows_to_the_ratio_of_effort_and_damping(world, model):
    changes.set_joint_damping(model, "axle", 0.5)
    assert speed_after_push(world, model, "axle", 1.0, 3.0) == pytest.approx(2.0, rel=0.02)
    with pytest.raises(ModelError, match="damping is -1"):
        changes.set_joint_damping(model, "axle", -1)
    with pytest.raises(ModelError, match="joint 'weld' does not exist or does not move"):
        changes.set_joint_damping(model, "weld", 1)


def test_placing_some_joints_leaves_the_others(world, model):
    speed = speed_after_push(world, model, "axle")
    model.joints.set_positions({"hinge": 0.5})
    positions, speeds, _ = model.joints.arrays()
    assert positions[0] == pytest.approx(0.5) and speeds[1] == speed
    with pytest.raises(ModelError, match="position of joint 'hinge' is nan"):
        model.joints.set_positions({"axle": 1.0, "hinge": math.nan})
    assert model.joints.arrays()[0][1] == positions[1]


def test_an_effort_keeps_its_time_when_the_time_step_changes(world, model):
    world.forces.apply_effort(model, "axle", 0.1, step_range(0, 0.001, 0.1, 0.2))
    world.step(200)
    world.set_time_step(0.002)
    world.step(20)
    half = model.joints.arrays()[1][1]
    assert half == pytest.approx(0.1 * 0.14 / 0.1, rel=0.02)
    world.step(80)
    assert not world.forces.active
    assert model.joints.arrays()[1][1] == pytest.approx(0.1 * 0.2 / 0.1, rel=0.02)
    world.forces.apply_effort(model, "axle", 0.1, (world.step_count, math.inf))
    world.set_time_step(0.001)
    world.step(100)
    assert world.forces.active
    assert model.joints.arrays()[1][1] == pytest.approx(0.1 * 0.3 / 0.1, rel=0.02)


@pytest.mark.parametrize("solver", ["bullet", "ode"])
def test_the_time_step_changes_while_a_controlled_joint_turns(solver):
    """Simulated time goes on to a multiple of the new step; the joint keeps its speed."""
    world = World(solver=solver)
    plugin = '<gazebo><plugin name="c" filename="libgazebo_ros_control.so"/></gazebo></robot>'
    car = world.spawn_urdf("car", URDF.replace("</robot>", plugin), Pose(), str)
    drive_velocities(car.joints, ("axle",), (2.0,))
    world.step(501)
    before = car.joints.positions_of(("axle",))[0]
    world.set_time_step(0.002)
    assert world.time == pytest.approx(0.502)
    world.step(250)
    turned = car.joints.positions_of(("axle",))[0] - before
    assert turned == pytest.approx(1.0, rel=0.01)
    world.close()


def test_what_never_moves_is_none_of_pybullets_multibodies(world):
    """Each of these takes 0.3 us or more of every step, a static body a fifth of that."""
    box = '<collision name="c"><geometry><box><size>1 1 1</size></box></geometry></collision>'
    for name, static in (("wall", True), ("crate", False)):
        world.spawn_sdf(
            name,
            f'<sdf version="1.6"><model name="{name}"><static>{str(static).lower()}</static>'
            f'<link name="l">{box}</link></model></sdf>',
            Pose((5, 0, 0 if static else 3)),
            str,
        )
    # PyBullet has a name for the root link of multibodies alone
    client = getattr(world.engine, "mirror", world.engine).client
    roots = {
        name: pybullet.getBodyInfo(client.bodies[world.model(name).body.number].uid, client.number)
        for name in ("wall", "crate", "r")
    }
    assert {name: info[0] for name, info in roots.items()} == {
        "wall": b"", "crate": b"l", "r": b"base"
    }  # fmt: skip
