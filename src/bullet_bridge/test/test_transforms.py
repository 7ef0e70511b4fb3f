"""libpaddock_state_publisher: transforms of joints and of the root link."""

import pytest
from bullet_bridge.plugins import transforms
from bullet_sim.formats.sdf import world as sdf
from bullet_sim.plugins.transforms import JointTransformsSpec, RootTransformSpec
from bullet_sim.pose import Pose
from fake_impl import fake_publishers, plugin_of
from urdf_texts import inertial

MASS = inertial(inertia=0.01)
PLUGIN = (
    '<gazebo><plugin name="p" filename="libpaddock_state_publisher.so"><updateRate>20</updateRate>'
    "<frameName>map</frameName></plugin></gazebo>"
)


def arm(kind, plugin=PLUGIN):
    """A slider or hinge, tilted, on a base, with a fixed tip."""
    return (
        f'<robot name="arm"><link name="base">{MASS}</link><link name="part">{MASS}</link>'
        f'<link name="tip"/><joint name="j" type="{kind}"><parent link="base"/>'
        '<child link="part"/><origin xyz="0.1 0.2 0.3" rpy="0.5 -0.3 1.0"/><axis xyz="0 0.6 0.8"/>'
        '<limit lower="-2" upper="2" effort="100" velocity="9"/></joint>'
        '<joint name="f" type="fixed"><parent link="part"/><child link="tip"/>'
        f'<origin xyz="0 0 0.4"/></joint>{plugin}</robot>'
    )


@pytest.fixture(name="topics")
def _topics(monkeypatch):
    made = fake_publishers(monkeypatch, transforms)
    monkeypatch.setattr(transforms, "_fixed", transforms.FixedTransforms())
    return made


@pytest.fixture(name="world")
def _world(world):
    world.spawn(sdf.ground_plane())
    return world


def output(world, model, number=0):
    """The model's output of this number."""
    spec = model.description.sensors[number]
    return plugin_of(world, model, spec)


def test_what_the_plugin_asks_for(world):
    model = world.spawn_urdf("arm", arm("revolute"), Pose((0, 0, 1.0)), str)
    joints, root = model.description.sensors
    assert joints == JointTransformsSpec("p", "base", 20.0)
    assert root == RootTransformSpec("p", "base", "map", 50.0, child_frame_id="base")
    plain = arm("revolute", PLUGIN.replace("<frameName>map</frameName>", ""))
    (only,) = world.spawn_urdf("plain", plain, Pose((3, 0, 1.0)), str).description.sensors
    assert isinstance(only, JointTransformsSpec)


@pytest.mark.parametrize("kind", ["revolute", "continuous", "prismatic"])
def test_joints_are_where_the_engine_has_them(topics, world, kind):
    model = world.spawn_urdf("arm", arm(kind), Pose((0, 0, 1.0)), str)
    output(world, model)
    model.joints.set_positions({"j": 0.7})
    joint = model.description.joints["j"]
    position, orientation = transforms.JointFrame(joint).at(model.joints.positions_of(["j"])[0])
    base, part = (model.link_state(link)[0] for link in ("base", "part"))
    there = base.inverse() * part
    assert position == pytest.approx(there.position, abs=1e-6)
    signed = orientation if orientation[3] * there.orientation[3] > 0 else [-v for v in orientation]
    assert signed == pytest.approx(there.orientation, abs=1e-6)


def test_a_joint_of_an_sdf_has_its_frame_elsewhere(topics, world):
    text = (
        '<sdf version="1.6"><model name="m"><link name="a"><inertial><mass>1</mass></inertial>'
        '</link><link name="b"><pose>0.5 0 0.2 0 0 0.4</pose></link>'
        '<joint name="j" type="revolute"><parent>a</parent><child>b</child>'
        "<pose>0.1 0.2 0 0.3 0 0</pose><axis><xyz>0 0 1</xyz></axis></joint></model></sdf>"
    )
    model = world.spawn_sdf("m", text, Pose((0, 0, 1.0)), str)
    model.joints.set_positions({"j": 0.7})
    a, b = (model.link_state(link)[0] for link in ("a", "b"))
    position, _ = transforms.JointFrame(model.description.joints["j"]).at(0.7)
    assert position == pytest.approx((a.inverse() * b).position, abs=1e-6)


def test_fixed_joints_of_all_models_stay_until_their_models_go(topics, world):
    outputs = [
        output(world, world.spawn_urdf(name, arm("revolute"), Pose((x, 0, 1.0)), str))
        for x, name in enumerate(("one", "two"))
    ]
    sent = topics["/tf_static"].messages
    assert [len(message.transforms) for message in sent] == [1, 2]
    transform = sent[-1].transforms[0]
    assert (transform.header.frame_id, transform.child_frame_id) == ("part", "tip")
    assert transform.transform.translation.z == pytest.approx(0.4)
    outputs[0].close()
    assert len(sent[-1].transforms) == 1
    topics["/tf_static"].unregister()  # as when what made it failed later
    output(world, outputs[0].model)
    assert len(topics["/tf_static"].messages[-1].transforms) == 2
