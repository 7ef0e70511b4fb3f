"""Wrenches and efforts accelerate bodies as Newton says, for their duration."""

import math

import numpy as np
import pytest
from bullet_sim.description.model import Geometry, Link, ModelDescription, Shape
from bullet_sim.errors import CommandError, ModelError
from bullet_sim.models.changes import step_range
from bullet_sim.pose import Pose
from urdf_texts import joint, link, robot

MASS, MOMENTS = 2.0, (0.02, 0.03, 0.04)
TURNED = Pose.from_xyz_rpy((1, 2, 3), (0.3, -0.4, 1.1))
ARM = robot(
    link("world_part", 1000, 1000), link("arm"),
    joint("axle", "{kind}", "world_part", "arm", axis="0 0 1",
          more='<limit lower="-9" upper="9" effort="{effort}" velocity="1000"/>'),
)  # fmt: skip
WORLD = {"gravity": (0.0, 0.0, 0.0)}
SOLVERS = ("ode", "bullet")


def body(world, pose=TURNED, center=(0.0, 0.0, 0.0)):
    """A free body with three different moments of inertia."""
    link = Link("link", MASS, np.array(center), np.diag(MOMENTS))
    link.collisions.append(Shape(Geometry("box", (0.1, 0.1, 0.1))))
    return world.spawn(ModelDescription("body", {"link": link}, root="link"), pose)


@pytest.mark.parametrize(
    "start, duration, expected",
    [
        (0.0, 0.1, (50, 150)),  # what is past means now
        (0.2, 0.1, (199, 300)),  # also in the step at whose end it begins, as in Gazebo
        (0.199999999, 0.1, (199, 300)),  # cut to whole nanoseconds
        (0.2004, 0.001, (200, 201)),
        (0.0, 0.0001, (50, 50)),  # shorter than a step: nothing
        (0.0, 0.0, (50, 50)),  # nothing
        (0.0, -1.0, (50, math.inf)),
        (0.3, -1.0, (299, math.inf)),
    ],
)
def test_span(start, duration, expected):
    assert step_range(50, 0.001, start, duration) == expected


@pytest.mark.parametrize("start, duration", [(math.nan, 1.0), (0.0, math.inf), (0.0, math.nan)])
def test_span_of_what_is_no_time(start, duration):
    with pytest.raises(CommandError, match="must be finite"):
        step_range(0, 0.001, start, duration)


def test_impulse_of_a_force_is_force_times_duration(world):
    model = body(world, center=(0.05, 0.0, 0.0))
    world.forces.apply_wrench(
        model, "link", (3.0, -1.0, 2.0), (0, 0, 0), step_range(0, 0.001, 0.0, 0.1)
    )
    world.step(50)
    _, linear, angular = model.link_state("link")
    np.testing.assert_allclose(linear, np.array((3.0, -1.0, 2.0)) * 0.05 / MASS, rtol=1e-6)
    np.testing.assert_allclose(angular, 0.0, atol=1e-9)  # at the center of mass
    world.step(200)
    np.testing.assert_allclose(
        model.link_state("link")[1], np.array((3.0, -1.0, 2.0)) * 0.1 / MASS, rtol=1e-6
    )
    assert not world.forces.active


def test_torque_along_world_axes_turns_by_the_inertia(world):
    model, torque = body(world), np.array((0.01, 0.02, -0.03))
    world.forces.apply_wrench(model, "link", (0, 0, 0), torque, step_range(0, 0.001, 0.0, 0.001))
    world.step(3)
    inertia = TURNED.matrix @ np.diag(MOMENTS) @ TURNED.matrix.T
    np.testing.assert_allclose(
        model.link_state("link")[2], np.linalg.solve(inertia, torque) * 0.001, rtol=1e-3
    )


