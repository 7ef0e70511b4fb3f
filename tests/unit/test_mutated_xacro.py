"""xacro files changed at random, and those that read what they must not: a sentence, soon."""

import contextlib
import io
import os
import pathlib
import runpy
import sys

import mutations
import pytest
import xacro  # noqa: F401  # here, so that no child takes the time
from mutation_rig import problems

pytestmark = pytest.mark.isolated  # mutation_rig forks

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCRIPT = str(ROOT / "src" / "standins" / "xacro" / "xacro")
FILES = ("track_model/urdf/chassis", "track_model/urdf/racecar.urdf", "track_model/urdf/wheels")
FILES += ("cybertruck/urdf/common", "cybertruck/urdf/trailer", "cybertruck/urdf/cybertruck.urdf")
COUNT = int(os.environ.get("MUTATIONS", "40")) // len(FILES)
HEAD = '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">'
LAUGHS = "".join(f'<!ENTITY l{n} "{f"&l{n - 1};" * 10}">' for n in range(1, 12))


class Refused(Exception):
    """xacro has ended with a sentence."""


def expand(path):
    """Runs xacro in this process; returns what it gives.

    Raises:
        Refused: With what it says.
    """
    out, said = io.StringIO(), io.StringIO()
    sys.argv = [SCRIPT, str(path)]
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(said):
        try:
            runpy.run_path(SCRIPT, run_name="__main__")
        except SystemExit as end:
            if end.code:
                raise Refused(said.getvalue() or str(end.code)) from None
    return out.getvalue()


def loaded_from(path):
    """A function of a content that expands it from a file."""

    def load(content):
        path.write_bytes(content)
        try:
            expand(path)
        except Refused as refused:
            assert "Traceback" not in str(refused) and path.name in str(refused), str(refused)

    return load


@pytest.mark.parametrize("name", FILES)
def test_a_changed_file(name, tmp_path):
    source = ROOT / "src" / f"{name}.xacro"
    for other in source.parent.glob("*.xacro"):
        (tmp_path / other.name).write_bytes(other.read_bytes())
    assert "<robot" in expand(source)
    items = list(mutations.mutations(source.read_bytes(), mutations.xml_changed, COUNT, name))
    assert problems(items, loaded_from(tmp_path / source.name), Refused) == []


@pytest.mark.parametrize(
    "text",
    [
        f"<!DOCTYPE r [<!ENTITY l0 'lol'>{LAUGHS}]>{HEAD}<link name='a'>&l11;</link></robot>",
        HEAD + '<xacro:include filename="bad.xacro"/></robot>',
        HEAD + '<xacro:macro name="m"><xacro:m/></xacro:macro><xacro:m/></robot>',
        HEAD + '<xacro:property name="a" value="${b}"/><xacro:property name="b" value="${a}"/>'
        '<link name="${a}"/></robot>',
        HEAD + "<a>" * 20_000,
        HEAD + "<a>" * 20_000 + "</a>" * 20_000 + "</robot>",
        HEAD + "${" + "(" * 5000 + "}</robot>",
        HEAD + "${1/0}</robot>",
        HEAD + "${__import__('os').mkdir('made')}</robot>",
        HEAD + "${load_yaml('bad.yaml')}</robot>",
        HEAD + "${load_yaml('none.yaml')}</robot>",
    ],
    ids=lambda text: text[57:90],
)
def test_an_absurd_file(text, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bad.yaml").write_text("!!python/object/apply:os.mkdir ['made']")
    assert problems([("it", text.encode())], loaded_from(tmp_path / "bad.xacro"), Refused) == []
    assert not (tmp_path / "made").exists()


def test_an_external_entity_is_not_read(tmp_path):
    (tmp_path / "secret.txt").write_text("TOP SECRET")
    uri = (tmp_path / "secret.txt").as_uri()
    path = tmp_path / "x.xacro"
    path.write_text(f'<!DOCTYPE r [<!ENTITY x SYSTEM "{uri}">]>{HEAD}<a>&x;</a></robot>')
    assert "SECRET" not in expand(path)
