"""What is printed for the user: lines of progress, and errors of one message."""

import contextlib
import sys


class CommandError(Exception):
    """A command cannot go on.

    Attributes:
        advice: Lines printed below the message.
        status: Exit status of ./run.
    """

    status = 1

    def __init__(self, message, *advice):
        super().__init__(message)
        self.advice = advice


class UsageError(CommandError):
    """The arguments are wrong."""

    status = 2


class Interrupted(Exception):
    """SIGINT, SIGTERM or SIGHUP ended what was going on.

    Attributes:
        status: Exit status of ./run, as a shell would give it.
    """

    def __init__(self, number):
        super().__init__(f"signal {number}")
        self.status = 128 + number


def say(text, end="\n"):
    """Prints at once, also into a pipe."""
    print(text, end=end, flush=True)


def print_error(error):
    """Prints a CommandError and its advice to stderr, if that can be written."""
    lines = (f"run: {error}", *(f"     {line}" for line in error.advice))
    with contextlib.suppress(OSError):
        print(*lines, sep="\n", file=sys.stderr)
