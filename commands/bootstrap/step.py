"""One step of set-up: a title with the seconds it takes, a log, and what to do if it fails."""

import os
import subprocess
import sys
import time

from commands import processes
from commands.bootstrap import lock
from commands.errors import CommandError, Interrupted, say
from commands.paths import LOGS, relative

EVERY = 30  # between lines of progress where there is no terminal [s]
GRACE = 5.0  # from SIGINT to SIGKILL for what the step started [s]
TAIL = 20  # lines of the log shown after a failure


class StepFailed(Exception):
    """A program of the step ended with an error; its log says why."""


class Step:
    """Runs the programs of a step, with their output in a log.

    Attributes:
        log: Path of the log.
    """

    def __init__(self, number, title, advice, log, of=3):
        """Prepares a step.

        Args:
            number: Its number.
            title: Two or three words.
            advice: What to look at if it fails.
            log: The log's name without suffix.
            of: How many steps there are.
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
        status = processes.run_child(
            argv,
            grace=GRACE,
            tick=self._tick,
            env=environ,
            stdin=subprocess.DEVNULL,
            stdout=self._stream,
            stderr=subprocess.STDOUT,
            pass_fds=lock.held(),
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