def test_the_last_wrench_on_a_link_counts_begins_late_and_ends_when_cleared(world):
    model = body(world)  # gazebo_ros sets a body's force and torque, so wrenches do not add up
    world.forces.apply_wrench(model, "link", (1, 0, 0), (0, 0, 0), step_range(0, 0.001, 0.0, -1.0))
    world.forces.apply_wrench(model, "link", (0, 3, 0), (0, 0, 0), step_range(0, 0.001, 0.1, -1.0))
    world.step(200)
    assert model.link_state("link")[1] == pytest.approx((0.099 / MASS, 0.303 / MASS, 0.0), abs=1e-9)
    assert world.forces.clear_link("link") == 0, "as in gazebo_ros, which compares MODEL::LINK"
    assert world.forces.clear_link(f"{model.name}::link") == 2
    world.step(100)
    assert model.link_state("link")[1] == pytest.approx((0.099 / MASS, 0.303 / MASS, 0.0), abs=1e-9)


def test_efforts_on_a_joint_add_up(world):
    model = world.spawn_urdf("arm", ARM.format(kind="continuous", effort=0), Pose(), str)
    for _ in range(2):
        world.forces.apply_effort(model, "axle", 0.1, step_range(0, 0.001, 0.0, 0.5))
    world.step(600)
    assert model.joints.arrays()[1][0] == pytest.approx(0.2 * 0.5 / 0.1, rel=1e-3)


def test_efforts_on_joints_of_one_name_are_cleared_together(world):
    for name in ("one", "two"):
        model = world.spawn_urdf(name, ARM.format(kind="continuous", effort=0), Pose(), str)
        world.forces.apply_effort(model, "axle", 0.1, (0, math.inf))
    assert world.forces.clear_joint("two::axle") == 0, "as in gazebo_ros: the plain name counts"
    assert world.forces.clear_joint("axle") == 2 and not world.forces.active


@pytest.mark.parametrize(
    "kind, effort, limit, acting",
    [
        ("revolute", 0.2, 1.0, 0.2),
        ("revolute", 0.2, 0.05, 0.05),
        ("revolute", -0.2, 0.05, -0.05),
        ("revolute", 0.2, 0.0, 0.0),
        ("continuous", 0.2, 0.05, 0.2),
    ],
)
def test_effort_on_a_joint_within_its_limit(world, kind, effort, limit, acting):
    """Joint::CheckAndTruncateForce; sdformat leaves the limits of continuous joints out."""
    model = world.spawn_urdf("arm", ARM.format(kind=kind, effort=limit), Pose(), str)
    world.forces.apply_effort(model, "axle", effort, step_range(0, 0.001, 0.0, 0.5))
    world.step(700)
    assert model.joints.arrays()[1][0] == pytest.approx(acting * 0.5 / 0.1, rel=1e-3)
    assert world.forces.clear_joint("axle") == 0


@pytest.mark.parametrize(
    "call, arguments, reason",
    [
        ("apply_wrench", ("nose", (1, 0, 0), (0, 0, 0)), "no link 'nose'"),
        ("apply_wrench", ("link", (math.nan, 0, 0), (0, 0, 0)), "'link' of 'body' has nan"),
        ("apply_effort", ("nose", 1.0), "joint 'nose' does not exist"),
        ("apply_effort", ("nose", math.inf), "has inf"),
    ],
)
def test_bad_wrenches_are_named(world, call, arguments, reason):
    with pytest.raises((CommandError, ModelError), match=reason):
        getattr(world.forces, call)(body(world), *arguments, (0, math.inf))
    assert not world.forces.active


def test_a_wrench_on_a_static_model_is_taken_and_does_nothing_as_in_gazebo(world):
    wall = world.spawn(ModelDescription("wall", {"w": Link("w")}, root="w", static=True))
    world.forces.apply_wrench(wall, "w", (1, 0, 0), (0, 0, 0), (0, math.inf))
    assert not world.forces.active


def test_deleting_and_resetting_end_what_pushes(world):
    model = body(world)
    for end in (lambda: world.delete("body"), world.reset):
        if "body" not in world.models:
            model = body(world)
        world.forces.apply_wrench(model, "link", (1, 0, 0), (0, 0, 0), (0, math.inf))
        end()
        assert not world.forces.active
        world.step(10)
    assert model.pose.position == pytest.approx(TURNED.position)
