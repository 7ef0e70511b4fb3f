"""SDF joints of several axes: universal, revolute2, ball, as chains of hinges."""

import numpy as np
import pytest
from bullet_sim.kinematics import Kinematics
from bullet_sim.pose import Pose
from bullet_sim.world import World

LINK = (
    '<link name="{0}"><pose>{1}</pose><inertial><mass>1</mass><inertia><ixx>0.02</ixx><iyy>0.02'
    "</iyy><izz>0.02</izz></inertia></inertial></link>"
)
SDF = (
    '<sdf version="1.6"><model name="m">'
    + LINK.format("base", "0 0 2 0 0 0")
    + LINK.format("arm", "0 0 1.5 0 0 0")
    + '<joint name="held" type="fixed"><parent>world</parent><child>base</child></joint>'
    '<joint name="j" type="{0}"><parent>base</parent><child>arm</child><pose>0 0 0.5 0 0 0</pose>'
    "{1}</joint></model></sdf>"
)
AXES = "<axis><xyz>1 0 0</xyz>{}</axis><axis2><xyz>0 1 0</xyz></axis2>"
HINGE = (
    '<joint name="h" type="revolute"><parent>base</parent><child>arm</child><axis><xyz>0 1 0</xyz>'
    "</axis></joint>"
)
STOPS = "<limit><lower>-0.2</lower><upper>0.2</upper></limit>"


def _model(kind, axes=""):
    world = World()
    return world, world.spawn_sdf("m", SDF.format(kind, axes), Pose(), str)


@pytest.mark.parametrize(
    "kind, axes, joints",
    [
        ("universal", AXES.format(""), ("j", "j__2")),
        ("revolute2", AXES.format(""), ("j", "j__2")),
        ("ball", "", ("j", "j__2", "j__3")),
    ],
)
def test_a_pendulum_swings_about_each_axis_and_stays_at_its_joint(kind, axes, joints):
    """It hangs 0.5 m below the joint: 1 kg, so T = 2 pi sqrt((0.02 + 0.25) / (9.81 * 0.5))."""
    world, model = _model(kind, axes)
    assert model.joints.names == joints and not model.description.warnings
    assert model.link_state("arm")[0].position == pytest.approx((0.0, 0.0, 1.5), abs=1e-6)
    model.joints.set_positions({joints[0]: 0.1, joints[1]: 0.15})
    half = np.pi * np.sqrt(0.27 / (9.81 * 0.5))
    world.step(round(half / 0.001))
    pose = model.link_state("arm")[0]
    assert model.joints.positions_of(joints[:2]) == pytest.approx((-0.1, -0.15), abs=0.02)
    at_joint = np.asarray(pose.position) + pose.matrix @ np.array((0.0, 0.0, 0.5))
    assert at_joint == pytest.approx((0.0, 0.0, 2.0), abs=1e-3)
    world.close()


def test_the_limits_are_those_of_their_axis():
    world, model = _model("universal", AXES.format(STOPS))
    limits = [model.joints.limits[name].upper for name in ("j", "j__2")]
    assert limits == [0.2, None]
    world.close()


MOVED = "<axis><xyz>0 0 1</xyz></axis><thread_pitch>{}</thread_pitch>"


@pytest.mark.parametrize("pitch", [20.0, 0.5, -4.0])
def test_a_screw_moves_along_its_axis_as_it_turns(pitch):
    """It falls, so it turns: minus `pitch` rad for each metre, as in Gazebo 11."""
    world, model = _model("screw", MOVED.format(pitch))
    world.step(300)
    angle = model.joints.arrays()[0][0]
    fallen = 1.5 - model.link_state("arm")[0].position[2]
    assert model.joints.names == ("j",) and fallen > 0.02
    assert angle == pytest.approx(pitch * fallen, rel=1e-3)
    state, source = world.snapshot().bodies[0], world.sources()[0]
    mirror = Kinematics({source.key: source.links})
    mirror.apply(world.snapshot())
    assert mirror.poses[:, 2, 3].max() == pytest.approx(1.5 - fallen + 0.5, abs=1e-6)
    assert len(state.joints) == 2
    model.joints.set_positions({"j": 0.5})
    assert model.link_state("arm")[0].position[2] == pytest.approx(1.5 - 0.5 / pitch, abs=1e-6)
    world.close()


@pytest.mark.parametrize("kind", ["screw", "gearbox"])
def test_with_bullet_others_are_held_or_left_out_with_a_warning(kind):
    axes = AXES.format("") + "<gearbox_reference_body>base</gearbox_reference_body>"
    text = SDF.format(kind, axes)
    if kind == "gearbox":
        text = text.replace("</model>", HINGE + "</model>")
    world = World(solver="bullet")
    model = world.spawn_sdf("m", text, Pose(), str)
    assert model.joints.names == (("h",) if kind == "gearbox" else ())
    assert "joint 'j' of 'm' is a screw or a gearbox" in model.description.warnings[0]
    world.close()
