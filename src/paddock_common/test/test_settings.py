"""Settings are read from parameters and tables, and check themselves."""

from dataclasses import FrozenInstanceError, dataclass

import pytest
from paddock_common.settings import (
    Number,
    check,
    choice,
    flag,
    from_table,
    number,
    parameter,
    read,
    text,
)


@dataclass(frozen=True)
class Limits:
    """One of each type of field, and one without a rule."""

    speed: float = number(1.5, above=0.0, unit="m/s")
    rate: float = number(100.0, above=0.0, name="pub_frequency")
    gains: str = choice("soft", ("soft", "hard"))
    trailer: bool = flag(False)
    frame: str = text("odom")
    notes: tuple = ()

    def __post_init__(self):
        check(self, KeyError, prefix="limit ")


def test_defaults_are_also_those_of_the_class():
    assert (Limits().speed, Limits.speed) == (1.5, 1.5)
    with pytest.raises(FrozenInstanceError):
        Limits().speed = 2.0


def test_parameters_are_read_by_name():
    values = {"~speed": 2, "~pub_frequency": 50.0, "~trailer": True, "speed": 9}
    assert read(Limits, values.get) == Limits(2, 50.0, trailer=True)
    assert read(Limits, values.get, prefix="").speed == 9
    assert read(Limits, {"~pad_frame": "map"}.get, prefix="~pad_").frame == "map"


@pytest.mark.parametrize(
    "values, message",
    [
        ({"speed": -1}, "limit speed is -1; it must be above 0 [m/s]"),
        ({"pub_frequency": 0}, "limit pub_frequency is 0; it must be above 0"),
        ({"gains": "odd"}, "limit gains is 'odd'; it must be one of soft, hard"),
        ({"trailer": "no"}, "limit trailer is 'no'; it must be true or false"),
        ({"frame": ""}, "limit frame is ''; it must be a name"),
    ],
)
def test_errors_name_the_setting(values, message):
    with pytest.raises(KeyError) as error:
        read(Limits, values.get, prefix="")
    assert error.value.args == (message,)


def test_one_parameter():
    values = {"~rate": 20}
    assert parameter(values.get, "rate", 5.0, Number(above=0.0)) == 20
    assert parameter(values.get, "other", 5.0, Number(above=0.0)) == 5.0
    with pytest.raises(ValueError, match="rate is 20; it must be at most 10"):
        parameter(values.get, "rate", 5.0, Number(max=10.0))


def test_tables():
    assert from_table(Limits, {"frame": "map"}, "limits") == Limits(frame="map")
    with pytest.raises(ValueError, match="limits: unknown speeed; there are: speed, rate, gains"):
        from_table(Limits, {"speeed": 1.0}, "limits")
    with pytest.raises(LookupError, match=r"limits is \[1\]; it must be a table"):
        from_table(Limits, [1], "limits", LookupError)
