"""Files of sweeps: what they become, and what is wrong with them; tables and plots."""

import csv
import json

import pytest
from paddock_gym.errors import GymError
from paddock_gym.simulation.randomize import RANDOMIZABLE
from paddock_gym.sweep import report, spec
from paddock_gym.sweep.spec import MISSED, TRIAL_TYPES, Range

PURSUIT = """of: pursuit
fixed: {starts: 2}
over:
  lookahead: [0.3, 0.5, 0.7]
  max_speed: [1, 2.0]
"""
TRAIN = """of: train
search: tpe
trials: 6
fixed: {steps: 1024, hyperparameters: base.json, track: mine.csv}
over:
  lr: {low: 0.0001, high: 0.01, log: true}
  batch_size: {low: 32, high: 64}
  observation: [state, "state,lidar"]
"""


def written(folder, text):
    """Path of a sweep's file."""
    path = folder / "sweep.yaml"
    path.write_text(text)
    return str(path)


def test_a_grid_of_gains(tmp_path):
    sweep = spec.load(written(tmp_path, PURSUIT))
    assert (sweep.of, sweep.search, sweep.trials, sweep.seed) == ("pursuit", "grid", 6, 0)
    assert sweep.over == {"lookahead": (0.3, 0.5, 0.7), "max_speed": (1, 2.0)}
    command = TRIAL_TYPES["pursuit"].command({"starts": 2, "lookahead": 0.3}, "out")
    assert json.loads(command[-1])["options"] == {"starts": 2, "lookahead": 0.3}


def test_trainings_with_hyperparameters_of_their_own(tmp_path):
    (tmp_path / "base.json").write_text('{"lr": 0.05, "num_epochs": 3}')
    (tmp_path / "mine.csv").write_text("")
    sweep = spec.load(written(tmp_path, TRAIN))
    assert sweep.over["lr"] == Range(0.0001, 0.01, log=True)
    assert sweep.over["batch_size"] == Range(32, 64, whole=True)
    assert sweep.at_once == 1
    options = {**sweep.fixed, "lr": 0.001, "observation": "state,lidar"}
    folder = tmp_path / "0000" / "files"
    folder.parent.mkdir()
    table = json.loads(TRIAL_TYPES["train"].command(options, str(folder))[-1])
    assert table["observation"] == ["state", "lidar"] and table["steps"] == 1024
    assert table["track"] == str(tmp_path / "mine.csv")
    given = json.loads((tmp_path / "0000" / "hyperparameters.json").read_text())
    assert given == {"lr": 0.001, "num_epochs": 3}


@pytest.mark.parametrize(
    "value, names",
    [
        ("all", list(RANDOMIZABLE)),
        ("nothing", []),
        ('"mass,friction"', ["mass", "friction"]),
        ("[mass, start]", ["mass", "start"]),
    ],
)
def test_what_is_random_in_a_training(value, names, tmp_path):
    sweep = spec.load(written(tmp_path, f"of: train\nover: {{randomize: [{value}]}}"))
    command = TRIAL_TYPES["train"].command({"randomize": sweep.over["randomize"][0]}, "out")
    assert json.loads(command[-1])["randomize"] == names


@pytest.mark.parametrize(
    "before, after, sentence",
    [
        ("of: pursuit", "of: drag", "of is 'drag'; it must be one of train, pursuit, goal"),
        ("fixed", "fix", "unknown key 'fix'; there are of, search"),
        ("lookahead", "look", "look is no option of pursuit; there are lookahead"),
        ("[0.3, 0.5, 0.7]", "[0.3, -1]", "lookahead is -1; it must be above 0"),
        ("[0.3, 0.5, 0.7]", "0.3", "lookahead is 0.3; it must be a list of values"),
        ("[0.3, 0.5, 0.7]", "{low: 3, high: 1}", "must have low and high, low the smaller"),
        ("[0.3, 0.5, 0.7]", "{low: 0, high: 1, log: true}", "with low above 0"),
        ("of: pursuit", "of: pursuit\ntrials: 3", "trials is 3; a grid has 6, remove the key"),
        ("of: pursuit", "of: pursuit\nsearch: tpe\ntrials: 0", "trials is 0; it must be from 1"),
        ("of: pursuit", "of: pursuit\nat_once: 0", "at_once is 0; it must be from 1 to 1000"),
        ("{starts: 2}", "{starts: 2, lookahead: 1}", "lookahead is in fixed and in over"),
        ("{starts: 2}", "{starts: none}", "starts is 'none'; it must be a whole number, 1 or more"),
        ("{starts: 2}", "{track: monza}", "monza: track is not found; valid: default"),
        ("{starts: 2}", "[1]", "fixed is [1]; it must be a table of options"),
        (PURSUIT, "of: goal\nover: {creep: [-1]}", "creep"),
        (PURSUIT, "of: goal", "over is missing"),
        (PURSUIT, "of: train\nover: {lr: [2]}", "lr is 2; it must be from 1e-08 to 0.1"),
        (PURSUIT, "of: train\nover: {observation: [radar]}", "observation is 'radar'"),
        (PURSUIT, "of: train\nover: {steps: [many]}", "steps is 'many'; it must be a whole"),
        (PURSUIT, "of: train\nover: {race: [drag]}", "race is 'drag'; there are time_trial"),
        (PURSUIT, "of: train\nover: {reward: [gone.py]}", "reward is 'gone.py'; it must be"),
        (PURSUIT, "of: train\nover: {randomize: [rain]}", "randomize has 'rain'; there are start"),
        (PURSUIT, 'of: train\nover: {randomize: ["all,mass"]}', "all and nothing stand alone"),
        (PURSUIT, "of: [", "is no YAML"),
        (PURSUIT, "3", "contains 3; it must be a table"),
    ],
)
def test_wrong_files_are_one_sentence(before, after, sentence, tmp_path):
    assert before in PURSUIT
    path = written(tmp_path, PURSUIT.replace(before, after))
    with pytest.raises(GymError) as error:
        spec.load(path)
    assert str(error.value).startswith(path) and sentence in str(error.value)
    assert "\n" not in str(error.value)


def test_the_table_has_the_best_first(tmp_path):
    rows = [
        {
            "number": number,
            "options": {"lookahead": lookahead, "track": f"/a/{lookahead}.csv"},
            "score": score,
            "report": {"good": 1, "starts": 2},
        }
        for number, (lookahead, score) in enumerate(((0.3, 9.0), (0.5, 7.0), (0.7, 8.0)))
    ]
    report.write(rows, ["lookahead", "track"], tmp_path)
    with open(tmp_path / report.TABLE, newline="") as stream:
        table = list(csv.DictReader(stream))
    assert [row["trial"] for row in table] == ["1", "2", "0"]
    assert table[0] == {
        "trial": "1",
        "lookahead": "0.5",
        "track": "/a/0.5.csv",
        "seconds": "7.0000",
        "good": "1",
        "starts": "2",
    }
    assert all(
        (tmp_path / name).stat().st_size > 1000 for name in (report.CURVE, report.OPTIONS_PLOT)
    )
    lines = report.text_table(rows, ["lookahead", "track"]).splitlines()
    assert lines[1].split() == ["1", "0.5", "0.5.csv", "7.00", "1", "of", "2"]


def test_a_training_without_laps_counts_its_misses():
    score = TRIAL_TYPES["train"].score
    assert score({"lap_times": [8.0, 10.0], "evaluated_starts": 4}) == (18.0 + 2 * MISSED) / 4
