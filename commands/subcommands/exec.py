"""Runs a command in the current directory with .venv and the catkin workspace active.

For example:
  ./run exec rostopic hz /camera/image
  ./run exec bash
"""

from commands import environment, processes
from commands.errors import UsageError

USAGE = "CMD [ARGUMENTS]"
PASSES_ON = True
COMMAND = True  # options behind CMD are its own


def run(arguments):
    """Becomes the command."""
    if arguments[:1] == ["--"]:
        arguments = arguments[1:]
    if not arguments:
        raise UsageError("exec needs a command", f"usage: ./run exec {USAGE}")
    processes.become(arguments, environment.ready())


def complete(words):
    """Asks the shell for a program; what follows are files."""
    from commands.subcommands.completion import ANY_COMMAND

    return [] if words else [ANY_COMMAND]
