"""The steps of set-up: their titles with the seconds they take, their logs, the lock around them.

Steps run beside each other and wait for what they need of each other. One ./run at a time has the
lock, the others wait. What a step starts has it, too: where a killed ./run leaves pip or a build,
the next one waits for their end in place of working beside them.
"""

import errno
import fcntl
import os
import re
import sys
import time

from commands import processes
from commands.errors import CommandError, say
from commands.paths import KEPT, LOGS, ROOT, relative, tail

LOCK = os.path.join(KEPT, "lock")  # ./run takes it, too, while there is no python3
LOCK_LIMIT = 1800.0  # [s]
SILENT = 2.0  # before it says that it waits: a ./run that finds all ready is through by then [s]
POLL = 0.05  # [s] between looks at the lock, at programs and at signals
STEPS = 4  # of ./run setup
EVERY = 30  # between lines of progress where there is no terminal [s]
GRACE = 5.0  # from SIGINT to SIGKILL for what the step started [s]
TAIL = 20  # lines of the log shown after a failure
FIRST = 6  # and those of its first error, if that is further up: others go on after it
ERROR = re.compile(r"CMake Error|(?:\S+: )*(?:fatal )?error: ")
COLORS = re.compile(r"\x1b\[[0-9;]*[mK]")

_held = []


def held_locks():
    """File descriptors of the lock, for pass_fds of what a step starts."""
    return tuple(_held)


def run_quietly(argv, cwd=None):
    """Runs a program that asks nothing and holds the locks; signals to ./run stop it.

    Returns:
        (exit status, as subprocess gives it; lines of its output, in English).

    Raises:
        Interrupted: ./run was asked to stop.
    """
    import subprocess
    import tempfile

    with tempfile.TemporaryFile("w+", errors="replace") as said:
        status = processes.run_child(
            argv,
            cwd=cwd,
            env={**os.environ, "GIT_TERMINAL_PROMPT": "0", "LC_ALL": "C"},
            stdin=subprocess.DEVNULL,
            stdout=said,
            stderr=subprocess.STDOUT,
            pass_fds=held_locks(),
            grace=GRACE,
        )
        said.seek(0)
        return status, said.read().splitlines()


