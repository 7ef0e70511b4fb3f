"""What the tutorials name exists: commands, launch files and arguments, nodes, links."""

import ast
import os
import shlex

import page as tutorial
import pytest
import yaml
from run_rig import ROOT

from commands import parsing
from commands.cli import subcommand
from commands.errors import UsageError
from commands.launching import LaunchFile
from commands.table import COMMANDS, DEFAULT

DEBIAN = {"bash", "python", "roscore", "rosbag", "rostopic", "rosservice"}  # after ./run exec
PACKAGES = {path.parent.name: path.parent for path in (ROOT / "src").rglob("package.xml")}
PACKAGES["yard_fleet"] = ROOT / "tests" / "drop_in" / "yard_fleet"


def words_of(line):
    """Splits a line; "timeout 6" in front and what follows a bar are left out."""
    words = shlex.split(line.split("||")[0], comments=True)
    return words[2:] if words[:1] == ["timeout"] else words


def check(line):
    """Raises where a command line names something that does not exist."""
    words = words_of(line)
    if words[:1] != ["./run"]:
        return
    words = words[1:]
    if words and words[0] == "exec":
        check_exec(words[1:])
    elif not words or ":=" in words[0]:
        subcommand(DEFAULT).LAUNCH.check(settled(words))
    else:
        assert words[0] in COMMANDS, line
        module = subcommand(words[0])
        if hasattr(module, "add_arguments") or hasattr(module, "LAUNCH"):
            arguments = settled(words[1:])
            _, rest = parsing.parser_of(words[0], module).parse_known_args(arguments)
            launch = module.BACK if "--back" in words else getattr(module, "LAUNCH", None)
            if rest and launch:
                launch.check(rest)


def settled(words):
    """Puts a track that exists in the place of one that the reader makes."""
    home = ("~/lessons", "$HOME/lessons")
    return [
        "easy" if word.startswith(home) else "track:=easy" if "lessons" in word else word
        for word in words
    ]


def check_exec(words):
    """Checks what follows ./run exec."""
    tool, *arguments = words
    if tool == "roslaunch":
        package, name, *given = arguments
        path = PACKAGES[package] / "launch" / name
        assert path.is_file(), path
        launch = LaunchFile(package, name)
        launch.path = str(path)
        launch.check(given)
    elif tool == "rosrun":
        folders = ("nodes", "scripts")
        paths = [PACKAGES[arguments[0]] / folder / arguments[1] for folder in folders]
        assert any(os.access(path, os.X_OK) for path in paths), words
    else:
        assert tool in DEBIAN, words
        if tool == "python" and not arguments[0].startswith(("~", "...")):
            assert (ROOT / arguments[0]).is_file()


def test_there_are_pages():
    names = [path.stem for path in tutorial.PAGES]
    assert len(names) == 10
    index = tutorial.links(ROOT / "docs" / "tutorials" / "README.md")
    assert sorted(target for target in index) == [f"{name}.md" for name in names]


@pytest.mark.parametrize("path", tutorial.PAGES, ids=lambda path: path.stem)
def test_commands_exist(path):
    lines = tutorial.commands(path)
    assert any(line.startswith("./run") for line in lines)
    for line in lines:
        try:
            check(line)
        except (UsageError, KeyError) as error:
            raise AssertionError(f"{path.name}: {line}: {error}") from None


@pytest.mark.parametrize("path", tutorial.PAGES, ids=lambda path: path.stem)
def test_files_and_links(path):
    for box in tutorial.boxes(path):
        if box.path.endswith(".py"):
            ast.parse(box.text)
        elif box.path:
            assert yaml.safe_load(box.text)
    for target in tutorial.links(path):
        assert (path.parent / target).exists(), f"{path.name}: {target}"


@pytest.mark.parametrize(
    "line",
    [
        "./run fly",
        "./run trak:=easy",
        "./run exec roslaunch track_model no.launch",
        "./run exec roslaunch deepracer_control control.launch mood:=x",
        "./run exec rosrun track_model no",
        "./run lap --driver nobody",
        "./run exec python docs/no.py",
    ],
)
def test_what_does_not_exist_is_found(line):
    with pytest.raises((AssertionError, UsageError)):
        check(line)
