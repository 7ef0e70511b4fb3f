"""Joints that follow others, by <mimic> and by plugin."""

import math

import pytest
from bullet_sim.pose import Pose
from bullet_sim.world import World
from urdf_texts import link

LINK = link("{0}", inertia=0.01, center="0.2 0 0")
JOINT = (
    '<joint name="{0}" type="{2}"><origin xyz="0 {1} 0"/><parent link="world"/><child '
    'link="{0}_link"/><axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="30" velocity="20"/>'
    "{3}</joint>"
)
CONTROL = '<gazebo><plugin filename="libgazebo_ros_control.so"/></gazebo>'
PLUGIN = (
    '<gazebo><plugin filename="lib{0}_mimic_joint_plugin.so"><joint>lead</joint><mimicJoint>'
    "tail</mimicJoint>{1}</plugin></gazebo>"
)
MIMIC = '<mimic joint="lead" multiplier="-0.5" offset="0.1"/>'


class Pair:
    """A world with two arms on axes across gravity; the first is commanded."""

    def __init__(self, mimic="", extra="", kind="revolute"):
        text = (
            '<robot name="pair"><link name="world"/>'
            + "".join(
                LINK.format(f"{name}_link") + JOINT.format(name, at, kind, tag)
                for name, at, tag in (("lead", 0, ""), ("tail", 1, mimic))
            )
            + extra
            + CONTROL
            + "</robot>"
        )
        self.world = World()
        self.model = self.world.spawn_urdf("pair", text, Pose(), str)
        self.warnings = str(self.model.description.warnings)
        manager = self.model.manager
        manager.load("c", {"type": "position_controllers/JointPositionController", "joint": "lead"})
        manager.switch(["c"], [])
        self.command = lambda value: manager.command("c", (value,))

    def positions(self):
        """Of lead and tail."""
        return self.model.joints.positions_of(("lead", "tail"))

    def close(self):
        """Free the engine."""
        self.world.close()


@pytest.mark.parametrize(
    "options",
    [
        {"mimic": MIMIC},
        {
            "extra": PLUGIN.format(
                "roboticsgroup_gazebo", "<multiplier>-0.5</multiplier><offset>0.1</offset>"
            )
        },
        {
            "extra": PLUGIN.format(
                "roboticsgroup_upatras_gazebo",
                "<multiplier>-0.5</multiplier><offset>0.1</offset><hasPID/>",
            )
        },
        {"mimic": MIMIC, "kind": "prismatic"},
    ],
)
def test_it_follows_against_gravity_while_the_other_moves(options):
    pair = Pair(**options)
    for step in range(1000):
        pair.command(0.6 * math.sin(step * 0.001 * 2.0 * math.pi))
        pair.world.step()
        if step > 300:
            lead, tail = pair.positions()
            assert tail == pytest.approx(-0.5 * lead + 0.1, abs=2e-3)
    pair.close()


def test_it_follows_with_no_more_than_its_effort_and_stays_within_its_stops():
    weak = Pair(extra=PLUGIN.format("roboticsgroup_gazebo", "<maxEffort>1.0</maxEffort>"))
    weak.world.step(500)
    assert weak.positions()[1] > 0.3  # 1 kg at 0.2 m pulls with 1.96 N m
    weak.close()
    far = Pair(mimic='<mimic joint="lead" multiplier="9"/>')
    far.command(1.0)
    far.world.step(500)
    assert far.positions()[1] == pytest.approx(2.0, abs=5e-3)
    far.close()


def test_deviations_below_the_sensitiveness_are_left():
    pair = Pair(extra=PLUGIN.format("roboticsgroup_gazebo", "<sensitiveness>0.3</sensitiveness>"))
    pair.command(0.2)
    pair.world.step(500)
    assert abs(pair.positions()[1]) < 0.01
    pair.command(0.4)
    pair.world.step(500)
    assert 0.1 < pair.positions()[1] < 0.3
    pair.close()


@pytest.mark.parametrize("pid", ["", "<hasPID/>"])
def test_a_deviation_as_large_as_the_sensitiveness_is_followed(pid):
    tags, places = f"<offset>0.1</offset>{pid}<sensitiveness>{{}}</sensitiveness>", []
    for sensitiveness in (0.05, 0.1, 0.15):
        pair = Pair(extra=PLUGIN.format("roboticsgroup_gazebo", tags.format(sensitiveness)))
        pair.world.step()
        places.append(pair.positions()[1])
        pair.close()
    assert places[0] == places[1] != places[2]


def test_a_joint_with_a_transmission_is_left_to_its_controllers():
    transmission = (
        '<transmission name="t"><type>transmission_interface/SimpleTransmission</type><joint '
        'name="{0}"><hardwareInterface>PositionJointInterface</hardwareInterface></joint>'
        '<actuator name="m"/></transmission>'
    )
    extra = "".join(map(transmission.format, ("lead", "tail")))
    pair = Pair(mimic=MIMIC, extra=extra)
    assert not pair.model.mimics
    pair.close()


@pytest.mark.parametrize(
    "mimic, extra",
    [
        ('<mimic joint="none"/>', ""),
        ('<mimic joint="tail"/>', ""),
        ("", PLUGIN.format("roboticsgroup_gazebo", "").replace("lead", "none")),
    ],
)
def test_what_is_no_other_joint_is_a_warning(mimic, extra):
    pair = Pair(mimic, extra)
    assert not pair.model.mimics
    assert "is no other joint that moves" in pair.warnings or "do not exist" in pair.warnings
    pair.close()
