"""Friction of pairs against closed forms: a box on an incline, the smaller coefficient, fdir1."""

import math

import pytest
from bullet_sim.pose import Pose
from contact_scenes import expected_slide, friction, sdf_box, slid, world_of


@pytest.mark.parametrize("along", ["x", "y"])
@pytest.mark.parametrize(
    "box_mu, ground_mu, mu",
    [
        (0.5, 100.0, 0.5),
        (0.5, 1.0, 0.5),
        (0.5, 0.3, 0.3),
        (1.0, 0.3, 0.3),
        (100.0, 1.0, 1.0),
        (0.3, 0.3, 0.3),
        (0.0, 1.0, 0.0),
    ],
)
def test_a_box_slides_beyond_the_smaller_coefficient(box_mu, ground_mu, mu, along):
    if mu:
        assert slid(friction(box_mu), ground_mu, 0.97 * mu, along) < 0.002
    assert slid(friction(box_mu), ground_mu, 1.03 * mu + 0.01, along) > 0.5 * expected_slide(
        mu, 1.03 * mu + 0.01
    )
    for slope in (1.5 * mu + 0.1, 2.5 * mu + 0.1):
        assert slid(friction(box_mu), ground_mu, slope, along) == pytest.approx(
            expected_slide(mu, slope), rel=0.03
        )


@pytest.mark.parametrize(
    "surface, yaw, along, mu",
    [
        (friction(0.8, 0.3, "1 0 0"), 0.0, "x", 0.8),
        (friction(0.8, 0.3, "1 0 0"), 0.0, "y", 0.3),
        (friction(0.8, 0.3, "0 1 0"), 0.0, "x", 0.3),
        (friction(0.8, 0.3, "0 1 0"), 0.0, "y", 0.8),
        (friction(0.8, 0.3, "1 0 0"), math.pi / 2, "x", 0.3),
        (friction(0.8, 0.3, "1 0 0"), math.pi / 2, "y", 0.8),
        # none given: what ODE derives from an upward normal, across the world's x
        (friction(0.8, 0.3), 0.0, "y", 0.8),
        (friction(0.8, 0.3), 0.0, "x", 0.3),
        (friction(0.8, 0.3), math.pi / 2, "y", 0.8),
    ],
)
def test_two_directions(surface, yaw, along, mu):
    assert slid(surface, 100.0, 0.97 * mu, along, yaw) < 0.002
    slope = 1.3 * mu
    assert slid(surface, 100.0, slope, along, yaw) == pytest.approx(
        expected_slide(mu, slope), rel=0.03
    )


def test_what_stands_on_two_grounds_in_turn_has_the_friction_of_each():
    """A box slides from a floor of 0.1 onto a slab of 0.6 and stops there."""
    slab = sdf_box("slab", (4.0, 4.0, 0.1), surface=friction(0.6), static=True)
    box = sdf_box("box", (0.2, 0.2, 0.1), surface=friction(0.9))
    world = world_of((slab, Pose((3.0, 0.0, -0.05))), (box, Pose((0.5, 0.0, 0.05))))
    slick = sdf_box("slick", (2.0, 4.0, 0.1), surface=friction(0.1), static=True)
    world.spawn(slick, Pose((0.0, 0.0, -0.05)))
    world.models["box"].set_state(Pose((-0.5, 0.0, 0.05)), (3.0, 0.0, 0.0))
    world.step(5000)
    x = world.models["box"].pose.position[0]
    world.close()
    # 1.5 m at 0.1 g, then v^2 / (2 0.6 g); the box is between both for its own length
    rest = (9.0 - 2 * 0.1 * 9.81 * 1.5) / (2 * 0.6 * 9.81)
    assert x == pytest.approx(1.0 + rest, abs=0.08)
