"""What PyPI has no wheel of for this Python: compiled once, said, kept outside .venv."""

import itertools
import sys

import pytest
from packaging.requirements import Requirement

from commands.bootstrap import venv

PIN = "pybullet==9.8.7"
NUMPY = "numpy==1.0; python_version < '3.10'"
TAG = f"cp{sys.version_info[0]}{sys.version_info[1]}"


class Step:
    """Writes down what it runs, what it waits for, what it says and what it reaches."""

    def __init__(self, work):
        self.commands, self.waited, self.notes, self.reached = [], [], [], []
        for wanted in work(self):
            if isinstance(wanted, str):
                self.waited.append(wanted)
            else:
                self.commands.append(wanted)

    def note(self, text):
        self.notes.append(text)

    def reach(self, name):
        self.reached.append((name, len(self.commands)))


@pytest.fixture
def compile_(tmp_path, monkeypatch):
    """Calls venv._compile with a Python for which PyPI has no wheel; gives the Step."""
    (tmp_path / "requirements.txt").write_text(f"# a comment\n{PIN}\nother==1.0\n")
    monkeypatch.setattr(venv, "REQUIREMENTS", str(tmp_path / "requirements.txt"))
    monkeypatch.setattr(venv, "WHEELS", str(tmp_path / "wheels"))
    monkeypatch.setattr(venv, "WHEELS_UP_TO", (3, 0))

    monkeypatch.setenv("HOME", "/tmp")
    return lambda: Step(venv._compile)


def test_it_is_compiled_once_for_each_version_and_python(compile_, tmp_path):
    (tmp_path / "wheels").mkdir()
    for name in (f"pybullet-9.8.6-{TAG}-x.whl", "pybullet-9.8.7-cp10-x.whl"):
        (tmp_path / "wheels" / name).write_text("")
    assert len(compile_().commands) == 1
    (tmp_path / "wheels" / f"pybullet-9.8.7-{TAG}-{TAG}-linux_x86_64.whl").write_text("")
    step = compile_()
    assert (step.commands, step.notes) == ([], [])


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder for .venv with what pip would leave there, and its list of Python packages."""
    monkeypatch.setattr(venv, "VENV", str(tmp_path / "venv"))
    monkeypatch.setattr(venv, "VENV_STAMP", str(tmp_path / "venv" / ".stamp"))
    monkeypatch.setattr(venv, "REQUIREMENTS", str(tmp_path / "requirements.txt"))
    (tmp_path / "requirements.txt").write_text(
        f"{PIN}\n# a comment\nnumba==1.0; python_version > '3'\nllvmlite==1.0\nother==1.0  # why\n"
        f"{NUMPY}\n"
    )
    packages = tmp_path / "venv" / "lib" / "python3.99" / "site-packages"
    packages.mkdir(parents=True)
    (packages / "pybullet.so.so").write_text("with symbols")
    (packages / "other.so").write_text("with symbols")
    return packages


def test_all_that_the_solver_is_compiled_with_comes_first():
    """numba refuses the numpy of ROS Noetic's systems, and imports more where Python has less."""
    first = [pin for pin in venv._pins() if venv._name(pin) in venv.COMPILER]
    for python, machine in itertools.product(("3.8", "3.11"), ("x86_64", "aarch64")):
        there = {
            requirement.name
            for requirement in map(Requirement, first)
            if requirement.marker is None
            or requirement.marker.evaluate({"python_version": python, "platform_machine": machine})
        }
        # as the metadata of the pinned numba and of importlib_metadata name them
        old = {"numpy", "importlib_metadata", "zipp"} if python == "3.8" else set()
        assert there == {"numba", "llvmlite"} | old


def test_symbols_are_left_out_of_new_files(folder, monkeypatch):
    """A process that uses the old file keeps it, as does another .venv that shares it."""
    before = (folder / "pybullet.so.so").stat().st_ino
    for argv, _environ in venv._strip({}):
        assert argv[:3] == ["strip", "--strip-unneeded", "-o"]
        assert argv[3:] == [f"{folder}/pybullet.so.so.stripped", f"{folder}/pybullet.so.so"]
        (folder / "pybullet.so.so.stripped").write_text("without")
    assert (folder / "pybullet.so.so").read_text() == "without"
    assert (folder / "pybullet.so.so").stat().st_ino != before
    assert (folder / "other.so").read_text() == "with symbols"
    monkeypatch.setenv("PATH", "/nonexistent")
    assert list(venv._strip({})) == []
