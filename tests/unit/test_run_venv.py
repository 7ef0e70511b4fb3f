"""What PyPI has no wheel of for this Python: compiled once, said, kept outside .venv."""

import itertools
import sys
from types import SimpleNamespace

from packaging.requirements import Requirement

from commands.bootstrap import venv

PIN = "pybullet==9.8.7"
TAG = f"cp{sys.version_info[0]}{sys.version_info[1]}"


def test_it_is_compiled_once_for_each_version_and_python(tmp_path, monkeypatch):
    (tmp_path / "requirements.txt").write_text(f"# a comment\n{PIN}\nother==1.0\n")
    monkeypatch.setattr(venv, "REQUIREMENTS", str(tmp_path / "requirements.txt"))
    monkeypatch.setattr(venv, "WHEELS", str(tmp_path / "wheels"))
    monkeypatch.setattr(venv, "WHEELS_UP_TO", (3, 0))  # PyPI has none for this Python
    (tmp_path / "wheels").mkdir()
    step = SimpleNamespace(note=lambda _: None, reach=lambda _: None)
    for name, count in (
        ("pybullet-9.8.6-{0}-x.whl", 1), ("pybullet-9.8.7-cp10-x.whl", 1),
        ("pybullet-9.8.7-{0}-{0}-linux_x86_64.whl", 0),
    ):  # fmt: skip
        (tmp_path / "wheels" / name.format(TAG)).write_text("")
        commands = [wanted for wanted in venv._compile(step) if not isinstance(wanted, str)]
        assert len(commands) == count, name


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
