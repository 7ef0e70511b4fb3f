"""What browsers may send."""

import json
import math
import random

import pytest
from bullet_web.messages import ACTIONS, FIELDS, BadMessage, json_of, parse

PLACE = {"x": 1.0, "y": -0.2, "z": 0.0}
VALID = [  # of the track with our car
    {"type": "ack"},
    {"type": "take"},
    {"type": "release"},
    {"type": "drive", "speed": 0.5, "steering": -1},
    {"type": "topic", "topic": "/cmd_vel"},
    {"type": "want", "camera": "/camera/image", "lidar": "/scan", "data": True, "contacts": True},
    {"type": "do", "action": "pause"},
    {"type": "do", "action": "resume"},
    {"type": "do", "action": "reset"},
    {"type": "do", "action": "cancel"},
    {"type": "do", "action": "step", "count": 10},
    {"type": "do", "action": "pace", "factor": 1},
    {"type": "do", "action": "place", "model": "racecar", **PLACE, "yaw": 1.5},
    {"type": "do", "action": "spawn", "kind": "cone", **PLACE},
    {"type": "do", "action": "goal", **PLACE},
    {"type": "do", "action": "remove", "model": "cone_1"},
]
OTHERS = [  # other values that are accepted
    {"type": "want", "camera": "/camera/image", "lidar": "", "data": True, "contacts": False},
    {"type": "do", "action": "step", "count": 100},
    {"type": "do", "action": "pace", "factor": 0},
    {"type": "do", "action": "goal", "x": 1.0, "y": -2, "z": 0.0},
    {"type": "do", "action": "goal", **PLACE, "yaw": 1.5, "model": "truck"},
    {
        **{"type": "want", "camera": "", "lidar": "", "data": True, "contacts": False},
        "layers": "/map /particlecloud",
    },
]
MUTATIONS = 10000


@pytest.mark.parametrize(
    "message", [*VALID, *OTHERS], ids=lambda each: each.get("action", each["type"])
)
def test_a_message_keeps_its_known_fields(message):
    assert parse(json.dumps({**message, "more": [1]})) == message


def test_every_type_and_action_has_an_example():
    assert {message["type"] for message in VALID} == set(FIELDS)
    assert {message.get("action") for message in VALID} - {None} == set(ACTIONS)


@pytest.mark.parametrize(
    "text, reason",
    [
        (b"{}", "the message is binary"),
        ("", "the message is no JSON"),
        ("[" * 4000, "the message is no JSON"),
        ("[]", "the message is [], must be an object"),
        ("{}", "type is None, must be one of ack, take"),
        ('{"type": ["ack"]}', "type is ['ack'], must be one of"),
        (
            '{"type": "drive", "speed": NaN, "steering": 0}',
            "speed is nan, must be a finite number from -1",
        ),
        (
            '{"type": "drive", "speed": 1e999, "steering": 0}',
            "speed is inf, must be a finite number",
        ),
        ('{"type": "drive", "speed": 1' + 4000 * "0" + ', "steering": 0}', "speed is 1000"),
        ('{"type": "drive", "speed": true, "steering": 0}', "speed is True, must be a number"),
        ('{"type": "drive", "speed": 0.5}', "steering is None, must be a number from -1 to 1"),
        ('{"type": "want", "camera": {}, "lidar": "", "data": 1}', "camera is {}, must be a text"),
        ('{"type": "want", "camera": "", "lidar": "", "data": 1}', "data is 1, must be true or"),
        (
            '{"type": "want", "camera": "", "lidar": "", "data": true, "contacts": "yes"}',
            "contacts is 'yes', must be true or false",
        ),
        ('{"type": "do", "action": "explode"}', "action is 'explode', must be one of pause"),
        ('{"type": "do", "action": "step", "count": 0}', "count is 0, must be from 1 to"),
        ('{"type": "do", "action": "step", "count": 1.5}', "count is 1.5, must be a whole number"),
        ('{"type": "do", "action": "pace", "factor": -1}', "factor is -1, must be from 0 to"),
        ('{"type": "do", "action": "spawn", "kind": "tank"}', "kind is 'tank', must be one of box"),
        (
            '{"type": "do", "action": "goal", "x": 0, "y": "a", "z": 0}',
            "y is 'a', must be a number",
        ),
    ],
)
def test_what_is_refused_and_why(text, reason):
    with pytest.raises(BadMessage) as error:
        parse(text)
    assert str(error.value).startswith(reason)
    assert len(str(error.value)) < 300


def test_mutated_messages_are_read_or_refused_and_nothing_else():
    chance = random.Random(33)
    texts = [json.dumps(message) for message in VALID]
    refused = 0
    for _ in range(MUTATIONS):
        text = list(chance.choice(texts))
        for _ in range(chance.randint(1, 6)):
            at = chance.randrange(len(text) + 1)
            text[at : at + chance.randint(0, 3)] = chance.choice('{}[]":,-+.eE0917 \\\x00ünaN')
        try:
            message = parse("".join(text))
        except BadMessage:
            refused += 1
        else:
            assert message["type"] in FIELDS
    assert 0 < refused < MUTATIONS


def test_what_pages_get_is_json_whatever_the_numbers_are():
    """Python writes NaN and Infinity, which no browser parses: the page stood still."""
    data = {"speed": math.inf, "rows": [(1.0, math.nan)], "name": "x", "count": 3, "no": None}

    def refuse(name):
        raise ValueError(name)

    read = json.loads(json_of(data), parse_constant=refuse)
    assert read == {"speed": None, "rows": [[1.0, None]], "name": "x", "count": 3, "no": None}
    assert json_of({"a": 1.5}) == '{"a": 1.5}'
