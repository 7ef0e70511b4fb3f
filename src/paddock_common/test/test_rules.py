"""Rules report what is valid, in the messages that users read."""

import math

import numpy as np
import pytest
from paddock_common.settings import Choice, Flag, Number, Text, converted


@pytest.mark.parametrize(
    "rule, value",
    [
        (Number(), -3),
        (Number(), np.float32(0.5)),
        (Number(), np.int64(2)),
        (Number(above=0.0), 1e-9),
        (Number(min=0.0), 0),
        (Number(min=0.0, max=2.0), 2.0),
        (Number(above=-1.0, below=1.0), -0.99),
        (Number(integer=True), 3),
        (Number(integer=True), np.int64(3)),
        (Flag(), False),
        (Choice(("a", "b")), "b"),
        (Choice((1, -1)), -1.0),
        (Text(), "odom"),
        (Text(empty=True), ""),
    ],
)
def test_valid_values_come_back(rule, value):
    assert rule.check("x", value) is value


@pytest.mark.parametrize(
    "rule, value, valid",
    [
        (Number(), "1", "a number"),
        (Number(), None, "a number"),
        (Number(), True, "a number"),
        (Number(), math.inf, "a finite number"),
        (Number(unit="m"), math.nan, "a finite number [m]"),
        (Number(above=0.0, unit="s"), "fast", "a number above 0 [s]"),
        (Number(above=0.0, unit="s"), 0.0, "above 0 [s]"),
        (Number(min=0.0), -0.1, "0 or more"),
        (Number(min=0.0), [], "a number, 0 or more"),
        (Number(above=0.0, below=math.pi / 2), 1.6, "above 0 and below 1.571"),
        (Number(above=0.0, below=0.7), 0.7, "above 0 and below 0.7"),
        (Number(min=0.01, max=3.0), 4.0, "from 0.01 to 3"),
        (Number(above=0.0, max=5.0), 5.1, "above 0 and at most 5"),
        (Number(min=0, integer=True), 1.0, "a whole number, 0 or more"),
        (Number(min=0, integer=True), -1, "0 or more"),
        (Flag(), 1, "true or false"),
        (Choice(("a", "b")), "c", "one of a, b"),
        (Choice((1, -1)), True, "one of 1, -1"),
        (Choice((1, -1), "1 (right) or -1 (left)"), 2, "1 (right) or -1 (left)"),
        (Text(), "", "a name"),
        (Text(empty=True), 3, "a text"),
    ],
)
def test_others_are_refused_with_what_is_valid(rule, value, valid):
    with pytest.raises(LookupError) as error:
        rule.check("~speed", value, LookupError)
    assert error.value.args == (f"~speed is {value!r}; it must be {valid}",)


@pytest.mark.parametrize("value, number", [(2, 2.0), ("1e3", 1000.0), (" -0.5 ", -0.5)])
def test_a_text_that_is_a_number_is_converted(value, number):
    result = converted("x", value)
    assert result == number and isinstance(result, float)


@pytest.mark.parametrize("value", [True, "two", "", None, [1], math.nan, "inf", 10**400])
def test_what_is_no_number_is_named(value):
    with pytest.raises(ValueError, match="x is .*; it must be a number"):
        converted("x", value)
