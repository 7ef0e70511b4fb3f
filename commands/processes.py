"""Processes: children that are waited for, with signals handed on, and what ./run becomes."""

import contextlib
import errno
import os
import sys

from commands.errors import CommandError, Interrupted

POLL = 0.2  # [s] between looks at signals, deadline and progress
KILLED_AFTER = 30.0  # [s] from SIGINT to SIGKILL


class DeadlineExceeded(Exception):
    """A child did not end in time and was stopped."""


def run_child(
    argv, *, group=True, session=True, deadline=None, grace=KILLED_AFTER, tick=None, signals=None,
    **popen,
):  # fmt: skip
    """Runs a child to its end. Signals to ./run stop the child first.

    Args:
        group: Whether to signal all of the child's processes, or the child alone.
        session: Whether the child gets a session of its own, out of a terminal's reach.
        deadline: Longest run [s]; None for no limit.
        grace: Wait from SIGINT to SIGKILL [s]; None to wait for ever.
        tick: Called with the seconds since the start, a few times a second.
        signals: The caller's Signals, whose with statement goes on; None for some of its own.
        **popen: For subprocess.Popen.

    Returns:
        Its exit status, as subprocess gives it.

    Raises:
        DeadlineExceeded: It did not end in time.
        Interrupted: ./run was asked to stop.
    """
    import subprocess
    import time

    start = time.monotonic()
    with Signals() if signals is None else contextlib.nullcontext(signals) as received:
        received.check()
        process = subprocess.Popen(argv, start_new_session=session, **popen)
        status = None
        while status is None:
            try:
                status = process.wait(POLL)
            except subprocess.TimeoutExpired:
                seconds = time.monotonic() - start
                late = deadline is not None and seconds > deadline
                if received.first is not None or late:
                    stop([(process, group and session, grace)])
                    if received.first is None:
                        raise DeadlineExceeded from None
                    break
                if tick is not None:
                    tick(seconds)
    received.check()  # only now: none may come between this and the return
    return status


def exit_status(status):
    """Returns the exit status that a shell would give for one of subprocess."""
    return 128 - status if status < 0 else status


def become(argv, environ):
    """Replaces ./run by a program; does not come back.

    Raises:
        CommandError: The program cannot be started; exit status as a shell would give it.
    """
    import signal

    sys.stdout.flush()
    sys.stderr.flush()
    signal.signal(signal.SIGPIPE, signal.SIG_DFL)  # Python ignores it, and children would, too
    try:
        os.execvpe(argv[0], argv, environ)
    except FileNotFoundError:
        problem, status = "no such command", 127
    except OSError as cause:
        if cause.errno == errno.ENOEXEC:  # a script without #! is the shell's
            os.execvpe("sh", ["sh", "-c", '"$0" "$@"', *argv], environ)
        problem, status = cause.strerror, 126
    error = CommandError(f"cannot run {argv[0]!r}: {problem}")
    error.status = status
    raise error


def become_module(python, words, environ):
    """Becomes a module of Python's path; the current folder, with a random.py say, is not on it.

    Python 3.11 is the first to obey.

    Args:
        words: The module and its arguments.
    """
    become([python, "-m", *words], {**environ, "PYTHONSAFEPATH": "1"})


class Signals:
    """Within a with statement, signals that ask ./run to stop are noted, and nothing is cut short.

    Attributes:
        first: The first that came, or None.
    """

    def __enter__(self):
        import signal

        self.first, self._before = None, {}
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            if signal.getsignal(number) != signal.SIG_IGN:
                self._before[number] = signal.signal(number, self._note)
        return self

    def __exit__(self, *_):
        import signal

        for number, handler in self._before.items():  # ./run ends by the first, not by the next
            signal.signal(number, handler if self.first is None else signal.SIG_IGN)

    def check(self):
        """Raises Interrupted if one came."""
        if self.first is not None:
            raise Interrupted(self.first)

    def _note(self, number, _frame):
        if self.first is None:
            self.first = number


def stop(children):
    """Stops children by SIGINT, and by SIGKILL those that do not end.

    Args:
        children: List of (its subprocess.Popen, whether all of its session is stopped, wait from
            SIGINT to SIGKILL [s] or None to wait for ever).
    """
    import signal
    import subprocess
    import time

    start = time.monotonic()
    for process, group, _ in children:
        _send(os.killpg if group else os.kill, process.pid, signal.SIGINT)
    for process, group, grace in children:
        send = os.killpg if group else os.kill
        try:
            process.wait(None if grace is None else max(0.0, start + grace - time.monotonic()))
        except subprocess.TimeoutExpired:
            _send(send, process.pid, signal.SIGKILL)
            process.wait()
        if group:
            _send(send, process.pid, signal.SIGTERM)  # what the program left behind


def _send(send, number, signal):
    with contextlib.suppress(ProcessLookupError):
        send(number, signal)
