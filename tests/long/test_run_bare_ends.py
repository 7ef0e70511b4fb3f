"""The end of a bare machine: by itself, by signals at each moment, by SIGKILL; nothing stays."""

import contextlib
import signal
import subprocess
import time

import psutil
import pytest
from bare_rig import Bare, where_it_works
from run_rig import PATIENCE

HOLD = "echo here; sleep 1000"


@pytest.fixture
def bare(tmp_path):
    """A clone."""
    return Bare(tmp_path)


def begun(bare, *arguments, **options):
    """Starts a machine and waits for the command's first line, which is `here`."""
    process = bare.start(*arguments, **options)
    while (line := process.stdout.readline()) != "here\n":
        assert line, process.wait()
    return process


@where_it_works
def test_interrupted_at_any_time(bare):
    """At times that are spread over a run: whatever it does then."""
    bare.tarball()
    begin = time.monotonic()
    assert bare.run("true").returncode == 0
    whole = time.monotonic() - begin
    for part in range(5):
        process = bare.start("true")
        time.sleep(whole * part / 5)
        status, said = bare.stopped(process)
        assert status in (0, 130, -signal.SIGINT) and bare.left() == [], said


@where_it_works
def test_a_killed_run_takes_its_processes_along(bare):
    process = begun(bare.tarball(), HOLD)
    process.kill()
    process.communicate(timeout=PATIENCE)
    end = time.monotonic() + PATIENCE
    while bare.processes():
        assert time.monotonic() < end
        time.sleep(0.05)
    assert set(bare.left()) <= set(map(str, bare.cache.glob("machine-*")))
    assert bare.run("true").returncode == 0 and bare.left() == []


@where_it_works
def test_the_folder_that_a_killed_run_has_left_goes_with_the_next_start(bare):
    process = begun(bare.tarball(), HOLD)
    # ./run stands while its children are killed: neither can remove the folder for the other
    process.send_signal(signal.SIGSTOP)
    for child in psutil.Process(process.pid).children(recursive=True):
        with contextlib.suppress(psutil.NoSuchProcess):  # ended with the one killed before it
            child.kill()
    process.kill()
    process.communicate(timeout=PATIENCE)
    (folder,) = bare.cache.glob("machine-*")
    done = bare.run("true")
    assert f"bare: removing {folder}, which a killed run has left\n" in done.stdout
    assert done.returncode == 0 and bare.left() == []


@where_it_works
def test_a_machine_that_is_in_use_stays(bare):
    process = begun(bare.tarball(), "echo here; read line; echo $line", stdin=subprocess.PIPE)
    (folder,) = bare.cache.glob("machine-*")
    done = bare.run("true")
    assert done.returncode == 0 and "removing" not in done.stdout
    assert [folder] == list(bare.cache.glob("machine-*"))
    assert process.communicate("goes on\n", timeout=PATIENCE)[0] == "goes on\n"
    assert process.returncode == 0 and bare.left() == []
