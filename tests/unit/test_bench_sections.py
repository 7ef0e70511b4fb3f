"""Every section of the bench has its shape; efficiency refuses rounds that prove nothing."""

import importlib
import inspect
import sys
from pathlib import Path

import pytest

BENCH = Path(__file__).resolve().parents[2] / "bench"
sys.path.insert(0, str(BENCH))

from sections import SECTIONS, section  # noqa: E402


@pytest.mark.parametrize("name", SECTIONS)
def test_a_section_measures_and_tells(name):
    module = section(name)
    assert list(inspect.signature(module.measure).parameters)[0] == "quick"
    assert len(inspect.signature(module.measure).parameters) == 2
    assert list(inspect.signature(module.rows).parameters) == ["figures"]
    assert module.__doc__


@pytest.mark.parametrize("path", sorted((BENCH / "observers").glob("*.py")), ids=lambda p: p.stem)
def test_an_observer_can_be_imported(path):
    importlib.import_module(f"observers.{path.stem}")
