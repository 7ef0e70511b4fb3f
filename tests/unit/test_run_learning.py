"""./run train, evaluate and lap --driver policy: arguments, and what they become."""

import json
from argparse import Namespace

import pytest

from commands import environment, launching, processes
from commands.bootstrap import venv
from commands.errors import UsageError
from commands.parsing import parser_of
from commands.subcommands import cluster, evaluate, lap, train


@pytest.fixture
def trainings(tmp_path, monkeypatch):
    """A folder with one training of name `blue` and half of one of name `red`."""
    for name in ("blue", "red"):
        (tmp_path / name).mkdir()
    (tmp_path / "blue" / "policy.onnx").write_text("")
    (tmp_path / "blue" / "settings.json").write_text(json.dumps({"observation": ["camera"]}))
    monkeypatch.setattr(launching, "TRAININGS", str(tmp_path))
    return tmp_path


def parsed(module, name, *words):
    return parser_of(name, module).parse_args(words)


@pytest.mark.parametrize(
    "words, until_laps, threads, workers",
    [
        (["--observation", "camera"], True, None, train.max_processes()),
        (["--observation", "camera", "--threads"], True, True, train.WORLDS),
        (["--workers", "2"], True, None, 2),
        (["--steps", "900"], None, True, train.WORLDS),
        (["--env", "backing"], None, None, train.max_processes()),
        (["--ray", "auto"], None, None, 0),
        (["--resume", "--steps", "900"], False, None, None),
        (["--resume"], None, None, None),
    ],
)
def test_when_a_training_ends_and_its_workers(words, until_laps, threads, workers):
    table = train.wanted(parsed(train, "train", *words))
    found = tuple(table.get(name) for name in ("until_laps", "threads", "workers"))
    assert found == (until_laps, threads, workers)


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
    assert table == {"name": "fast", "resume": True, "steps": 9, "until_laps": False}


@pytest.mark.parametrize(
    "words, sentence",
    [
        (["../up"], "name is '../up'; it must be letters"),
        (["--observation", "radar"], "observation is 'radar'; there are state, lidar, camera"),
        (["--randomize", "start,rain"], "randomize is 'rain'; there are start"),
        (["--steps", "0"], "steps is '0'; it must be a whole number, 1 or more"),
        (["--reward", "absent.py"], "there is no file 'absent.py'"),
        (["--track", "monza"], "track is 'monza'; there are default"),
        (["--observation", "state,state"], "observation is 'state,state'; it must have each name"),
        (["--randomize", "mass,mass"], "randomize is 'mass,mass'; it must have each name once"),
        (["--randomize", "nothing,friction"], "randomize is 'nothing,friction'; all and nothing"),
        (["--randomize", "friction,all"], "randomize is 'friction,all'; all and nothing stand"),
        (["--race", "drag"], "race is 'drag'"),
        (["--race", "head_to_bot,time_trial"], "race is 'head_to_bot,time_trial'; there are time"),
        (["--track", "easy,hard"], "track is 'easy,hard'; there are default"),
        (["--ray", "box"], "ray is 'box'; it must be auto, or HOST:PORT"),
    ],
)
def test_wrong_arguments_of_train(words, sentence):
    with pytest.raises(UsageError) as error:
        parsed(train, "train", *words)
    assert sentence in str(error.value)


def test_policies_by_name_and_file(trainings):
    assert launching.policy_names() == ["blue"]
    path = str(trainings / "blue" / "policy.onnx")
    assert launching.resolve_policy("blue") == launching.resolve_policy(path) == path
    assert launching.policy_settings(path) == {"observation": ["camera"]}
    for value in ("red", "green.onnx"):
        with pytest.raises(UsageError, match=f"policy is '{value}'; there are blue"):
            launching.resolve_policy(value)


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
    (path.parent / "settings.json").write_text('{"observation": ["lidar"], "walls": true}')
    assert lap.policy_arguments(options) == [f"policy:={path}", "walls:=true", "lidar:=true"]
    assert lap.policy_arguments(Namespace(driver="line", policy=None)) == []
    for driver, policy in (("policy", None), ("line", str(path))):
        with pytest.raises(UsageError, match="belong together"):
            lap.policy_arguments(Namespace(driver=driver, policy=policy))


@pytest.mark.parametrize(
    "module, words, lists",
    [
        (train, ["train", "x"], ["learning"]),
        (evaluate, ["evaluate", "blue"], ["gym"]),
        (lap, ["lap", "--driver", "policy", "--policy", "blue"], ["gym"]),
        (lap, ["lap"], []),
    ],
)
def test_what_commands_install_beyond_the_set_up(trainings, monkeypatch, module, words, lists):
    asked = []
    monkeypatch.setattr(environment, "ready", dict)
    monkeypatch.setattr(venv, "prepare_extras", lambda *names: asked.extend(names))
    monkeypatch.setattr(processes, "become_module", lambda *_: None)
    monkeypatch.setattr(launching, "run", lambda *_, **__: None)
    module.run(parsed(module, *words), [])
    assert asked == lists


def test_more_workers_than_two_for_each_core_are_actors():
    limit = train.max_processes()
    assert "ray" not in train.wanted(parsed(train, "train", "--workers", str(limit)))
    table = train.wanted(parsed(train, "train", "--workers", str(limit + 1)))
    assert (table["ray"], table["workers"]) == ("auto", limit + 1)
    table = train.wanted(parsed(train, "train", "--ray", "10.0.0.1:6379"))
    assert (table["ray"], table["workers"]) == ("10.0.0.1:6379", 0)


@pytest.mark.parametrize("words", [["tail"], ["join"], ["join", "box"], ["head", "box:6379"]])
def test_wrong_arguments_of_cluster(words):
    with pytest.raises(UsageError) as error:
        cluster.wanted(parsed(cluster, "cluster", *words))
    assert f"cluster is {' '.join(words)!r}; it must be head" in str(error.value)


def test_a_training_of_backing_has_no_options_of_the_car():
    table = train.wanted(parsed(train, "train", "rig", "--env", "backing"))
    assert (table["env"], table["steps"]) == ("backing", train.STEPS["backing"])
    for words in (["--track", "easy"], ["--walls"], ["--observation", "lidar"]):
        with pytest.raises(UsageError, match=f"{words[0]} is an option of the DeepRacer"):
            train.wanted(parsed(train, "train", "rig", "--env", "backing", *words))
    with pytest.raises(UsageError, match="env is 'boat'; there are deepracer, backing"):
        parsed(train, "train", "--env", "boat")
