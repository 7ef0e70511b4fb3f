"""Warnings are told one line a cause."""

import pytest
from bullet_sim.description.parts import ModelDescription
from bullet_sim.description.read_warning import grouped

MISSING = "meshes are missing"


def warned(*warnings):
    """Lines of a model that took these warnings: (text, cause, item)."""
    model = ModelDescription("m")
    for warning in warnings:
        model.warn(*warning)
    return grouped(model.warnings)


def mesh(number):
    """A warning about one of several meshes."""
    return (f"visual {number}: mesh 'm{number}' is missing", MISSING, f"m{number}")


@pytest.mark.parametrize(
    "warnings, lines",
    [
        ([], []),
        ([mesh(1)], ["visual 1: mesh 'm1' is missing"]),
        ([mesh(1), mesh(1)], ["visual 1: mesh 'm1' is missing"]),
        ([mesh(1), mesh(2)], ["2 meshes are missing: m1, m2"]),
        ([mesh(n) for n in range(56)], ["56 meshes are missing: m0 and 55 more"]),
        (
            [("visual a: m", MISSING, "m"), ("visual b: m", MISSING, "m")],
            ["visual a: m (and 1 more of this kind)"],
        ),
        ([("a",), mesh(1), ("b",), mesh(2)], ["a", "2 meshes are missing: m1, m2", "b"]),
        (
            [("joint 'a' is odd",), ("joint 'b' is odd",), ("link 'a' is odd",)],
            ["joint 'a' is odd (and 1 more of this kind)", "link 'a' is odd"],
        ),
    ],
)
def test_one_line_a_cause(warnings, lines):
    assert warned(*warnings) == lines


def test_plain_sentences_are_grouped_too():
    assert grouped(["plugin 'a' is odd", "plugin 'b' is odd", "x"]) == [
        "plugin 'a' is odd (and 1 more of this kind)",
        "x",
    ]
