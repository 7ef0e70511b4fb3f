"""./run train, evaluate and lap --driver policy: arguments, and what they become."""

import json
import os
from argparse import Namespace

import pytest

from commands.bootstrap import learning
from commands.errors import UsageError
from commands.launching import policies
from commands.parsing import parser_of
from commands.subcommands import evaluate, lap, train


@pytest.fixture
def trainings(tmp_path, monkeypatch):
    """A folder with one training of name `blue` and half of one of name `red`."""
    for name in ("blue", "red"):
        (tmp_path / name).mkdir()
    (tmp_path / "blue" / "policy.onnx").write_text("")
    (tmp_path / "blue" / "settings.json").write_text(json.dumps({"observation": ["camera"]}))
    monkeypatch.setattr(policies, "FOLDER", str(tmp_path))
    return tmp_path


def parsed(module, name, *words):
    return parser_of(name, module).parse_args(words)


def test_a_training_of_nothing_but_defaults():
    table = train.wanted(parsed(train, "train"))
    assert os.path.basename(table.pop("folder")) == "first"
    workers = 2 * len(os.sched_getaffinity(0))
    assert table == {
        "name": "first",
        "observation": ["state"],
        "steps": train.STEPS["state"],
        "workers": workers,
        "resume": False,
    }


def test_a_training_with_everything(tmp_path):
    files = [tmp_path / name for name in ("reward_function.py", "meta.json", "hyper.json")]
    for path in files:
        path.write_text("{}")
    words = ["fast", "--track", "hard", "--observation", "state,camera", "--walls"]
    for option, path in zip(("--reward", "--metadata", "--hyperparameters"), files):
        words += [option, str(path)]
    words += ["--race", "head_to_bot", "--randomize", "all", "--steps", "1000", "--workers", "3"]
    table = train.wanted(parsed(train, "train", *words, "--seed", "5"))
    assert table["observation"] == ["state", "camera"]
    assert table["randomize"] == list(train.RANDOM)
    assert (table["reward"], table["metadata"]) == (str(files[0]), str(files[1]))
    assert (table["race"], table["walls"], table["track"]) == ("head_to_bot", True, "hard")
    assert (table["steps"], table["workers"], table["seed"]) == (1000, 3, 5)


def test_resume_changes_only_what_is_given():
    table = train.wanted(parsed(train, "train", "fast", "--resume", "--steps", "9"))
    del table["folder"]
    assert table == {"name": "fast", "resume": True, "steps": 9}


@pytest.mark.parametrize(
    "words, sentence",
    [
        (["../up"], "name is '../up'; it must be letters"),
        (["--observation", "radar"], "observation is 'radar'; there are state, lidar, camera"),
        (["--randomize", "start,rain"], "randomize is 'rain'; there are start"),
        (["--steps", "0"], "steps is '0'; it must be a whole number, 1 or more"),
        (["--reward", "absent.py"], "there is no file 'absent.py'"),
        (["--track", "monza"], "track is 'monza'; there are default"),
        (["--race", "drag"], "race is 'drag'"),
    ],
)
def test_wrong_arguments_of_train(words, sentence):
    with pytest.raises(UsageError) as error:
        parsed(train, "train", *words)
    assert sentence in str(error.value)


def test_policies_by_name_and_file(trainings):
    assert policies.names() == ["blue"]
    path = str(trainings / "blue" / "policy.onnx")
    assert policies.resolve("blue") == policies.resolve(path) == path
    assert policies.settings(path) == {"observation": ["camera"]}
    for value in ("red", "green.onnx"):
        with pytest.raises(UsageError, match=f"policy is '{value}'; there are blue"):
            policies.resolve(value)


def test_evaluate_takes_several_tracks(trainings):
    options = parsed(evaluate, "evaluate", "blue", "--track", "hard", "easy", "--starts", "3")
    assert (options.track, options.starts) == (["hard", "easy"], 3)
    with pytest.raises(UsageError, match="starts is '0'"):
        parsed(evaluate, "evaluate", "blue", "--starts", "0")


def test_a_policys_lap_gets_its_sensors(trainings):
    options = parsed(lap, "lap", "--driver", "policy", "--policy", "blue")
    path = trainings / "blue" / "policy.onnx"
    assert lap.policy_arguments(options) == [
        f"policy:={path}",
        "camera_width:=160",
        "camera_height:=120",
    ]
    assert lap.policy_arguments(Namespace(driver="line", policy=None)) == []
    for driver, policy in (("policy", None), ("line", str(path))):
        with pytest.raises(UsageError, match="belong together"):
            lap.policy_arguments(Namespace(driver=driver, policy=policy))


def test_the_lists_of_learning_are_pinned():
    with open(learning.REQUIREMENTS, encoding="utf-8") as stream:
        lines = [line.strip() for line in stream if line.strip() and not line.startswith("#")]
    assert lines and all("==" in line for line in lines)
