"""<transmission> elements, each as transmission_parser.cpp and default_robot_hw_sim.cpp take it."""

import xml.etree.ElementTree as ElementTree

import pytest
from bullet_sim.controllers.interfaces import GAINS, register
from bullet_sim.description.model import Joint, ModelDescription
from bullet_sim.formats.transmissions import parse_transmissions

TYPE = "<type>transmission_interface/SimpleTransmission</type>"
ACTUATOR = '<actuator name="m"/>'
EFFORT = "hardware_interface/EffortJointInterface"
VELOCITY = "hardware_interface/VelocityJointInterface"


def parse(body):
    """Transmissions of a <robot>."""
    return parse_transmissions(ElementTree.fromstring(f"<robot>{body}</robot>"))


def joint(*interfaces, name="left"):
    """A <joint> of a transmission."""
    texts = (f"<hardwareInterface>{text}</hardwareInterface>" for text in interfaces)
    return f'<joint name="{name}">{"".join(texts)}</joint>'


def transmission(*joints, kind=TYPE, actuator=ACTUATOR, name='name="t"'):
    """One <transmission>."""
    return f"<transmission {name}>{kind}{''.join(joints)}{actuator}</transmission>"


def registered(body, **parameters):
    """Registered of a robot with the joints left and right and the fixed joint weld."""
    limit = dict(limit=(10.0, 5.0), lower=-1.0, upper=1.0)
    joints = {name: Joint(name, "revolute", "a", name, **limit) for name in ("left", "right")}
    description = ModelDescription("bot", kept={"weld"}, is_urdf=True)
    return register(parse(body), description, joints, parameters)


@pytest.mark.parametrize(
    "interface, kind",
    [
        (EFFORT, "effort"),
        ("VelocityJointInterface", "velocity"),
        ("\n  hardware_interface/PositionJointInterface\n", "position"),
    ],
)
def test_spellings(interface, kind):
    made = registered(transmission(joint(interface)))
    assert (made.interfaces, made.refusal) == ({"left": (kind,)}, "")
    deprecated = [text for level, text in made.messages if level == "warn"]
    assert deprecated == (
        []
        if "/" in interface
        else [
            "Deprecated syntax, please prepend 'hardware_interface/' to 'VelocityJointInterface' "
            "within the <hardwareInterface> tag in joint 'left'."
        ]
    )


@pytest.mark.parametrize(
    "body, errors",
    [
        (transmission(joint(EFFORT), name=""), ["No name attribute specified for transmission."]),
        (
            transmission(joint(EFFORT), name='name=""'),
            ["Empty name attribute specified for transmission."],
        ),
        (transmission(joint(EFFORT), kind=""), ["No type element found in transmission 't'."]),
        (
            transmission(joint(EFFORT), kind="<type> </type>"),
            ["Skipping empty type element in transmission 't'."],
        ),
        (transmission(), ["Failed to load joints for transmission 't'."]),
        (
            transmission(f"<joint><hardwareInterface>{EFFORT}</hardwareInterface></joint>"),
            [
                "No name attribute specified for joint.",
                "Failed to load joints for transmission 't'.",
            ],
        ),
        (
            transmission(joint(EFFORT, name="")),
            [
                "Empty name attribute specified for joint.",
                "Failed to load joints for transmission 't'.",
            ],
        ),
        (
            transmission(joint(" ")),
            [
                "No valid hardware interface element found in joint 'left'.",
                "Failed to load joints for transmission 't'.",
            ],
        ),
        (
            transmission(joint(EFFORT), actuator=""),
            ["Failed to load actuators for transmission 't'."],
        ),
        (
            transmission(joint(EFFORT), actuator="<actuator/>"),
            [
                "No name attribute specified for actuator.",
                "Failed to load actuators for transmission 't'.",
            ],
        ),
        (
            transmission(joint(), actuator=f'<actuator name="m">{joint(EFFORT)}</actuator>'),
            [
                "No valid hardware interface element found in joint 'left'.",
                "Failed to load joints for transmission 't'.",
            ],
        ),
    ],
)
def test_what_the_parser_leaves_out(body, errors):
    other = transmission(joint(VELOCITY, name="right"), name='name="u"')
    made = registered(body + other)
    assert (made.interfaces, made.refusal) == ({"right": ("velocity",)}, "")
    assert [text for level, text in made.messages if level == "error"] == errors
    assert made.messages[-1] == (GAINS, "right")


def test_of_several_interfaces_of_a_joint_the_first_counts():
    made = registered(transmission(joint(EFFORT, VELOCITY)))
    assert made.interfaces == {"left": ("effort",)}
    assert made.messages == [
        (
            "warn",
            "Joint left of transmission t specifies multiple hardware interfaces. Currently the "
            "default robot hardware simulation interface only supports one. Using the first entry",
        )
    ]
    assert "its <transmission> offers effort" in made.lacks("left", "velocity")
    assert made.lacks("left", "effort") == ""


def test_several_transmissions_of_a_joint_add_up():
    made = registered(transmission(joint(EFFORT)) + transmission(joint(VELOCITY)))
    assert made.interfaces == {"left": ("effort", "velocity")}
    text = "Replacing previously registered handle 'left' in 'hardware_interface::JointStateInterf"
    assert made.messages[0][0] == "warn" and made.messages[0][1].startswith(text)


def test_a_transmission_of_several_joints_is_left_out():
    made = registered(transmission(joint(EFFORT), joint(EFFORT, name="right")))
    assert (made.interfaces, made.refusal) == ({}, "")
    ((level, text),) = made.messages
    assert level == "warn" and text.startswith("Transmission t has more than one joint. Currently")


@pytest.mark.parametrize(
    "odd, level, reason",
    [
        (
            joint("hardware_interface/MagicInterface"),
            "fatal",
            "No matching hardware interface found for 'hardware_interface/MagicInterface' while "
            "loading interfaces for left",
        ),
        (
            joint("hardware_interface::EffortJointInterface"),
            "fatal",
            "No matching hardware interface found for 'hardware_interface::EffortJointInterface' "
            "while loading interfaces for left",
        ),
        (
            joint(EFFORT, name="nose"),
            "error",
            'This robot has a joint named "nose" which is not in the gazebo model.',
        ),
    ],
)
def test_what_makes_gazebo_ros_control_give_up(odd, level, reason):
    first = transmission(joint(VELOCITY, name="right"))
    made = registered(first + transmission(odd) + transmission(joint(EFFORT)))
    assert (made.refusal, made.messages[-1]) == (reason, (level, reason))
    assert made.interfaces == {"right": ("velocity",)}, "its motor holds it"


def test_a_fixed_joint_that_stays_is_in_the_model():
    made = registered(transmission(joint(EFFORT, name="weld")))
    assert (made.interfaces, made.refusal) == ({}, "")


@pytest.mark.parametrize(
    "interface, parameters, reason",
    [
        (EFFORT, {"has_velocity_limits": False}, "It has no velocity limits specification."),
        (EFFORT, {"has_effort_limits": False}, "It has no efforts limits specification."),
        (VELOCITY, {"has_velocity_limits": False}, "It has no velocity limits specification."),
        (VELOCITY, {"has_effort_limits": False}, ""),
        ("hardware_interface/PositionJointInterface", {"has_velocity_limits": False}, ""),
    ],
)
def test_limits_that_no_handle_can_be_made_of(interface, parameters, reason):
    made = registered(transmission(joint(interface)), left=parameters)
    expected = f"Cannot enforce limits for joint 'left'. {reason}" if reason else ""
    assert made.refusal == expected
