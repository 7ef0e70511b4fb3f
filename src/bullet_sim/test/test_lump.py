"""Links on fixed joints become part of their parent."""

import math

import numpy as np
import pytest
from bullet_sim.description.lump import MIN_MASS, as_printed, lump
from bullet_sim.description.model import Geometry, Joint, Link, ModelDescription, Shape
from bullet_sim.pose import Pose


def box_link(name, mass, size):
    """A solid box, centered on its link frame."""
    x, y, z = np.square(size)
    return Link(name, mass, inertia=mass / 12 * np.diag([y + z, x + z, x + y]))


def model_of(links, joints, **others):
    """A description from parts; the first link is the root."""
    return ModelDescription(
        "m",
        {link.name: link for link in links},
        {joint.name: joint for joint in joints},
        root=links[0].name,
        **others,
    )


def test_two_halves_make_the_whole_box():
    halves = [box_link("left", 3.0, (1.0, 0.5, 0.2)), box_link("right", 3.0, (1.0, 0.5, 0.2))]
    lumped = lump(model_of(halves, [Joint("j", "fixed", "left", "right", Pose((1.0, 0, 0)))]))
    whole = box_link("whole", 6.0, (2.0, 0.5, 0.2))
    assert list(lumped.links) == ["left"] and lumped.joints == ()
    link = lumped.links["left"]
    assert link.mass == 6.0
    np.testing.assert_allclose(link.center, [0.5, 0, 0], atol=1e-15)
    np.testing.assert_allclose(link.inertia, whole.inertia, rtol=1e-12)


def test_turned_and_shifted_box_against_the_parallel_axis_theorem():
    first, second = box_link("a", 2.0, (0.4, 0.2, 0.1)), box_link("b", 1.0, (0.3, 0.1, 0.2))
    origin = Pose.from_xyz_rpy((0.3, 0.6, -0.9), (0, 0, math.pi / 2))
    link = lump(model_of([first, second], [Joint("j", "fixed", "a", "b", origin)])).links["a"]
    np.testing.assert_allclose(link.center, [0.1, 0.2, -0.3], atol=1e-15)
    # About the common center: arms (-0.1, -0.2, 0.3) and (0.2, 0.4, -0.6); reduced mass 2/3.
    x, y, z = 0.3, 0.6, -0.9
    apart = (
        2
        / 3
        * np.array(
            [
                [y * y + z * z, -x * y, -x * z],
                [-x * y, x * x + z * z, -y * z],
                [-x * z, -y * z, x * x + y * y],
            ]
        )
    )
    turned = np.diag(second.inertia.diagonal()[[1, 0, 2]])
    np.testing.assert_allclose(link.inertia, first.inertia + turned + apart, atol=1e-12)


def test_description_stays_as_it_is():
    model = model_of(
        [box_link("a", 2.0, (1, 1, 1)), box_link("b", 1.0, (1, 1, 1))],
        [Joint("j", "fixed", "a", "b", Pose((1, 0, 0)))],
    )
    lump(model)
    assert model.links["a"].mass == 2.0 and not model.links["a"].center.any()


def test_frames_of_lumped_links():
    links = [box_link(name, 1.0, (1, 1, 1)) for name in ("base", "arm", "mount", "camera")]
    mount = Pose.from_xyz_rpy((0, 0, 0.5), (0, 0, math.pi / 2))
    joints = [
        Joint("mount", "fixed", "arm", "mount", mount),
        Joint("turn", "continuous", "base", "arm", Pose((1, 0, 0))),
        Joint("camera", "fixed", "mount", "camera", Pose((0.2, 0, 0))),
    ]
    lumped = lump(model_of(links, joints))
    assert list(lumped.links) == ["base", "arm"]
    assert [joint.name for joint in lumped.joints] == ["turn"]
    assert lumped.frames["base"] == ("base", Pose()) and lumped.frames["arm"] == ("arm", Pose())
    link, pose = lumped.frames["camera"]
    assert link == "arm"
    np.testing.assert_allclose(pose.position, [0, 0.2, 0.5], atol=1e-12)
    np.testing.assert_allclose(pose.rpy, [0, 0, math.pi / 2], atol=1e-12)


def test_joint_below_a_fixed_one_moves_to_the_link_in_body():
    links = [box_link(name, 1.0, (1, 1, 1)) for name in ("base", "axle", "wheel")]
    joints = [
        Joint("fix", "fixed", "base", "axle", Pose((0, 1, 0))),
        Joint("spin", "continuous", "axle", "wheel", Pose((0, 0, 2))),
    ]
    (spin,) = lump(model_of(links, joints)).joints
    assert (spin.parent, spin.origin.position) == ("base", (0, 1, 2))


def test_static_model_becomes_one_link():
    joints = [Joint("j", "revolute", "a", "b", Pose((1, 0, 0)))]
    lumped = lump(model_of([Link("a"), Link("b")], joints, static=True))
    assert list(lumped.links) == ["a"] and lumped.frames["b"] == ("a", Pose((1, 0, 0)))


