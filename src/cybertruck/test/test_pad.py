"""Tables of Joy messages -> command, for both schemes and both pads; triggers; bad messages."""

import math
from pathlib import Path

import pytest
import yaml
from cybertruck.teleop.joystick import PadMap, PadReader, PadTeleop
from paddock_common.settings import from_table

CONFIG = Path(__file__).resolve().parent.parent / "config"
PADS = {
    "ps4": {"cross": 0, "circle": 1, "triangle": 2, "square": 3, "l1": 4, "r1": 5, "r3": 12},
    "xbox": {"cross": 0, "circle": 1, "square": 2, "triangle": 3, "l1": 4, "r1": 5, "r3": 10},
}
AXES = {"x": 0, "y": 1, "l2": 2, "r2": 5}
STOP = (0.0, 0.0)


def pad_table(pad):
    return yaml.safe_load((CONFIG / f"joystick_{pad}.yaml").read_text())["pad"]


def pad_map(pad, **changes):
    return from_table(PadMap, {**pad_table(pad), **changes}, "pad map")


def message(pad, text):
    """Reads "r2=-1 x=0.5 cross" as the arrays of a Joy message.

    Without a word about them the triggers are reported as resting at 1.
    """
    axes, buttons = [0.0] * 8, [0] * (13 if pad == "ps4" else 11)
    axes[2] = axes[5] = 1.0
    for word in text.split():
        name, _, value = word.partition("=")
        if value:
            axes[AXES[name]] = float(value)
        else:
            buttons[PADS[pad][name]] = 1
    return axes, buttons


def play(pad, scheme, texts):
    """Sends messages; "" is a pad at rest."""
    reader, teleop = PadReader(pad_map(pad)), PadTeleop(scheme)
    for text in texts:
        teleop.update(reader.read(*message(pad, text)))
    return teleop


TRADITIONAL = [
    ([""], STOP),
    (["r2=-1"], (0.5, 0.0)),
    (["r2=0.0", "r2=0.5", "r2=0.0"], (0.25, 0.0)),  # half a pull, once it has moved
    (["l2=-1"], (-0.5, 0.0)),
    (["l2=-1 r2=-1"], STOP),
    (["x=1"], STOP),  # a turn alone does nothing
    (["r2=-1 x=1"], (0.5, 0.5)),
    (["r2=-1 x=-0.5"], (0.5, -0.25)),
    (["l2=-1 x=1"], (-0.5, -0.5)),  # the wheels stay left
    (["r2=-1 x=0.03"], (0.5, 0.0)),  # dead zone
    (["r2=-1", ""], STOP),
    (["triangle", "r2=-1 x=1"], (0.5, 0.55)),
    (["cross", "r2=-1 x=1"], (0.5, 0.45)),
    (["square", "r2=-1"], (0.55, 0.0)),
    (["circle", "r2=-1"], (0.45, 0.0)),
    (["square", "square", "square", "r2=-1"], (0.55, 0.0)),  # held down: one step
    (["square", "", "square", "", "r2=-1"], (0.605, 0.0)),
    (["square", "", "triangle", "r1", "r2=-1 x=1"], (0.5, 0.5)),
    (["r2=-1 l1"], STOP),
    (["r2=-1", "r2=-1 l1", "r2=-1"], STOP),  # must be let go of first
    (["r2=-1 l1", "", "r2=-1"], (0.5, 0.0)),
    (["r3", "r2=-1", ""], (0.5, 0.0)),
    (["r3", "r2=-1", "r2=0.5", ""], (0.5, 0.0)),
    (["r3", "r2=-1", "", "x=1"], (0.5, 0.5)),
    (["r3", "r2=-1", "", "l2=-1", ""], (-0.5, 0.0)),
    (["r3", "r2=-1", "", "r2=0.5"], (0.125, 0.0)),
    (["r3", "r2=-1", "", "l1", ""], STOP),
    (["r3", "r2=-1", "", "r3", ""], STOP),
    (["y=1"], STOP),
]

ALTERNATE = [
    ([""], STOP),
    (["y=-1"], (0.5, 0.0)),  # down is forward
    (["y=1"], (-0.5, 0.0)),
    (["y=-0.5"], (0.25, 0.0)),
    (["x=1"], STOP),
    (["y=-1 x=1"], (0.5, 0.5)),
    (["y=1 x=1"], (-0.5, -0.5)),
    (["r2=-1"], STOP),
    (["r2=-1", "", "y=-1"], (0.55, 0.0)),
    (["r2=-1", "r2=-1", "r2=-0.3", "y=-1"], (0.55, 0.0)),  # one pull, one step
    (["r2=-1", "", "r2=-1", "", "y=-1"], (0.605, 0.0)),
    (["l2=-1", "", "y=-1"], (0.45, 0.0)),
    (["r1", "y=-1 x=1"], (0.5, 0.55)),
    (["l1", "y=-1 x=1"], (0.5, 0.45)),
    (["r1", "r2=-1", "circle", "y=-1 x=1"], (0.5, 0.5)),
    (["y=-1 cross"], STOP),
    (["square", "y=-1", ""], (0.5, 0.0)),
    (["square", "y=-1", "y=-0.4", ""], (0.5, 0.0)),
    (["square", "y=-1", "", "y=0.6", ""], (-0.3, 0.0)),
    (["square", "y=-1", "", "cross", ""], STOP),
    (["square", "y=-1", "", "square", ""], STOP),
    (["triangle r3", "y=-1"], (0.5, 0.0)),
]


