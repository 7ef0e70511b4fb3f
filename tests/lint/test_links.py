"""Documents: links lead somewhere, each page is in the tree of the site, words are few."""

import os
import re
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
BUILT = ("build", "devel", "install", "out", "out-fresh", "site", "test-results")
SKIPPED = ("http://", "https://", "mailto:")
LINK = re.compile(r"\]\(([^)\s]+)\)")
CODE = re.compile(r"^```.*?^```|`[^`\n]*`", re.DOTALL | re.MULTILINE)
GENERATED = ("docs/beside-gazebo.md", "docs/supported.md", "docs/results.md")
LEFT_OUT = ("docs/tutorials/class/", "docs/ci/", "docs/tools/", "docs/support/")  # as in mkdocs.yml


def documents():
    """All *.md of the repository, without those that programs bring; git is not needed."""
    found = []
    for folder, folders, files in os.walk(ROOT):
        folders[:] = [name for name in folders if not name.startswith(".") or name == ".github"]
        if Path(folder) == ROOT:
            folders[:] = [name for name in folders if name not in BUILT]
        found += [Path(folder, name) for name in files if name.endswith(".md")]
    return sorted(path.relative_to(ROOT).as_posix() for path in found)


PAGES = documents()


def anchors(path):
    """The anchors of a page's headings, as GitHub and the site make them."""
    text = re.sub(r"^```.*?^```", "", path.read_text(), flags=re.DOTALL | re.MULTILINE)
    found = []
    for heading in re.findall(r"^#+ (.*)$", text, re.MULTILINE):
        plain = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", heading).lower()
        found.append(re.sub(r"\s", "-", re.sub(r"[^\w\s-]", "", plain).strip()))
    return found


@pytest.mark.parametrize("name", PAGES)
def test_links_lead_somewhere(name):
    path = ROOT / name
    for target in LINK.findall(CODE.sub("", path.read_text())):
        if target.startswith(SKIPPED):
            continue
        file, _, anchor = target.partition("#")
        found = (path.parent / file).resolve() if file else path
        assert found.exists(), f"{name}: {target}: there is no such file"
        if anchor:
            assert anchor in anchors(found), f"{name}: {target}: there is no such heading"


def tree(entry):
    """The pages of mkdocs.yml's nav."""
    if isinstance(entry, str):
        return [entry]
    values = entry.values() if isinstance(entry, dict) else entry
    return [page for value in values for page in tree(value)]


def test_each_page_of_docs_is_in_the_tree_once():
    text = re.sub(r"!!python\S*", "", (ROOT / "mkdocs.yml").read_text())
    listed = tree(yaml.safe_load(text)["nav"])
    assert len(set(listed)) == len(listed)
    pages = {
        name[5:] for name in PAGES if name.startswith("docs/") and not name.startswith(LEFT_OUT)
    }
    packages = {f"packages/{path.parent.name}.md" for path in (ROOT / "src").glob("*/README.md")}
    assert (pages | packages) - set(listed) == set()


def test_documents_are_short():
    """Words of all documents but for the pages that programs make."""
    words = sum(len((ROOT / name).read_text().split()) for name in PAGES if name not in GENERATED)
    assert words <= 38_000


# Wordings that readers could not use -> what to say instead.
UNCLEAR = {
    r"(Gazebo|Bullet)'s steps": "the solver `ode`, the solver `bullet`",
    r"as here\b|\b(than|as) there\b|\bthere and here\b|\bhere and there\b": "which one, by name",
    r"\b(runs?|works?|compiled|ignored|effect) here\b": "in Paddock",
    r"measured since|has come to until|as far as it is known|[Ww]hy is not known": "what is so",
    r"the (five|six|four|others) among them|of the (five|six) that": "names, or a number",
    r"empty seat|after one zero": "what happens, in plain words",
    r"\bcenterline\b": "center line, as the page says it",
    r"\b[Oo]urs?\b": "Paddock's",
    r"real time factor": "real-time factor",
    r"\bbefore / now\b|\bone run each\b, of other": "one state: that of today",
    r"it is used instead of ours|made from between": "which one is used; untested",
    r"github\.com/OWNER|\bREPOSITORY\b": "docs/project.yml has the address",
    r"\b[Aa]new\b|\b[Tt]oday\b|\bno longer\b|\b[Ss]till\b": "what is so, not how it came",
}


@pytest.mark.parametrize("name", [name for name in PAGES if name != "docs/supported.md"])
def test_wordings_are_clear(name):
    text = " ".join((ROOT / name).read_text().split())
    for pattern, better in UNCLEAR.items():
        found = re.search(f".{{0,40}}(?:{pattern}).{{0,20}}", text)
        assert not found, f"{name}: {found[0]!r}; say {better}"
