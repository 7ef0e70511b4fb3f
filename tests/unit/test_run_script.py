"""What ./run says to arguments that it cannot use: at once, before it sets anything up."""

import pathlib
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]


def run(*arguments):
    """Exit status and what was printed."""
    done = subprocess.run(
        [str(ROOT / "run"), *arguments], capture_output=True, text=True, timeout=30, check=False
    )
    return done.returncode, done.stdout + done.stderr


@pytest.mark.parametrize(
    "arguments, words",
    [
        (["fly"], ["fly", "setup, demo, lap"]),
        (["setup", "now"], ["usage: ./run setup"]),
        (["exec"], ["usage: ./run exec"]),
        (["lap", "--driver", "stig"], ["driver is 'stig'", "slider, buttons, line, pursuit"]),
        (["lap", "--track"], ["--track needs a value"]),
        (["lap", "--starts", "0"], ["starts is '0'", "above 0"]),
        (["lap", "--starts", "two"], ["starts is 'two'"]),
        (["lap", "easy"], ["unknown argument 'easy'"]),
    ],
)
def test_bad_arguments(arguments, words):
    status, output = run(*arguments)
    assert status != 0
    for word in words:
        assert word in output


@pytest.mark.parametrize(
    "command", ["", "setup", "demo", "lap", "test", "world", "teleop", "truck", "exec", "bench"]
)
def test_every_command_has_a_help(command):
    status, output = run(*command.split(), "--help")
    assert status == 0 and output.startswith(f"usage: ./run {command}".strip())
