"""A step of set-up: what it prints while it works, when it fails and when it is interrupted."""

import contextlib
import fcntl
import os
import re
import signal
import subprocess
import sys
import time

import psutil
import pytest
from run_rig import PATIENCE, ROOT, usual_signals

# A step that runs one program, as cli would run it.
STEP = """
import sys
sys.path.insert(0, sys.argv[1])
from commands import cli
from commands.bootstrap import step
step.LOGS, step.EVERY, step.GRACE = sys.argv[2], 1, 0.5
work = lambda one: one.execute([sys.executable, "-c", sys.argv[3]], {"PATH": "/usr/bin:/bin"})
cli.dispatch = lambda _: step.Step(2, "Python packages", "Look there.", "probe").run(work)
sys.exit(cli.main([]))
"""


def start(folder, program):
    """Starts a step that runs a Python program."""
    return subprocess.Popen(
        [sys.executable, "-c", STEP, str(ROOT), str(folder), program],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=usual_signals,
    )


def test_a_step_that_is_done(tmp_path):
    process = start(tmp_path, "import time; print('words', flush=True); time.sleep(2.5)")
    said, wrong = process.communicate(timeout=PATIENCE)
    first, *ticks, last = said.splitlines()
    assert process.returncode == 0 and wrong == ""
    assert first == f"[2/3] Python packages ... (details in {tmp_path}/probe.log)"
    assert any(re.fullmatch(r"\[2/3\] Python packages \.\.\. \d+ s", tick) for tick in ticks)
    assert last.startswith("[2/3] Python packages done (") and last.endswith(" s)")
    assert (tmp_path / "probe.log").read_text() == "words\n"


def test_a_step_that_fails_says_why(tmp_path):
    process = start(
        tmp_path, "import sys; [print(n, flush=True) for n in range(30)]; sys.exit('no such thing')"
    )
    said, wrong = process.communicate(timeout=PATIENCE)
    assert process.returncode == 1
    head, *lines = said.splitlines()[1:]
    assert head.startswith("[2/3] Python packages FAILED after ")
    assert head.endswith(f" s. The end of {tmp_path}/probe.log:")
    assert len(lines) == 20 and "    | no such thing" in lines and "    | 29" in lines
    assert wrong.splitlines() == [
        "run: the step 'Python packages' failed",
        "     Look there.",
        "     Then start ./run again: finished steps are skipped.",
    ]


def members(group):
    """Process ids of a process group, without those that only wait to be reaped."""
    found = []
    for process in psutil.process_iter():
        with contextlib.suppress(psutil.Error, ProcessLookupError):
            if os.getpgid(process.pid) == group and process.status() != psutil.STATUS_ZOMBIE:
                found.append(process.pid)
    return found


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
@pytest.mark.parametrize("deaf", [False, True])
def test_a_step_that_is_interrupted(tmp_path, number, deaf):
    program = (
        "import os, signal, subprocess, time\n"
        f"signal.signal(signal.SIGINT, signal.{'SIG_IGN' if deaf else 'default_int_handler'})\n"
        "subprocess.Popen(['sleep', '10000'])\n"
        "print(os.getpid(), flush=True)\ntime.sleep(1e4)"
    )
    process = start(tmp_path, program)
    log = tmp_path / "probe.log"
    while process.poll() is None and not (log.exists() and log.read_text().endswith("\n")):
        time.sleep(0.01)
    process.send_signal(number)
    said, wrong = process.communicate(timeout=PATIENCE)
    assert process.returncode == 128 + number and wrong == ""
    assert said.endswith("\ninterrupted; start ./run again to go on\n")
    group, end = int(log.read_text().split()[0]), time.monotonic() + PATIENCE
    while members(group):  # the program and what it started
        assert time.monotonic() < end


# A set-up whose step runs a program.
LOCKED = STEP.replace(
    "cli.dispatch = lambda _: ",
    "step.LOCK = sys.argv[2] + '/lock'\ndef dispatch(_):\n    with step.SetupLock():\n        ",
).replace("sys.exit(", "cli.dispatch = dispatch\nsys.exit(")


def test_what_a_killed_set_up_has_left_keeps_the_lock(tmp_path):
    gate = tmp_path / "gate"
    os.mkfifo(gate)
    program = f"print('here', flush=True); open({str(gate)!r}).read()"
    process = subprocess.Popen(
        [sys.executable, "-c", LOCKED, str(ROOT), str(tmp_path), program],
        stdout=subprocess.DEVNULL,
        preexec_fn=usual_signals,
    )
    log, end = tmp_path / "probe.log", time.monotonic() + PATIENCE
    while not (log.exists() and log.read_text() == "here\n"):
        assert process.poll() is None and time.monotonic() < end
        time.sleep(0.01)
    process.kill()
    process.wait()
    with open(tmp_path / "lock", "w") as stream:
        try:
            with pytest.raises(BlockingIOError):
                fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
        finally:
            gate.write_text("")  # the program ends
        fcntl.flock(stream, fcntl.LOCK_EX)
