"""grade.py of the lab with drivers that crash and that do not answer: each gets its row."""

import csv
import subprocess
import sys
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parents[2]
CLASS = ROOT / "docs" / "tutorials" / "class"
ANSWERS = (CLASS / "submissions" / "ben.py").read_text()


def graded(*words):
    return subprocess.run(words, capture_output=True, text=True, timeout=900)


def test_each_driver_has_its_row(tmp_path):
    folder = tmp_path / "handed-in"
    folder.mkdir()
    for name, text in {
        "crash": "raise ValueError('my mistake')",
        "silent": ANSWERS.replace("commands.publish(command)", "pass"),
        "straight": ANSWERS,
    }.items():
        (folder / f"{name}.py").write_text(text)
    task = {**yaml.safe_load((CLASS / "task.yaml").read_text()), "patience": 5}
    (tmp_path / "task.yaml").write_text(yaml.safe_dump(task))
    marks = tmp_path / "marks.csv"
    words = [sys.executable, str(CLASS / "grade.py"), str(tmp_path / "task.yaml"), str(folder)]
    done = graded(*words, str(marks))
    if (
        "drivers cannot be enclosed" in done.stderr
    ):  # as in a chroot: then it runs nothing by itself
        assert done.returncode == 1 and "--trust" in done.stderr and not marks.exists()
        done = graded(*words, str(marks), "--trust")
    assert done.returncode == 0, done.stderr
    rows = {row["name"]: row for row in csv.DictReader(marks.open())}
    outcomes = {name: row["outcome"] for name, row in rows.items()}
    assert outcomes == {"crash": "crashed", "silent": "no answer", "straight": "off track"}
    assert rows["crash"]["said"] == "ValueError: my mistake"
    assert "Traceback" in (tmp_path / "marks.crash.txt").read_text()
