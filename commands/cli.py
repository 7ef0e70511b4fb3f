"""Reads the command line, runs the command, turns errors into a message and an exit status."""

import os
import sys
from importlib import import_module

from commands.errors import CommandError, Interrupted, UsageError, print_error
from commands.table import COMMANDS, DEFAULT

HELP = ("-h", "--help", "help")


def main(arguments):
    """Runs ./run.

    Args:
        arguments: Those of the command line, without the program.

    Returns:
        Exit status: 0, 1 for a failure, 2 for wrong arguments, 128 and the number for a signal, a
        pipe that nobody reads among them.
    """
    try:
        status = _status(arguments)
        sys.stdout.flush()
    except BrokenPipeError:
        status = 128 + 13  # SIGPIPE
    except OSError as error:
        status = 1
        print_error(CommandError(f"output cannot be written: {error.strerror}"))
    _close_output()
    return status


def _status(arguments):
    """Runs ./run, and prints its errors; OSError is of the output."""
    try:
        return dispatch(arguments) or 0
    except CommandError as error:
        print_error(error)
        return error.status
    except BrokenPipeError:
        raise
    except OSError as error:
        sys.stdout.flush()
        print_error(CommandError(str(error)))
        return 1
    except Interrupted as error:
        return error.status
    except KeyboardInterrupt:
        return 130
    except SystemExit as end:  # argparse's, after a help
        return end.code


def _close_output():
    """Leads what could not be written to nowhere; Python would try it again at its end."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError:
            os.dup2(nowhere, stream.fileno())


def dispatch(arguments):
    """Finds the command and runs it; most commands become another program and do not come back."""
    name = arguments[0] if arguments else ""
    if name in HELP:
        from commands.parsing import overview

        print(overview(), end="")
        return 0
    if not name or ":=" in name:
        name, module = "", subcommand(DEFAULT)
    elif name in COMMANDS:
        module, arguments = subcommand(name), arguments[1:]
    else:
        raise UsageError(
            f"unknown command {name!r}; there are: {', '.join(COMMANDS)}", "./run --help says more"
        )
    if getattr(module, "PASSES_ON", False) and arguments[:1] not in (["-h"], ["--help"]):
        return module.run(arguments)
    return parsed(name, module, arguments)


def parsed(name, module, arguments):
    """Runs a command that argparse reads the arguments of."""
    from commands.parsing import parser_of

    parser = parser_of(name, module)
    options, rest = parser.parse_known_args(arguments)
    if rest and not hasattr(module, "LAUNCH"):
        raise parser.usage_error(f"unknown argument {rest[0]!r}")
    return module.run(options, rest)


def subcommand(name):
    """Imports the module of a command."""
    return import_module("commands.subcommands." + name.replace("-", "_"))
