"""A step of set-up: what it prints while it works, when it fails and when it is interrupted."""

import contextlib
import fcntl
import json
import os
import re
import signal
import subprocess
import sys
import threading
import time

import psutil
import pytest
import run_rig
from run_rig import PATIENCE, ROOT, usual_signals

from commands.bootstrap import step as bootstrap_step

# Steps beside each other: each runs the Python programs that a table has of it, or awaits a name.
# The one called Speaking says itself what it does.
BESIDE = """
import json, sys
sys.path.insert(0, sys.argv[1])
from commands import cli
from commands.bootstrap import step
step.LOGS, step.EVERY, step.GRACE = sys.argv[2], 1, 0.5
def made(number, title, programs, *promises):
    def work(self):
        for program in programs:
            if program.startswith("reach "):
                self.reach(program[6:])
            elif " " in program:
                yield [sys.executable, "-c", program], {"PATH": "/usr/bin:/bin"}
            else:
                yield program
    kind = step.SpeakingStep if title == "Speaking" else step.Step
    return kind(number, title, work, "Look there.", title.lower(), promises, of=2)
cli.dispatch = lambda _: step.run_beside([made(*each) for each in json.loads(sys.argv[3])])
sys.exit(cli.main([]))
"""


def beside(folder, *steps, script=BESIDE):
    """Starts steps, given as (number, title, programs, *promises)."""
    return subprocess.Popen(
        [sys.executable, "-c", script, str(ROOT), str(folder), json.dumps(steps)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=usual_signals,
    )  # fmt: skip


def start(folder, program):
    """Starts a step that runs a Python program, which has a blank in it."""
    return beside(folder, (1, "Probe", [program]))


def test_a_step_that_is_done(tmp_path):
    process = start(tmp_path, "import time; print('words', flush=True); time.sleep(2.5)")
    said, wrong = process.communicate(timeout=PATIENCE)
    first, *ticks, last = said.splitlines()
    assert process.returncode == 0 and wrong == ""
    assert first == f"[1/2] Probe ... (details in {tmp_path}/probe.log)"
    assert any(re.fullmatch(r"\[1/2\] Probe \.\.\. \d+ s", tick) for tick in ticks)
    assert last.startswith("[1/2] Probe done (") and last.endswith(" s)")
    assert (tmp_path / "probe.log").read_text() == "words\n"


def test_a_step_that_fails_says_why(tmp_path):
    process = start(
        tmp_path, "import sys; [print(n, flush=True) for n in range(30)]; sys.exit('no such thing')"
    )
    said, wrong = process.communicate(timeout=PATIENCE)
    assert process.returncode == 1
    head, *lines = said.splitlines()[1:]
    assert head.startswith("[1/2] Probe FAILED after ")
    assert head.endswith(f" s. The end of {tmp_path}/probe.log:")
    assert len(lines) == 20 and "    | no such thing" in lines and "    | 29" in lines
    assert wrong.splitlines() == [
        "run: the step 'Probe' failed",
        "     Look there.",
        "     Then start ./run again: finished steps are skipped.",
    ]


@pytest.mark.parametrize(
    "error",
    [
        "CMake Error at a/CMakeLists.txt:3 (find_package):",
        "/w/src/a.cpp:1:10: fatal error: b.h: No such file or directory",
        "error: subprocess-exited-with-error",
        "\x1b[01m\x1b[K/w/a.cpp:1:2:\x1b[m\x1b[K \x1b[01;31m\x1b[Kerror: \x1b[m\x1b[Kb",
    ],
)
def test_the_first_error_is_shown_beside_the_end(tmp_path, error):
    lines = [*map(str, range(9)), error, *map(str, range(10, 60))]
    text = f"print({chr(10).join(lines)!r}, flush=True); raise SystemExit(1)"
    said, _ = start(tmp_path, text).communicate(timeout=PATIENCE)
    _, _, *shown = said.splitlines()
    assert shown[:8] == [f"    | {n}" for n in (error, 10, 11, 12, 13, 14, "...", 41)]
    assert len(shown) == 27


def test_errors_in_the_output_of_an_earlier_program_are_not_shown(tmp_path):
    """Those of packages of a user, which are left out then."""
    goes_on = "print('CMake Error at a:')"
    fails = "print(*range(40), sep=chr(10)); raise SystemExit(1)"
    said, _ = beside(tmp_path, (1, "Probe", [goes_on, fails])).communicate(timeout=PATIENCE)
    assert "CMake Error" not in said and len(said.splitlines()) == 22


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


# The same within the lock, a file of that name.
LOCKED = BESIDE.replace(
    "cli.dispatch = lambda _: ",
    "step.LOCK = sys.argv[2] + '/lock'\ndef dispatch(_):\n    with step.SetupLock():\n        ",
).replace("sys.exit(cli", "cli.dispatch = dispatch\nsys.exit(cli")


def test_what_a_killed_set_up_has_left_keeps_the_lock(tmp_path):
    gate = tmp_path / "gate"
    os.mkfifo(gate)
    program = f"print('here', flush=True); open({str(gate)!r}).read()"
    process = beside(tmp_path, (1, "Probe", [program]), script=LOCKED)
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


def test_steps_run_beside_each_other_and_wait_for_what_was_promised(tmp_path):
    """The first one waits for the second one in the middle, and is waited for in its middle."""
    gate = tmp_path / "gate"
    os.mkfifo(gate)
    process = beside(
        tmp_path,
        (1, "First", [f"open({str(gate)!r}) .read()", "reach half", "whole", "print( 1)"], "half"),
        (2, "Second", ["half", f"print( open({str(tmp_path / 'first.log')!r}).read())"], "whole"),
        (2, "Third", [f"open({str(gate)!r}, 'w').write('')"]),
        (2, "Nothing", ["half"]),
    )
    said, wrong = process.communicate(timeout=PATIENCE)
    assert (process.returncode, wrong) == (0, "")
    ends = re.findall(r"\[(\d/2)\] (\w+) done", said)
    assert ends.index(("2/2", "Second")) < ends.index(("1/2", "First"))
    assert ("2/2", "Third") in ends and "Nothing" not in said
    assert (tmp_path / "second.log").read_text() == "\n"
    assert (tmp_path / "first.log").read_text() == "1\n"


def test_a_step_that_fails_ends_those_beside_it(tmp_path):
    """Only the installation of Debian packages goes on to its end."""
    started, ended = tmp_path / "started", tmp_path / "ended"
    process = beside(
        tmp_path,
        (1, "Speaking", [f"import time; time.sleep(1.5); open({str(ended)!r}, 'w')"], "late"),
        (2, "Long", [f"import time; open({str(started)!r}, 'w'); time.sleep(1e4)"]),
        (2, "Waiting", ["late", "print( 1)"]),
        (2, "Failing", [f"import os, sys\nwhile not os.path.exists({str(started)!r}): pass\n"
                        "sys.exit('no')"]),
    )  # fmt: skip
    said, wrong = process.communicate(timeout=PATIENCE)
    assert process.returncode == 1 and ended.exists()
    assert "[2/2] Long stopped\n" in said and "Waiting" not in said
    failed = said.partition("[2/2] Failing FAILED after ")[2]
    assert "\n    | no\n    | python" in failed and failed.endswith(" ended with exit status 1\n")
    assert wrong.splitlines()[:2] == ["run: the step 'Failing' failed", "     Look there."]
    assert not [line for line in run_rig.processes_of(tmp_path) if "1e4" in line]


def test_who_waits_for_another_setup_is_told_which_step_it_is_in(tmp_path, monkeypatch, capfd):
    """Once a while, as a build takes minutes: `source setup.bash` had said one line."""
    monkeypatch.setattr(bootstrap_step, "LOCK", str(tmp_path / "lock"))
    monkeypatch.setattr(bootstrap_step, "SILENT", 0.05)
    monkeypatch.setattr(bootstrap_step, "EVERY", 0.2)

    def enter():
        with bootstrap_step.SetupLock():
            pass

    told, waiting = "", threading.Thread(target=enter)
    with bootstrap_step.SetupLock():
        bootstrap_step.tell_waiting("[3/4] Workspace")
        waiting.start()
        deadline = time.monotonic() + PATIENCE
        while told.count("waiting for it: [3/4] Workspace\n") < 2 and time.monotonic() < deadline:
            told += capfd.readouterr().err
            time.sleep(0.05)
    waiting.join(PATIENCE)
    assert told.startswith("another ./run is setting up, waiting for it: [3/4] Workspace\n" * 2)
    assert (tmp_path / "lock").read_text() == ""
