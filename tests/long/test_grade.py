"""grade.py of the lab with drivers that crash and that do not answer: each gets its row."""

import csv
import subprocess
import sys
from pathlib import Path

import mounted_root
import yaml

ROOT = Path(__file__).resolve().parents[2]
CLASS = ROOT / "docs" / "tutorials" / "class"
ANSWERS = (CLASS / "submissions" / "ben.py").read_text()


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
    words = [*mounted_root.words(tmp_path), sys.executable, str(CLASS / "grade.py")]
    words += [str(tmp_path / "task.yaml"), str(folder), str(marks)]
    done = subprocess.run(words, capture_output=True, text=True, timeout=900)
    assert done.returncode == 0, done.stderr
    rows = {row["name"]: row for row in csv.DictReader(marks.open())}
    outcomes = {name: row["outcome"] for name, row in rows.items()}
    assert outcomes == {"crash": "crashed", "silent": "no answer", "straight": "off track"}
    assert rows["crash"]["said"] == "ValueError: my mistake"
    assert "Traceback" in (tmp_path / "marks.crash.txt").read_text()
