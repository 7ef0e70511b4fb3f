"""One version everywhere: pyproject.toml, packages, gym, changelog, ./run version."""

import re
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PROJECT = (ROOT / "pyproject.toml").read_text().partition("[project]")[2].partition("\n[")[0]
(VERSION,) = re.findall(r'^version = "(.*)"$', PROJECT, re.MULTILINE)


def test_all_packages_have_the_version():
    files = [ROOT / "tests" / "package.xml", *sorted((ROOT / "src").rglob("package.xml"))]
    assert len(files) > 50
    found = {str(path): ElementTree.parse(path).findtext("version") for path in files}
    assert {path: version for path, version in found.items() if version != VERSION} == {}


def test_the_gym_has_the_version():
    text = (ROOT / "src" / "paddock_gym" / "setup.py").read_text()
    assert re.findall(r'"version": "(.*)"', text) == [VERSION]


def test_the_changelog_begins_with_the_version():
    """Keep a Changelog's form: what comes, then versions, this one first."""
    text = (ROOT / "CHANGELOG.md").read_text()
    first, *headings = re.findall(r"^## (.*)$", text, re.MULTILINE)
    assert first == "[Unreleased]"
    pattern = r"\[(\d+)\.(\d+)\.(\d+)\] - (unreleased|\d{4}-\d\d-\d\d)"
    parts = [re.fullmatch(pattern, heading) for heading in headings]
    assert all(parts), headings
    numbers = [tuple(map(int, part.groups()[:3])) for part in parts]
    assert ".".join(map(str, numbers[0])) == VERSION
    assert numbers == sorted(set(numbers), reverse=True)
    assert all(part[4] != "unreleased" for part in parts[1:])
    kinds = {"Added", "Changed", "Deprecated", "Removed", "Fixed", "Security"}
    assert set(re.findall(r"^### (.*)$", text, re.MULTILINE)) <= kinds


def test_run_version_says_it():
    done = subprocess.run(
        [ROOT / "run", "version"], capture_output=True, text=True, timeout=60, check=True
    )
    first, second, third = done.stdout.splitlines()
    assert re.fullmatch(rf"Paddock {re.escape(VERSION)}( \([0-9a-f]+( changed)?\))?", first)
    assert f"Python {'.'.join(map(str, sys.version_info[:3]))}" in second
    assert re.fullmatch(r"built( on /\S+)?|not built yet: ./run setup", third)
