"""The project's address: one file has it, all others that name it are made of that."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "docs" / "tools"))

import project  # noqa: E402

ADDRESS, MAIL = "https://git.example.net/team/paddock", "team@example.net"
PLACEHOLDER = re.compile(r"example\.org|\bREPOSITORY\b|github\.com/OWNER")


def named():
    """The files that name the project."""
    return [path for pattern, _ in project.KINDS for path in sorted(ROOT.glob(pattern))]


def test_the_files_are_those_of_the_address():
    assert [path for path, _ in project.changed()] == []


@pytest.mark.parametrize("path", named(), ids=lambda path: str(path.relative_to(ROOT)))
def test_no_placeholder_stands_in_them(path):
    assert not PLACEHOLDER.search(path.read_text())


def test_each_line_to_clone_is_made_of_it():
    """Also those of pages that come later."""
    pages = subprocess.run(["git", "-c", f"safe.directory={ROOT}", "ls-files", "*.md", "*.yml"],
                           cwd=ROOT, capture_output=True, text=True).stdout.split()  # fmt: skip
    for page in pages or [str(path) for path in named()]:
        text = (ROOT / page).read_text()
        for line in re.findall(r"git clone .*paddock.*", text):
            held = project.CLONED.search(line) or "$PADDOCK_URL" in line
            assert held and ROOT / page in [*named(), ROOT / "docs/ci/simulation.yml"], page


def test_an_address_reaches_all_and_goes_again(tmp_path):
    for path in [*named(), ROOT / project.FILE]:
        copy = tmp_path / path.relative_to(ROOT)
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(path, copy)
    before = {path: path.read_text() for path in tmp_path.rglob("*") if path.is_file()}
    theirs = tmp_path / "src" / "theirs" / "package.xml"
    theirs.parent.mkdir(parents=True)
    theirs.write_text('<package><maintainer email="you@there.net">You</maintainer></package>')
    file = tmp_path / project.FILE
    file.write_text(f'repository: "{ADDRESS}"\ncontact: "{MAIL}"\n')
    for path, text in project.changed(tmp_path):
        assert path != theirs
        path.write_text(text)
    assert list(project.changed(tmp_path)) == []
    for name in ("README.md", "docs/ci.md", "docs/teaching.md", "CITATION.cff",
                 "docs/ci/simulation.yml", ".github/ISSUE_TEMPLATE/config.yml",
                 "src/bullet_sim/package.xml", "src/standins/xacro/package.xml"):  # fmt: skip
        assert ADDRESS in (tmp_path / name).read_text(), name
    assert MAIL in (tmp_path / "SECURITY.md").read_text()
    assert f'email="{MAIL}"' in (tmp_path / "src" / "bullet_sim" / "package.xml").read_text()
    file.write_text(before[file])
    for path, text in project.changed(tmp_path):
        path.write_text(text)
    assert {path: path.read_text() for path in before} == before