class SetupLock:
    """Holds the lock within a with statement; children get it by pass_fds=held_locks() alone.

    Args:
        path: Of its file; None for that of the set-up.
        doing: What its holder does, for who waits.
    """

    def __init__(self, path=None, doing="setting up"):
        self._path, self._doing = path or LOCK, doing

    def __enter__(self):
        os.makedirs(os.path.dirname(self._path), exist_ok=True)
        self._file = os.open(self._path, os.O_RDWR | os.O_CREAT, 0o666)
        if not self._taken():
            self._wait()
        _held.append(self._file)
        return self

    def __exit__(self, *_):
        tell_waiting("")
        _held.remove(self._file)
        os.close(self._file)

    def _wait(self):
        begin, next_word = time.monotonic(), SILENT
        while not self._taken():
            waited = time.monotonic() - begin
            if waited > next_word:
                step = os.pread(self._file, 200, 0).decode(errors="replace")
                text = f"another ./run is {self._doing}, waiting for it{step and f': {step}'}"
                # Not to stdout, which belongs to the command: ./run exec COMMAND | ...
                print(text, file=sys.stderr, flush=True)
                next_word = EVERY * (waited // EVERY + 1)
            if waited > LOCK_LIMIT:
                raise CommandError(
                    f"another ./run has been {self._doing} for half an hour",
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


def tell_waiting(text):
    """Writes into the locks what those who wait for them are told."""
    for file in _held:
        os.ftruncate(file, 0)
        os.pwrite(file, text.encode(), 0)


class StepFailed(Exception):
    """A program of the step ended with an error; its log says why."""


class Step:
    """Runs the programs of a step one after the other, with their output in a log."""

    speaks = False  # whether its program says itself what it does

    def __init__(self, number, title, work, advice, log, promises=(), of=STEPS):
        """Prepares a step.

        Args:
            work: Generator function that gets this step. It yields (command line, environment) of
                each program, and goes on when that has ended well; at a failure StepFailed is
                raised there. Or it yields the name of something that another step promises, and
                goes on when that is there.
            advice: What to look at if it fails.
            log: The log's name without suffix.
            promises: Names of what other steps may wait for: there when the step ends, or at
                reach().
        """
        self.log = os.path.join(LOGS, f"{log}.log")
        self.promises = set(promises)
        self.title = f"[{number}/{of}] {title}"
        self.begun = None  # when it started its first program; it says nothing before [s]
        self._name, self._advice = title, advice
        self._lines_before = 0  # of the log, from programs before the last
        self._work = work(self)
        self._said, self._stream = 0, None
        self._program, self._awaited = None, None

    def go_on(self, promised):
        """Goes on as far as it can without waiting.

        Args:
            promised: Names of what is not there yet.

        Returns:
            Whether it goes on later.

        Raises:
            StepFailed, OSError: It failed.
        """
        while True:
            failure = None
            if self._program is not None:
                status = self._program.poll()
                if status is None:
                    return True
                name, self._program = os.path.basename(self._program.args[0]), None
                failure = self._ended(name, status)
            if self._awaited in promised:
                return True
            try:
                wanted = self._work.throw(failure) if failure else next(self._work)
            except StopIteration:
                self.promises.clear()
                if self.begun is not None:
                    self._end(f"done ({self._seconds()} s)")
                return False
            if isinstance(wanted, str):
                self._awaited = wanted
            else:
                self._program = self._start(*wanted)

    def reach(self, name):
        """Tells that something that it promised is there."""
        self.promises.discard(name)

    def note(self, text):
        """Prints a line between the seconds: why this takes longer than usual."""
        _print(text)

    def children(self):
        """Lists what processes.stop() stops, while a program runs."""
        return [] if self._program is None else [(self._program, True, GRACE)]

    def tick(self):
        """Says every EVERY seconds, where there is no terminal, how long it takes."""
        if self._seconds() // EVERY > self._said:
            self._said = self._seconds() // EVERY
            say(f"{self.title} ... {self._seconds()} s")

    def fail(self, error):
        """Prints the first error and the end of the log.

        Raises:
            CommandError: In any case.
        """
        os.makedirs(LOGS, exist_ok=True)
        with open(self.log, "a", encoding="utf-8") as stream:
            stream.write(f"{error}\n")
        self._end(f"FAILED after {self._seconds()} s. The end of {relative(self.log)}:")
        lines = tail(self.log)
        shown = lines[-TAIL:]
        for at, line in enumerate(lines[self._lines_before : -TAIL], self._lines_before):
            if ERROR.match(COLORS.sub("", line)):
                shown = [*lines[at : at + FIRST], "...", *shown]
                break
        for line in shown:
            say(f"    | {line}")
        raise CommandError(
            f"the step '{self._name}' failed",
            self._advice,
            "Then start ./run again: finished steps are skipped.",
        ) from None

    def close(self):
        """Closes the log; work() may clean up."""
        self._work.close()
        if self._stream is not None:
            self._stream.close()

    def _start(self, argv, environ):
        import subprocess

        if self.begun is None:
            self.begun = time.monotonic()
            os.makedirs(LOGS, exist_ok=True)
            self._stream = open(self.log, "wb", buffering=0)
            tell_waiting(self.title)
            if not sys.stdout.isatty():
                say(f"{self.title} ... (details in {relative(self.log)})")
        self._lines_before = len(tail(self.log))
        return subprocess.Popen(
            argv,
            cwd=ROOT,  # not the caller's, whose random.py pip would import
            env=environ,
            start_new_session=True,
            stdin=subprocess.DEVNULL,
            stdout=self._stream,
            stderr=subprocess.STDOUT,
            pass_fds=held_locks(),
        )

    def _ended(self, name, status):
        """Returns the failure of a program that has ended; None: it ended well."""
        return StepFailed(f"{name} ended with exit status {status}") if status else None

    def _seconds(self):
        return int(time.monotonic() - (self.begun or time.monotonic()))

    def _end(self, text):
        _print(f"{self.title} {text}")


class SpeakingStep(Step):
    """A step whose program says itself what it does, and why it fails: ./run --packages.

    It stays in the terminal's reach, where sudo asks for a password. Its end is always waited for:
    half of an installation is worse than none.
    """

    speaks = True

    def children(self):
        """As of every step."""
        return [] if self._program is None else [(self._program, False, None)]

    def _start(self, argv, environ):
        import subprocess

        sys.stdout.flush()
        return subprocess.Popen(argv, env=environ)

    def _ended(self, name, status):
        if status != 0:
            raise SystemExit(processes.exit_status(status))


def run_beside(steps):
    """Runs steps beside each other; the first that fails ends all.

    Args:
        steps: In the order in which they are told of.

    Raises:
        CommandError: One failed.
        SystemExit: One failed that has said why.
        Interrupted: A signal ended them.
    """
    waiting, seconds = list(steps), -1
    try:
        with processes.Signals() as signals:
            while waiting and signals.first is None:
                progress = _go_on(waiting)
                if progress:
                    continue
                if sys.stdout.isatty():
                    if int(time.monotonic()) != seconds:
                        seconds = int(time.monotonic())
                        _draw(waiting)
                else:
                    for step in waiting:
                        step.tick()
                time.sleep(POLL)
            if signals.first is not None:
                speaking = any(step.speaks and step.children() for step in waiting)
                processes.stop([child for step in waiting for child in step.children()])
                if not speaking:
                    say("\ninterrupted; start ./run again to go on")
        signals.check()
    finally:
        for step in steps:
            step.close()


def _go_on(waiting):
    """Goes on with every step; returns whether one ended or reached what it promised."""
    promised = {name for step in waiting for name in step.promises}
    for step in list(waiting):
        try:
            if not step.go_on(promised):
                waiting.remove(step)
        except (StepFailed, OSError, CommandError, SystemExit) as error:
            waiting.remove(step)
            _end_others(waiting)
            if isinstance(error, (StepFailed, OSError)):
                step.fail(error)
            raise
    return promised != {name for step in waiting for name in step.promises}


def _end_others(waiting):
    """Stops the other steps once one has failed; what must not be stopped half-way ends first."""
    processes.stop([child for step in waiting if not step.speaks for child in step.children()])
    for step in waiting:
        for process, _, _ in step.children() if step.speaks else ():
            process.wait()
    for step in waiting:
        if step.begun is not None:
            _print(f"{step.title} stopped")


def _draw(waiting):
    """Says in place what runs, and how long the first of it has."""
    if any(step.speaks and step.children() for step in waiting):
        return  # the line is its program's
    running = [step for step in waiting if step.begun is not None]
    if running:
        seconds = int(time.monotonic() - min(step.begun for step in running))
        say(f"\r\033[K{', '.join(step.title for step in running)} ... {seconds} s ", end="")


def _print(text):
    say(f"\r\033[K{text}" if sys.stdout.isatty() else text)
