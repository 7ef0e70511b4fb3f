"""Warnings are told one line a cause."""

import pytest
from bullet_sim.description.model import ModelDescription
from bullet_sim.description.warnings import ReadWarning, grouped, is_loss, missing

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


def test_a_plugin_that_says_that_it_is_left_out_is_a_loss():
    assert is_loss(ReadWarning("plugin 'libx.so' has no <wheel> that it can use; it is left out"))
    assert not is_loss(ReadWarning("texture 'plugin' is not there; it is left out"))


def test_what_is_missing_by_its_cause():
    warnings = [ReadWarning("a", f"{MISSING} and left out", name) for name in ("m1", "m2")]
    warnings += [ReadWarning("b", "included models cannot be used", "'model://x'")]
    assert missing([*warnings, "plain", ReadWarning("c", "plugins are left out", "p")]) == {
        "meshes are missing and left out": ["m1", "m2"],
        "included models cannot be used": ["'model://x'"],
    }


@pytest.mark.parametrize(
    "cause, lost",
    [
        ("plugins are not known here and are ignored", True),
        ("world plugins are not known here and are ignored", True),
        ("plugins of sensors are not known here and are ignored", True),
        ("plugins are left out", True),
        ("plugins name a link that does not exist and are left out", True),
        ("sensors are left out", True),
        ("world files cannot be had", True),
        ("sensors have a type that is not known here and are left out", True),
        ("sensors refer to a link that does not exist and are left out", False),
        ("sensors have no ROS plugin and so no topic and are left out", False),
        ("sensors have no update rate and run at 30 Hz", False),
        ("meshes are missing and left out", False),
        ("", False),
    ],
)
def test_which_warnings_say_that_a_topic_is_missing(cause, lost):
    assert is_loss(ReadWarning("a sentence", cause, "an item")) is lost
