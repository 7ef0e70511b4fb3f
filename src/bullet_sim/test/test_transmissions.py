"""<transmission> elements as published packages write them."""

import xml.etree.ElementTree as ElementTree

import pytest
from bullet_sim.formats.urdf import parse_transmissions

JOINTS = ("left", "right")


def parse(body):
    """(offered interfaces, warnings) of a <robot>."""
    warnings = []
    robot = ElementTree.fromstring(f"<robot>{body}</robot>")
    return parse_transmissions(robot, JOINTS, warnings.append)[0], warnings


def transmission(joint, interface, place="joint"):
    """One <transmission>."""
    text = f"<hardwareInterface>{interface}</hardwareInterface>"
    return (
        f'<transmission name="t"><joint name="{joint}">{text if place == "joint" else ""}'
        f'</joint><actuator name="m">{text if place == "actuator" else ""}</actuator>'
        "</transmission>"
    )


@pytest.mark.parametrize(
    "interface, kind",
    [
        ("hardware_interface/EffortJointInterface", "effort"),
        ("VelocityJointInterface", "velocity"),
        ("hardware_interface::PositionJointInterface", "position"),
        ("\n  hardware_interface/EffortJointInterface\n", "effort"),
    ],
)
def test_spellings(interface, kind):
    assert parse(transmission("left", interface)) == ({"left": (kind,)}, [])


def test_interface_in_the_actuator_counts_too():
    assert parse(transmission("left", "EffortJointInterface", "actuator"))[0] == {
        "left": ("effort",)
    }


def test_several_add_up():
    body = transmission("left", "EffortJointInterface") + transmission(
        "left", "VelocityJointInterface"
    )
    assert parse(body)[0] == {"left": ("effort", "velocity")}


@pytest.mark.parametrize(
    "body, text",
    [
        ('<transmission name="t"/>', "no <joint>"),
        (transmission("nose", "EffortJointInterface"), "joint 'nose', which does not exist"),
        (
            transmission("left", "MagicInterface"),
            "'MagicInterface', known are EffortJointInterface",
        ),
        ('<transmission name="t"><joint name="left"/></transmission>', "no <hardwareInterface>"),
    ],
)
def test_what_is_odd_is_left_out_with_one_warning(body, text):
    offered, warnings = parse(body)
    assert offered == {} and len(warnings) == 1
    assert text in warnings[0] and "t" in warnings[0]
