"""URDF text: what is read, what is repaired with a warning, what is refused and how."""

import math

import numpy as np
import pytest
from bullet_sim.errors import ModelError
from bullet_sim.formats.urdf import parse_urdf
from urdf_texts import robot

pytestmark = pytest.mark.usefixtures("sketches")

DECLARATION = '<?xml version="1.0" encoding="utf-8"?>\n'
BOX = '<geometry><box size="1 2 3"/></geometry>'
TWO_LINKS = '<link name="base"/><link name="tip"/>'


def joint(kind="fixed", parent="base", child="tip", extra=""):
    """A joint between two links."""
    return (
        f'<joint name="j" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f"{extra}</joint>"
    )


@pytest.mark.parametrize(
    "text",
    [
        DECLARATION + robot('<link name="größe"/>'),
        (DECLARATION + robot('<link name="größe"/>')).encode("utf-8"),
        (DECLARATION.replace("utf-8", "iso-8859-1") + robot('<link name="größe"/>')).encode(
            "iso-8859-1"
        ),
        "\n  " + DECLARATION + robot('<link name="größe"/>'),
        (DECLARATION.replace("utf-8", "iso-8859-1") + robot('<link name="größe"/>')),
    ],
)
def test_encoding_declarations_are_accepted(text):
    assert parse_urdf(text, str).root == "größe"


def test_link_without_inertial_has_no_mass():
    link = parse_urdf(robot('<link name="base"/>'), str).links["base"]
    assert link.mass == 0 and not link.inertia.any() and not link.center.any()


def test_inertia_is_turned_into_the_link_frame():
    text = (
        '<link name="a"><inertial><origin xyz="1 2 3" rpy="0 0 1.5707963267948966"/>'
        '<mass value="2"/><inertia ixx="1" iyy="2" izz="2.5"/></inertial></link>'
    )
    link = parse_urdf(robot(text), str).links["a"]
    assert link.mass == 2 and link.center.tolist() == [1, 2, 3]
    np.testing.assert_allclose(link.inertia, np.diag([2, 1, 2.5]), atol=1e-12)


def test_missing_mesh_is_named_and_the_rest_loads():
    text = robot(
        '<link name="a"><visual><geometry><mesh filename="/no/such.stl"/></geometry>'
        f"</visual><visual>{BOX}</visual></link>"
    )
    model = parse_urdf(text, str)
    assert [shape.geometry.kind for shape in model.links["a"].visuals] == ["box"]
    assert len(model.warnings) == 1
    assert "/no/such.stl" in model.warnings[0] and "link 'a' visual" in model.warnings[0]


def test_package_that_is_not_found_is_named_and_the_rest_loads():
    def resolve(uri):
        raise ValueError("no package gone")

    text = robot(
        '<link name="a"><collision><geometry><mesh filename="package://gone/m.stl"/>'
        "</geometry></collision></link>"
    )
    model = parse_urdf(text, resolve)
    assert model.links["a"].collisions == []
    assert "package://gone/m.stl" in model.warnings[0]
    assert "no package gone" in model.warnings[0]


def test_colour_of_a_named_material():
    text = robot(
        '<material name="red"><color rgba="1 0 0 1"/></material><link name="a"><visual>'
        f'{BOX}<material name="red"/></visual></link>'
    )
    assert parse_urdf(text, str).links["a"].visuals[0].color == (1, 0, 0, 1)


def test_joint_is_read():
    extra = (
        '<origin xyz="0 0 1"/><axis xyz="0 0 2"/><dynamics damping="0.1" friction="0.2"/>'
        '<limit lower="-1" upper="2" effort="3" velocity="4"/>'
    )
    read = parse_urdf(robot(TWO_LINKS + joint("revolute", extra=extra)), str).joints["j"]
    assert (read.lower, read.upper, read.effort, read.velocity) == (-1, 2, 3, 4)
    assert (read.axis, read.damping, read.friction) == ((0, 0, 1), 0.1, 0.2)
    assert read.origin.position == (0, 0, 1)


REFUSED = [
    ('<robot><link name="a"></robot>', ["URDF of 'car'", "not well-formed", "line 1"]),
    ("", ["not well-formed"]),
    ("<sdf/>", ["<sdf>", "must be <robot>"]),
    (robot(""), ["'car'", "no link"]),
    (robot("<link/>"), ["'car'", "no link"]),
    (robot("<xacro:wheel/>"), ["no link but <xacro:wheel>", "process it with xacro first"]),
    (robot(TWO_LINKS), ["2 root links", "base, tip", "must be one"]),
    (robot(TWO_LINKS + "<arm_joint parent='base'/>"), ["2 root links", "<xacro:arm_joint>"]),
    (robot("<wheel side='left'/>"), ["has no link; <wheel> is no URDF", "<xacro:wheel>"]),
]


@pytest.mark.parametrize("text, parts", REFUSED, ids=[" ".join(p) for _, p in REFUSED])
def test_bad_urdf_is_refused_by_name_value_and_what_is_valid(text, parts):
    with pytest.raises(ModelError) as error:
        parse_urdf(text, str, "car")
    for part in parts:
        assert part in str(error.value)


def test_pi_as_text():
    text = robot(TWO_LINKS + joint(extra=f'<origin rpy="0 0 {math.pi}"/>'))
    assert parse_urdf(text, str).joints["j"].origin.rpy[2] == pytest.approx(math.pi)
