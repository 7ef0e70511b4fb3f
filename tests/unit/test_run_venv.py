"""What PyPI has no wheel of for this Python: compiled once, said, kept outside .venv."""

import sys

import pytest

from commands.bootstrap import venv

PIN = "pybullet==9.8.7"
TAG = f"cp{sys.version_info[0]}{sys.version_info[1]}"


class Step:
    """Writes down what it is asked to run and to say."""

    def __init__(self):
        self.commands, self.notes = [], []

    def execute(self, argv, environ):
        self.commands.append((argv, environ))

    def note(self, text):
        self.notes.append(text)


@pytest.fixture
def compile_(tmp_path, monkeypatch):
    """Calls venv._compile with a Python for which PyPI has no wheel; gives the Step."""
    (tmp_path / "requirements.txt").write_text(f"# a comment\n{PIN}\nother==1.0\n")
    monkeypatch.setattr(venv, "REQUIREMENTS", str(tmp_path / "requirements.txt"))
    monkeypatch.setattr(venv, "WHEELS", str(tmp_path / "wheels"))
    monkeypatch.setattr(venv, "WHEELS_UP_TO", (3, 0))

    def call():
        step = Step()
        venv._compile(step, {"HOME": "/tmp"})
        return step

    return call


def test_it_is_compiled_against_debians_numpy_and_said(compile_, tmp_path):
    step = compile_()
    (argv, environ), (note,) = *step.commands, step.notes
    assert argv[-2:] == [str(tmp_path / "wheels"), PIN]
    assert {"wheel", "--no-deps", "--no-build-isolation", "--no-cache-dir"} <= set(argv)
    assert "incompatible-pointer-types" in environ["CFLAGS"] and environ["HOME"] == "/tmp"
    python = f"{sys.version_info[0]}.{sys.version_info[1]}"
    assert note.startswith(f"PyPI has no pybullet for Python {python}: compiling it, once;")


def test_it_is_compiled_once_for_each_version_and_python(compile_, tmp_path):
    (tmp_path / "wheels").mkdir()
    for name in (f"pybullet-9.8.6-{TAG}-x.whl", "pybullet-9.8.7-cp10-x.whl"):
        (tmp_path / "wheels" / name).write_text("")
    assert len(compile_().commands) == 1
    (tmp_path / "wheels" / f"pybullet-9.8.7-{TAG}-{TAG}-linux_x86_64.whl").write_text("")
    step = compile_()
    assert (step.commands, step.notes) == ([], [])


def test_nothing_is_compiled_where_there_is_a_wheel_or_no_such_pin(compile_, monkeypatch, tmp_path):
    (tmp_path / "requirements.txt").write_text("other==1.0\n")
    assert compile_().commands == []
    (tmp_path / "requirements.txt").write_text(f"{PIN}\n")
    monkeypatch.setattr(venv, "WHEELS_UP_TO", sys.version_info[:2])
    assert compile_().commands == []
