"""One step of set-up: its title with the seconds it takes, its log, the lock around it.

One ./run at a time has the lock, the others wait. What a step starts has it, too: where a killed
./run leaves pip or a build, the next one waits for their end in place of working beside them.
"""

import errno
import fcntl
import os
import sys
import time

from commands import processes
from commands.errors import CommandError, Interrupted, say
from commands.paths import CACHE, LOGS, relative

LOCK = os.path.join(CACHE, "lock")  # ./run takes it, too, while there is no python3
LOCK_LIMIT = 1800.0  # [s]
SILENT = 2.0  # before it says that it waits: a ./run that finds all ready is through by then [s]
POLL = 0.05  # [s]
EVERY = 30  # between lines of progress where there is no terminal [s]
GRACE = 5.0  # from SIGINT to SIGKILL for what the step started [s]
TAIL = 20  # lines of the log shown after a failure

_held = []


def held_locks():
    """File descriptors of the lock, for pass_fds of what a step starts."""
    return tuple(_held)


class SetupLock:
    """Holds the lock within a with statement; children get it by pass_fds=held_locks() alone."""

    def __enter__(self):
        self._file = os.open(LOCK, os.O_RDWR | os.O_CREAT, 0o666)
        if not self._taken():
            self._wait()
        _held.append(self._file)
        return self

    def __exit__(self, *_):
        _held.remove(self._file)
        os.close(self._file)

    def _wait(self):
        begin, said = time.monotonic(), False
        while not self._taken():
            waited = time.monotonic() - begin
            if waited > SILENT and not said:
                # Not to stdout, which belongs to the command: ./run exec COMMAND | ...
                print("another ./run is setting up, waiting for it", file=sys.stderr, flush=True)
                said = True
            if waited > LOCK_LIMIT:
                raise CommandError(
                    "another ./run has been setting up for half an hour",
                    "Look for it with: ps x | grep run",
                )
            time.sleep(POLL)

    def _taken(self):
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            if error.errno not in (errno.EAGAIN, errno.EACCES):
                raise
            return False
        return True


class StepFailed(Exception):
    """A program of the step ended with an error; its log says why."""


class Step:
    """Runs the programs of a step, with their output in a log."""

    def __init__(self, number, title, advice, log, of=3):
        """Prepares a step.

        Args:
            advice: What to look at if it fails.
            log: The log's name without suffix.
        """
        self.log = os.path.join(LOGS, f"{log}.log")
        self._name, self._title, self._advice = title, f"[{number}/{of}] {title}", advice
        self._in_place = sys.stdout.isatty()
        self._said = 0

    def run(self, work):
        """Does the step.

        Args:
            work: Function that gets this step and calls execute() for each program.

        Raises:
            CommandError: It failed.
            Interrupted: A signal ended it.
        """
        os.makedirs(LOGS, exist_ok=True)
        self._start = time.monotonic()
        if self._in_place:
            say(f"{self._title} ... ", end="")
        else:
            say(f"{self._title} ... (details in {relative(self.log)})")
        try:
            with open(self.log, "wb", buffering=0) as self._stream:
                work(self)
        except (StepFailed, OSError) as error:
            self._fail(error)
        except Interrupted:
            say("\ninterrupted; start ./run again to go on")
            raise
        self._end(f"done ({self._seconds()} s)")

    def execute(self, argv, environ):
        """Runs one program in the clone's name, its output goes to the log.

        Raises:
            StepFailed: Its exit status is not 0.
            Interrupted: A signal ended it.
        """
        import subprocess

        status = processes.run_child(
            argv,
            grace=GRACE,
            tick=self._tick,
            env=environ,
            stdin=subprocess.DEVNULL,
            stdout=self._stream,
            stderr=subprocess.STDOUT,
            pass_fds=held_locks(),
        )
        if status != 0:
            raise StepFailed(f"{os.path.basename(argv[0])} ended with exit status {status}")

    def note(self, text):
        """Prints a line between the seconds: why this takes longer than usual."""
        say(f"\r{text}" if self._in_place else text)

    def _seconds(self):
        return int(time.monotonic() - self._start)

    def _tick(self, _):
        seconds = self._seconds()
        if seconds == self._said:
            return
        self._said = seconds
        if self._in_place:
            say(f"\r{self._title} ... {seconds} s ", end="")
        elif seconds % EVERY == 0:
            say(f"{self._title} ... {seconds} s")

    def _end(self, text):
        say(f"\r{self._title} {text}" if self._in_place else f"{self._title} {text}")

    def _fail(self, error):
        with open(self.log, "a", encoding="utf-8") as stream:
            stream.write(f"{error}\n")
        self._end(f"FAILED after {self._seconds()} s. The end of {relative(self.log)}:")
        with open(self.log, encoding="utf-8", errors="replace") as stream:
            for line in stream.read().splitlines()[-TAIL:]:
                say(f"    | {line}")
        raise CommandError(
            f"the step '{self._name}' failed",
            self._advice,
            "Then start ./run again: finished steps are skipped.",
        ) from None
