"""Fixed joints of a URDF that <preserveFixedJoint> and <disableFixedJointLumping> keep."""

import numpy as np
import pytest
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.pose import Pose
from urdf_texts import inertial

MASS = inertial()
SENSOR = (
    '<gazebo><plugin name="p" filename="libgazebo_ros_p3d.so"><bodyName>b</bodyName>'
    "<topicName>t</topicName></plugin></gazebo>"
    '<gazebo reference="b"><turnGravityOff>true</turnGravityOff></gazebo>'
)
FIXED = "<preserveFixedJoint>true</preserveFixedJoint>"
HINGE = "<disableFixedJointLumping>true</disableFixedJointLumping>"


def robot(tags, inertial=MASS):
    return (
        f'<robot name="r"><link name="a">{MASS}</link><link name="b">{inertial}</link>'
        f'<link name="c">{MASS}</link><joint name="j" type="fixed"><origin xyz="1 0 0"/>'
        '<parent link="a"/><child link="b"/></joint><joint name="k" type="fixed"><origin '
        'xyz="0 1 0"/><parent link="b"/><child link="c"/></joint>'
        f'{SENSOR}<gazebo reference="j">{tags}</gazebo></robot>'
    )


WORLD = {"gravity": (0.0, 0.0, -9.8)}
SOLVERS = ("ode", "bullet")


@pytest.mark.parametrize(
    "tags, parts, joints",
    [
        ("", ["a"], []),
        (FIXED, ["a", "b"], []),
        (HINGE, ["a", "b"], ["j"]),
        (HINGE + FIXED, ["a", "b"], []),
        (FIXED.replace("true", "false"), ["a"], []),
    ],
)
def test_bodies_and_joints_of_the_model(world, tags, parts, joints):
    model = world.spawn_urdf("r", robot(tags), Pose((0, 0, 1)), str)
    assert list(model.rigid_parts) == parts and list(model.joints.names) == joints
    assert model.description.warnings == []


@pytest.mark.parametrize("tags", ["", FIXED, HINGE])
def test_the_frame_of_a_plugin_is_the_body(tags):
    (spec,) = parse_urdf(robot(tags), str).sensors
    assert spec.child_frame_id == ("b" if tags else "a")


@pytest.mark.parametrize("tags", [FIXED, HINGE])
def test_what_it_holds_stays_where_it_is(world, tags):
    """Gravity acts on the first link alone, half of the weight at one end."""
    model = world.spawn_urdf("r", robot(tags), Pose((0, 0, 50)), str)
    world.step(500)
    ends = [np.array(model.link_state(name)[0].position) for name in "abc"]
    assert ends[0][2] < 49.9
    for one, two in ((0, 1), (1, 2)):
        assert np.linalg.norm(ends[one] - ends[two]) == pytest.approx(1.0, abs=1e-3)


def test_gravity_of_a_kept_link_is_its_own():
    for tags, gravity in (("", (False, False)), (FIXED, (True, False)), (HINGE, (True, False))):
        links = parse_urdf(robot(tags), str).links
        assert (links["a"].gravity, links["b"].gravity) == gravity
        assert links["c"].gravity == links["b"].gravity  # which is merged into it


def test_a_link_without_mass_that_is_kept_is_merged_with_a_warning():
    model = parse_urdf(robot(FIXED, ""), str, "r", "keep")
    (warning,) = model.warnings
    assert model.kept == set() and "'j'" in warning and "no mass" in warning