def test_moving_link_without_mass_gets_a_little_and_says_so():
    model = model_of(
        [box_link("a", 1.0, (1, 1, 1)), Link("b")], [Joint("j", "continuous", "a", "b")]
    )
    link = lump(model).links["b"]
    assert link.mass == MIN_MASS and np.linalg.eigvalsh(link.inertia)[0] > 0
    assert any("'b'" in warning and "mass" in warning for warning in model.warnings)


@pytest.mark.parametrize("inertia", [np.zeros((3, 3)), np.full((3, 3), math.nan), -np.eye(3)])
def test_an_impossible_inertia_becomes_that_of_a_block_of_its_size(inertia):
    link = Link("body", 2.0, inertia=inertia)
    turned = Pose((0.0, 0.0, 0.0), (0.0, 0.0, 0.5**0.5, 0.5**0.5))
    link.collisions.append(Shape(Geometry("box", (0.5, 1.0, 0.2)), turned))
    model = model_of([link], [])
    whole = box_link("whole", 2.0, (1.0, 0.5, 0.2))
    np.testing.assert_allclose(lump(model).links["body"].inertia, whole.inertia, rtol=1e-12)
    assert len(model.warnings) == 1 and "a block of its size" in model.warnings[0]


@pytest.mark.parametrize(
    "inertia, unit",
    [
        (np.zeros((3, 3)), True),  # dInvertPDMatrix fails, as Gazebo 11.1 shows
        (0.01 * (np.eye(3) + [[0, 1, 0], [1, 0, 1], [0, 1, 0]]), True),
        (0.01 * np.eye(3), False),
        (np.full((3, 3), math.nan), False),
    ],
    ids=["none", "not positive definite", "possible", "no number"],
)
def test_an_inertia_that_is_not_positive_definite_is_one_for_the_solver_ode(inertia, unit):
    """A rosbot of Husarion has the second one: in Gazebo it turns as with 1 kg m^2."""
    link = Link("body", 2.0, inertia=inertia)
    link.collisions.append(Shape(Geometry("box", (0.5, 1.0, 0.2))))
    model = model_of([link], [])
    found = lump(model, as_in_gazebo=True).links["body"].inertia
    assert (found == np.eye(3)).all() == unit
    assert any("like 1 kg m^2 about each axis" in text for text in model.warnings) == unit


def test_link_without_mass_on_a_fixed_joint_needs_none():
    model = model_of(
        [box_link("a", 1.0, (1, 1, 1)), Link("b")], [Joint("j", "fixed", "a", "b", Pose((5, 0, 0)))]
    )
    assert lump(model).links["a"].mass == pytest.approx(1.0)
    assert model.warnings == []


@pytest.mark.parametrize(
    "written, read",
    [  # as `gz sdf -p` prints them: urdfdom_headers takes a pitch within 0.26 degrees of 90 as 90,
        # ignition-math prints a yaw of 0 there
        ((0.0, 1.5707, 1.5707), (-1.5707, 1.5708, 0.0)),
        ((0.3, 1.57, 0.0), (0.300235, 1.5708, 0.0)),
        ((0.0, -1.568, 0.2), (0.2, -1.5708, 0.0)),
        ((0.0, 1.56, 0.2), (0.0, 1.56, 0.2)),
        ((1.5707, 0.0, 0.123456789), (1.5707, 0.0, 0.123457)),
    ],
)
def test_shapes_turn_as_sdformat_prints_them(written, read):
    pose = Pose.from_xyz_rpy((0, 0, 0), written)
    shape = Shape(Geometry("cylinder", (0.1, 0.04)), pose)
    link = Link("wheel", 1.0, inertia=np.eye(3), collisions=[shape])
    found = as_printed(lump(model_of([link], []))).links["wheel"].collisions[0].pose
    np.testing.assert_allclose(
        found.matrix, Pose.from_xyz_rpy((0, 0, 0), read).matrix, rtol=0, atol=1e-12
    )


@pytest.mark.parametrize("pitch", [math.pi / 2, -math.pi / 2, 1.5707, 1.57079632, -0.4])
@pytest.mark.parametrize("roll", [-3.0, -0.5, 0.0, 1.0, math.pi / 2])
@pytest.mark.parametrize("yaw", [-2.5, 0.0, 0.7, math.pi])
def test_angles_of_an_orientation_give_it_again_also_straight_up_and_down(roll, pitch, yaw):
    pose = Pose.from_xyz_rpy((0, 0, 0), (roll, pitch, yaw))
    again = Pose.from_xyz_rpy((0, 0, 0), pose.rpy)
    np.testing.assert_allclose(again.matrix, pose.matrix, rtol=0, atol=1e-14)
    assert all(-math.pi <= angle <= math.pi for angle in pose.rpy)
    if abs(pitch) < 1.5:
        for found, wanted in zip(pose.rpy, (roll, pitch, yaw)):
            assert math.remainder(found - wanted, math.tau) == pytest.approx(0.0, abs=1e-12)