@pytest.mark.parametrize("pad", PADS)
@pytest.mark.parametrize("texts, expected", TRADITIONAL)
def test_traditional(pad, texts, expected):
    assert play(pad, "traditional", texts).target == pytest.approx(expected)


@pytest.mark.parametrize("pad", PADS)
@pytest.mark.parametrize("texts, expected", ALTERNATE)
def test_alternate(pad, texts, expected):
    assert play(pad, "alternate", texts).target == pytest.approx(expected)


@pytest.mark.parametrize(
    "texts, expected",
    [
        (["l2=0 r2=0"], STOP),  # at 0 until first moved
        (["l2=0 r2=0", "l2=0 r2=0 x=1"], STOP),
        (["l2=0 r2=0", "l2=0 r2=0.8"], (0.05, 0.0)),  # the first message of a pull
        (["l2=0 r2=0", "l2=0 r2=-1"], (0.5, 0.0)),
        (["l2=0 r2=0", "l2=0 r2=-1", "l2=0 r2=1"], STOP),
        (["l2=1 r2=1"], STOP),  # at 1 from the start
        (["l2=1 r2=1", "l2=1 r2=-1"], (0.5, 0.0)),
        (["l2=0 r2=0", "l2=-1 r2=0"], (-0.5, 0.0)),
    ],
)
def test_triggers_until_first_moved(texts, expected):
    assert play("ps4", "traditional", texts).target == pytest.approx(expected)


def test_triggers_from_zero_to_one():
    reader = PadReader(pad_map("ps4", trigger_released=0.0, trigger_pressed=1.0))
    for value, pull in ((0.0, 0.0), (1.0, 1.0), (0.5, 0.5), (0.0, 0.0)):
        assert reader.read(*message("ps4", f"l2=0 r2={value}")).triggers["r2"] == pull


@pytest.mark.parametrize(
    "texts, unplugged",
    [
        (["l2=1 r2=-1"], True),
        (["l2=0 r2=-1"], True),
        (["l2=0 r2=0.9", "l2=0 r2=0.2"], False),  # a trigger that moves through its center
        (["l2=0 r2=0 y=-1"], False),
    ],
)  # a stick that is let go of
def test_all_zero_of_an_unplugged_pad(texts, unplugged):
    reader = PadReader(pad_map("ps4"))
    for text in texts:
        reader.read(*message("ps4", text))
    state = reader.read([0.0] * 8, [0] * 13)
    assert state.unplugged == unplugged
    if unplugged:
        assert state.idle and state.triggers == {"l2": 0.0, "r2": 0.0}


@pytest.mark.parametrize(
    "axes, buttons, words",
    [
        ([0.0] * 2, [0] * 13, "the pad has 2 axes, r2 should be number 5"),
        ([], [], "has 0 axes"),
        ([0.0] * 8, [0] * 4, "the pad has 4 buttons, r3 should be number 12"),
        ([math.nan] + [0.0] * 7, [0] * 13, r"axis 0 \(left_x\) is nan"),
        ([0.0] * 5 + [math.inf, 0.0, 0.0], [0] * 13, r"axis 5 \(r2\) is inf"),
    ],
)
def test_bad_messages(axes, buttons, words):
    with pytest.raises(ValueError, match=words):
        PadReader(pad_map("ps4")).read(axes, buttons)


def test_values_beyond_the_ends_are_cut():
    state = PadReader(pad_map("ps4")).read(*message("ps4", "x=7 r2=-3"))
    assert (state.sticks["left_x"], state.triggers["r2"]) == (1.0, 1.0)


@pytest.mark.parametrize(
    "change, words",
    [
        (lambda table: table["axes"].pop("r2"), "axes/r2 is None"),
        (lambda table: table["axes"].update(r2=-1), "axes/r2 is -1"),
        (lambda table: table["buttons"].update(cross="A"), "buttons/cross is 'A'"),
        (
            lambda table: table["buttons"].update(home=3),
            "name in buttons is 'home'",
        ),
        (lambda table: table.update(sticks=1), "pad map: unknown sticks; there are: axes"),
        (lambda table: table.update(trigger_pressed=1.0), "are the same"),
        (lambda table: table.update(inverted="left_x"), "inverted is 'left_x'"),
        (lambda table: table.pop("axes"), "axes is None"),
    ],
)
def test_bad_maps(change, words):
    table = pad_table("ps4")
    change(table)
    with pytest.raises(ValueError, match=words):
        from_table(PadMap, table, "pad map")


def test_inverted_sticks():
    reader = PadReader(pad_map("ps4", inverted=["left_y"]))
    assert reader.read(*message("ps4", "y=-1")).sticks["left_y"] == 1.0


def test_unknown_scheme():
    with pytest.raises(ValueError, match="one of traditional, alternate"):
        PadTeleop("tank")
