"""What the bench reads from /proc: of files written here, and of this process."""

import os
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

from processes import (  # noqa: E402
    TICK,
    Machine,
    Thread,
    arguments_of,
    cpu_seconds,
    descendants,
    memory_bytes,
)


def stat_line(pid, parent, user, system, name="a name) (with brackets"):
    """A line of /proc/PID/stat; times in ticks."""
    return f"{pid} ({name}) S {parent} 1 1 0 -1 4194304 9 9 9 9 {user} {system} 77 88 20 0 1 0 5\n"


@pytest.fixture
def proc(tmp_path):
    """A /proc with process 10, its child 11, whose child is 12, and process 20."""
    for pid, parent, user, system in (
        (10, 1, 300, 50),
        (11, 10, 5, 5),
        (12, 11, 0, 0),
        (20, 1, 1, 1),
    ):
        (tmp_path / str(pid)).mkdir()
        (tmp_path / str(pid) / "stat").write_text(stat_line(pid, parent, user, system))
    (tmp_path / "10" / "cmdline").write_bytes(b"python3\0-m\0a.module\0")
    (tmp_path / "10" / "smaps_rollup").write_text("0-1 ---p [rollup]\nRss: 9 kB\nPss: 2048 kB\n")
    task = tmp_path / "10" / "task" / "10"
    task.mkdir(parents=True)
    (task / "schedstat").write_text("1500000000 250000000 99\n")
    (task / "status").write_text(
        "Name:\tpython3\nvoluntary_ctxt_switches:\t7\nnonvoluntary_ctxt_switches:\t3\n"
    )
    (tmp_path / "stat").write_text(
        "cpu  1000 100 500 90000 300 20 30 40 5 5\ncpu0 1 1 1 1 1 1 1 1 1 1\nbtime 1\n"
    )
    (tmp_path / "uptime").write_text("1 1\n")
    return tmp_path


def test_cpu_seconds_are_user_and_system_time(proc):
    assert cpu_seconds(10, proc) == 350 / TICK


def test_a_process_that_is_gone_reads_as_nothing(proc):
    assert cpu_seconds(99, proc) == 0.0
    assert memory_bytes(99, proc) == 0
    assert arguments_of(99, proc) == []
    assert descendants(99, proc) == []
    assert Thread.read(99, 99, proc) is None


def test_children_and_theirs_are_found(proc):
    assert descendants(10, proc) == [11, 12]
    assert sorted(descendants(1, proc)) == [10, 11, 12, 20]


def test_memory_is_the_proportional_set_size(proc):
    assert memory_bytes(10, proc) == 2048 * 1024


def test_arguments(proc):
    assert arguments_of(10, proc) == ["python3", "-m", "a.module"]


def test_the_machine_is_busy_without_waiting_and_stolen_time(proc):
    machine = Machine.read(proc)
    assert machine.busy == pytest.approx((1000 + 100 + 500 + 20 + 30) / TICK)
    assert machine.stolen == pytest.approx(40 / TICK)


def test_a_stat_file_of_another_form_is_an_error(proc):
    (proc / "stat").write_text("intr 5\n")
    with pytest.raises(ValueError, match="begins with 'intr 5'"):
        Machine.read(proc)


def test_a_thread_tells_its_times_and_switches(proc):
    thread = Thread.read(10, 10, proc)
    assert (thread.cpu, thread.waited) == (pytest.approx(1.5), pytest.approx(0.25))
    assert (thread.voluntary, thread.involuntary) == (7, 3)


def test_a_kernel_without_schedstat_tells_no_thread(proc):
    (proc / "10" / "task" / "10" / "schedstat").unlink()
    assert Thread.read(10, 10, proc) is None


def test_this_process_is_read_as_it_counts_itself():
    pid, thread = os.getpid(), threading.get_native_id()
    before, counted = Thread.read(pid, thread), cpu_seconds(pid)
    machine = Machine.read()
    begin = time.thread_time()
    while time.thread_time() - begin < 0.2:
        pass
    after = Thread.read(pid, thread)
    own = time.thread_time() - begin
    assert 0.2 <= after.cpu - before.cpu <= own + 0.02
    assert cpu_seconds(pid) - counted >= 0.2 - 2 / TICK
    assert Machine.read().busy - machine.busy >= 0.2 - 4 / TICK
    time.sleep(0.01)
    assert Thread.read(pid, thread).voluntary > after.voluntary


def test_a_child_of_this_process_is_found_while_it_lives():
    child = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE)
    try:
        assert child.pid in descendants(os.getpid())
    finally:
        child.communicate(b"\n")
    assert child.pid not in descendants(os.getpid())
    assert memory_bytes(os.getpid()) > 1e6
