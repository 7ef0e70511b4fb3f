"""./run train, evaluate and lap --driver policy: arguments, and what they become."""

import json

import pytest
from run_rig import ROOT

from commands import cli, environment, launching, processes
from commands.bootstrap import venv
from commands.errors import UsageError
from commands.parsing import parser_of
from commands.subcommands import evaluate, train

MOST = train.max_processes()
EVERYTHING = (
    "fast --track hard --observation state,camera --walls --race head_to_bot --randomize all "
    f"--steps 1000 --workers 3 --seed 5 --reward {ROOT}/run --metadata {ROOT}/LICENSE "
    f"--hyperparameters {ROOT}/README.md"
)


@pytest.mark.parametrize("line, table", [
    ("--observation camera", {"until_laps": True, "threads": None, "workers": MOST}),
    ("--observation camera --threads",
     {"until_laps": True, "threads": True, "workers": train.WORLDS}),
    ("--workers 2", {"until_laps": True, "threads": None, "workers": 2}),
    ("--steps 900", {"until_laps": None, "threads": True, "workers": train.WORLDS}),
    ("rig --env backing", {"until_laps": None, "threads": None, "workers": MOST, "env": "backing",
                           "steps": train.STEPS["backing"]}),
    ("--ray auto", {"until_laps": None, "threads": None, "workers": 0}),
    ("--ray 10.0.0.1:6379", {"ray": "10.0.0.1:6379", "workers": 0}),
    ("--resume", {"until_laps": None, "threads": None, "workers": None}),
    ("fast --resume --steps 9", {"name": "fast", "resume": True, "steps": 9, "until_laps": False,
                                 "threads": None, "workers": None, "observation": None}),
    (f"--workers {MOST}", {"ray": None}),
    (f"--workers {MOST + 1}", {"ray": "auto", "workers": MOST + 1}),  # as actors
    (EVERYTHING, {"observation": ["state", "camera"], "randomize": list(train.RANDOM),
                  "reward": f"{ROOT}/run", "metadata": f"{ROOT}/LICENSE",
                  "hyperparameters": f"{ROOT}/README.md", "race": "head_to_bot", "walls": True,
                  "track": "hard", "steps": 1000, "workers": 3, "seed": 5}),
])  # fmt: skip
def test_what_a_training_is_told(line, table):
    found = train.wanted(parser_of("train", train).parse_args(line.split()))
    assert {name: found.get(name) for name in table} == table


@pytest.fixture
def trainings(tmp_path, monkeypatch):
    """A folder with one training of name `blue` and half of one of name `red`."""
    for name in ("blue", "red"):
        (tmp_path / name).mkdir()
    (tmp_path / "blue" / "policy.onnx").write_text("")
    (tmp_path / "blue" / "settings.json").write_text(json.dumps({"observation": ["camera"]}))
    monkeypatch.setattr(launching, "TRAININGS", str(tmp_path))
    return tmp_path


def test_policies_by_name_and_file(trainings):
    assert launching.policy_names() == ["blue"]
    path = str(trainings / "blue" / "policy.onnx")
    assert launching.resolve_policy("blue") == launching.resolve_policy(path) == path
    for value in ("red", "green.onnx"):
        with pytest.raises(UsageError, match=f"policy is '{value}'; there are blue"):
            launching.resolve_policy(value)


def test_evaluate_takes_several_tracks(trainings):
    words = ["blue", "--track", "hard", "easy", "--starts", "3"]
    options = parser_of("evaluate", evaluate).parse_args(words)
    assert (options.track, options.starts) == (["hard", "easy"], 3)


LAP = ["track:=default", "driver:=policy", "starts:=1", "policy:={}"]


@pytest.mark.parametrize("line, settings, lists, words", [
    ("train x", {}, ["learning"], []),
    ("evaluate blue", {}, ["gym"], []),
    ("lap", {}, [], ["track:=default", "driver:=slider", "starts:=1"]),
    ("lap --driver policy --policy blue", {"observation": ["camera"]}, ["gym"],
     [*LAP, "camera_width:=160", "camera_height:=120"]),
    ("lap --driver policy --policy blue", {"observation": ["lidar"], "walls": True}, ["gym"],
     [*LAP, "walls:=true", "lidar:=true"]),
])  # fmt: skip
def test_what_a_policy_needs(trainings, monkeypatch, line, settings, lists, words):
    """What commands install beyond the set-up; a lap's launch arguments for its sensors."""
    installed, given = [], []
    monkeypatch.setattr(environment, "ready", dict)
    monkeypatch.setattr(venv, "prepare_extras", lambda *names: installed.extend(names))
    monkeypatch.setattr(processes, "become_module", lambda *_: None)
    monkeypatch.setattr(launching, "run", lambda *words, **_: given.extend(words[3]))
    (trainings / "blue" / "settings.json").write_text(json.dumps(settings))
    cli.dispatch(line.split())
    assert installed == lists
    assert given == [word.format(trainings / "blue" / "policy.onnx") for word in words]
    if "--policy" in line:
        with pytest.raises(UsageError, match="belong together"):
            cli.dispatch(["lap", "--driver", "line", "--policy", "blue"])
