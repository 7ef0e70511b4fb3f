"""Streams and exit status of the scripts: those of ros_control's (noetic-devel)."""

import sys
from types import SimpleNamespace

import pytest
from controller_manager import command_line, groups
from controller_manager.client import ManagerError


class Manager:
    """A manager with a running, a stopped and a new controller, which refuses the name "no"."""

    STATES = (("a", "running"), ("b", "stopped"), ("c", "initialized"))

    def __init__(self, *_):
        pass

    def wait(self, *_):
        """It is there."""

    def load(self, name):
        """Whether it can be loaded."""
        return name != "no"

    unload = load

    def switch(self, start=(), stop=(), strict=True):
        """Whether all of them can be switched."""
        return "no" not in (*start, *stop)

    def call(self, service, *arguments):
        """What can be loaded; whether nothing is in the way of a reload."""
        if service == "list_controller_types":
            return SimpleNamespace(types=["x/Y"])
        assert service == "reload_controller_libraries"
        return SimpleNamespace(ok=arguments[0])

    def list(self):
        """What is loaded."""
        return [SimpleNamespace(name=n, state=s, claimed_resources=[]) for n, s in self.STATES]


class Missing(Manager):
    """A manager whose services fail."""

    def load(self, *_):
        """Fail."""
        raise ManagerError("the service failed")

    wait = list = load


@pytest.fixture(name="run")
def _run(monkeypatch, capsys):
    def run(main, *words, manager=Manager, params=None):
        """(exit status, stdout, stderr) of a script."""
        monkeypatch.setattr(sys, "argv", ["script", *words])
        monkeypatch.setattr(command_line.interface, "_manager", lambda service: manager())
        monkeypatch.setattr(groups, "ManagerClient", manager)
        for module in (command_line, groups):
            monkeypatch.setattr(module.nodes, "init_node", lambda *_, **__: None)
        monkeypatch.setattr(groups.rospy, "get_param", lambda name, default: params or default)
        try:
            status = main()
        except SystemExit as error:
            status = error.code
        out, err = capsys.readouterr()
        return status, out, err

    return run


@pytest.mark.parametrize(
    "words, status, out",
    [
        ("", 0, "usage"),
        ("nonsense", 1, "usage"),
        ("-h", 1, "usage"),
        ("list", 0, "'a' - '' ( running )"),
        ("lt", 0, "x/Y"),
        ("load a", 0, "Loaded 'a'"),
        ("load no", 0, "Error when loading 'no'"),
        ("load", 0, ""),
        ("unload no", 0, "Error when unloading 'no'"),
        ("start no", 0, "Error when starting ['no'] and stopping []"),
        ("stop a", 0, "Stopped ['a'] successfully"),
        ("spawn no", 0, "Error when loading 'no'\nError when starting ['no'] and stopping []"),
        ("kl a", 0, "Stopped ['a'] successfully\nUnloaded 'a' successfully"),
        ("reload-libraries --restore", 0, "Restore: True\nSuccessfully reloaded libraries"),
    ],
)
def test_controller_manager(run, words, status, out):
    seen = run(command_line.main, *words.split())
    assert (seen[0], seen[2]) == (status, "")
    assert seen[1].startswith(out)


def test_a_service_that_fails_is_on_stderr(run):
    for main, words in ((command_line.main, "load a"), (groups.main, "switch one")):
        seen = run(main, *words.split(), manager=Missing, params={"one": ["a"]})
        assert seen[:2] == (1, "") and "the service failed" in seen[2]


GROUPS = {"one": ["b"], "two": ["a"], "bad": ["no"]}


@pytest.mark.parametrize(
    "words, status, out, err",
    [
        ("", 1, "", "a command is missing"),
        ("nonsense", 2, "", "invalid choice"),
        ("list", 0, "Number of groups: 3\n  bad\n      no\n", ""),
        ("spawn one", 0, "Loaded 'b'\nStarted ['b'] successfully\n", ""),
        ("spawn none", 0, "", "There is no controller defined in group none"),
        ("switch none", 0, "", "There is no controller defined in group none"),
        ("switch one", 0, "Started ['b'] successfully\nStopped ['a'] successfully\n",
         "Unknown controller state initialized"),
        ("switch bad", 0, "Error when loading 'no'\nCancel group switching\n",
         "Unknown controller state initialized"),
    ],
)  # fmt: skip
def test_controller_group(run, words, status, out, err):
    seen = run(groups.main, *words.split(), params=GROUPS)
    assert seen[0] == status and seen[1].startswith(out)
    assert err in seen[2] and bool(err) == bool(seen[2])


@pytest.mark.parametrize(
    "parse, words, status, is_out",
    [
        (command_line.parse_unspawner, "", 1, True),
        (command_line.parse_unspawner, "-h", 1, True),
        (command_line.parse_unspawner, "--help", 1, True),
        (command_line.parse_spawner, "", 2, False),
        (command_line.parse_spawner, "--help", 0, True),
        (command_line.parse_spawner, "--nonsense a", 2, False),
    ],
)
def test_usage_of_spawner_and_unspawner(run, parse, words, status, is_out):
    seen = run(lambda: parse(words.split()))
    assert seen[0] == status and bool(seen[1]) == is_out and bool(seen[2]) != is_out
