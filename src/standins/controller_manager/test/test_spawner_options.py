"""Command lines and YAML files of spawner and unspawner; no ROS needed."""

import pytest
from controller_manager import command_line


def test_defaults_are_upstream_s():
    opts = command_line.parse_spawner(["a", "b"])
    assert opts.controllers == ["a", "b"] and opts.timeout == 30.0
    assert not opts.stopped and opts.wait_for is None and opts.namespace == ""


@pytest.mark.parametrize(
    "line, field, value",
    [
        ("--stopped a", "stopped", True),
        ("--wait-for /go a", "wait_for", "/go"),
        ("--namespace /racecar a", "namespace", "/racecar"),
        ("--namespace=/racecar a", "namespace", "/racecar"),
        ("-n racecar a", "namespace", "racecar"),
        ("--timeout 3.5 a", "timeout", 3.5),
        ("--timeout 0 a", "timeout", None),
        ("--timeout=-1 a", "timeout", None),
        ("--no-timeout a", "timeout", None),
        ("--shutdown-timeout 1 a", "controllers", ["a"]),
    ],
)
def test_flags(line, field, value):
    assert getattr(command_line.parse_spawner(line.split()), field) == value


def test_an_unspawner_waits_without_limit_as_upstream():
    assert command_line.parse_unspawner(["a"]).timeout is None
    assert command_line.parse_unspawner("--timeout 5 a".split()).timeout == 5.0


def test_yaml_file_gives_controllers_and_parameters(tmp_path):
    path = tmp_path / "two.yaml"
    path.write_text("b: {type: x/B}\nc: {type: x/C}\n")
    controllers, parameters = command_line.expand(["a", str(path), "b"])
    assert controllers == ["a", "b", "c"]
    assert parameters == {"b": {"type": "x/B"}, "c": {"type": "x/C"}}


@pytest.mark.parametrize("text", ["", "- a\n", "a: [\n"])
def test_bad_yaml_file_is_named(tmp_path, text):
    path = tmp_path / "bad.yaml"
    path.write_text(text)
    with pytest.raises(ValueError, match="bad.yaml"):
        command_line.expand([str(path)])


def test_no_controllers_is_exit_2():
    with pytest.raises(SystemExit) as error:
        command_line.parse_spawner(["--stopped"])
    assert error.value.code == 2
