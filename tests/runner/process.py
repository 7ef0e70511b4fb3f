"""Running one job as a process group of its own, to its end or its deadline."""

import contextlib
import os
import shutil
import signal
import subprocess
import tempfile
import threading
import time
from pathlib import Path

from runner.job import ROOT, Outcome
from runner.junit import count

MARK = "PADDOCK_TEST_JOB"  # variable by which all that a job has started is known
STOP_GRACE = 20.0  # wall time between SIGINT and SIGKILL [s]
POLL = 0.05  # wall time between two looks at processes [s]
END_GRACE = 30.0  # wall time that what a job has started may outlive it [s]


class Runner:
    """Runs jobs, each in the thread that asks for it, and can end all of them.

    Args:
        stop_grace: Wall time between SIGINT and SIGKILL [s].
    """

    def __init__(self, stop_grace=STOP_GRACE):
        self._stop_grace = stop_grace
        self._lock = threading.Lock()
        self._processes = set()
        self._closed = False

    def run(self, job, deadline):
        """Runs a job to its end or its deadline and counts what it left.

        Args:
            job: Job.
            deadline: Wall time [s].

        Returns:
            Outcome.
        """
        begin = time.monotonic()
        shutil.rmtree(job.directory, ignore_errors=True)
        job.directory.mkdir(parents=True)
        with tempfile.TemporaryDirectory(prefix="paddock_", ignore_cleanup_errors=True) as folder:
            try:
                status, cpu, remaining = self._run(job, deadline, Path(folder))
            except OSError as error:  # its command cannot be started
                outcome = Outcome(failures=[str(error)])
            else:
                outcome = judge(job, status, deadline)
                outcome.cpu = cpu
                if remaining:
                    outcome.failures.append(f"left processes behind: {', '.join(remaining)}")
        outcome.seconds = time.monotonic() - begin
        return outcome

    def _run(self, job, deadline, folder):
        """Runs a job.

        Returns:
            (exit status, None past the deadline; processor time [s]; what had to be ended).
        """
        environment = environment_of(job, folder)
        with job.log.open("w") as stream:
            process = self._start(job, environment, stream)
            try:
                cpu = wait_end(process.pid, deadline)
                if cpu is None:
                    stop(process, self._stop_grace)
                status = None if cpu is None else process.wait()
            finally:
                with self._lock:
                    self._processes.discard(process)
        remaining = end_marked(environment[MARK], END_GRACE if status is not None else 0.0)
        return status, cpu or 0.0, remaining

    def _start(self, job, environment, stream):
        with self._lock:
            if self._closed:
                raise InterruptedError("the test run has been ended")
            process = subprocess.Popen(
                job.command,
                stdout=stream,
                stderr=subprocess.STDOUT,
                stdin=subprocess.DEVNULL,
                cwd=ROOT,
                env=environment,
                start_new_session=True,
            )
            self._processes.add(process)
            return process

    def close(self):
        """Ends all jobs that run, and lets no further one start."""
        with self._lock:
            self._closed = True
            processes = list(self._processes)
        threads = [
            threading.Thread(target=stop, args=(item, self._stop_grace)) for item in processes
        ]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()


def environment_of(job, folder):
    """Gives a job's variables; nothing that it writes by itself is shared with another job.

    Args:
        job: Job.
        folder: Directory for the job's temporary files.
    """
    own = {
        MARK: folder.name,
        "TMPDIR": str(folder),
        "ROS_HOME": str(job.directory / "ros_home"),
        "PYTHONPYCACHEPREFIX": str(ROOT / ".cache" / "pycache"),  # compiled once, not in src
    }
    inherited = {key: os.environ[key] for key in os.environ if key != "PYTHONDONTWRITEBYTECODE"}
    return {**inherited, **own, **job.environment}


def judge(job, status, deadline):
    """Counts what a job left and adds what its end says.

    Args:
        job: Job that has ended.
        status: Its exit status; None if its deadline [s] came first.
        deadline: Wall time [s].

    Returns:
        Outcome.
    """
    outcome = count(job.directory) if job.counted else Outcome()
    if status is None:
        outcome.failures.append(f"did not end within {deadline:g} s")
    elif status != 0 and not outcome.failures:
        outcome.failures.append(f"{Path(job.command[0]).name} ended with exit status {status}")
    elif job.counted and outcome.passed + outcome.skipped + len(outcome.failures) == 0:
        outcome.failures.append("the runner ran no test at all")
    elif not job.counted and not outcome.failures:
        outcome.passed = 1
    return outcome


def wait_end(pid, deadline):
    """Waits for a child's end and leaves it to be reaped.

    Args:
        pid: Its process id.
        deadline: Longest wait in wall time [s].

    Returns:
        Processor time [s] of it and all that it waited for; None past the deadline.
    """
    end = time.monotonic() + deadline
    while os.waitid(os.P_PID, pid, os.WEXITED | os.WNOWAIT | os.WNOHANG) is None:
        if time.monotonic() > end:
            return None
        time.sleep(POLL)
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return sum(map(int, fields[11:15])) / os.sysconf("SC_CLK_TCK")  # utime to cstime


def stop(process, grace):
    """Ends a job's process group: first as Ctrl-C would, after a grace [s] for good."""
    for number in (signal.SIGINT, signal.SIGKILL):
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, number)
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(grace)
            break
    with contextlib.suppress(ProcessLookupError):  # what ignored SIGINT and outlived its parent
        os.killpg(process.pid, signal.SIGKILL)


def end_marked(mark, grace):
    """Ends what a job has started and has not ended, in sessions of their own, too.

    Args:
        mark: Value of MARK in their environment.
        grace: Wall time that they may take to end by themselves [s].

    Returns:
        Command lines of those that had to be ended.
    """
    deadline = time.monotonic() + grace
    while (found := marked(mark)) and time.monotonic() < deadline:
        time.sleep(POLL)
    names = list(found.values())
    while found:
        for pid in found:
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        time.sleep(POLL)
        found = marked(mark)
    return names


def marked(mark):
    """Gives process id -> command line of this user's processes with a job's mark."""
    wanted = f"{MARK}={mark}".encode()
    found = {}
    for folder in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):  # it has ended, or is another user's
            if wanted in (folder / "environ").read_bytes().split(b"\0"):
                words = (folder / "cmdline").read_bytes().rstrip(b"\0").split(b"\0")
                if words != [b""]:  # empty: it has ended
                    found[int(folder.name)] = b" ".join(words).decode(errors="replace")[:200]
    return found
