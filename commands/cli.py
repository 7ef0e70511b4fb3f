"""Reads the command line, runs the command, turns errors into a message and an exit status."""

from importlib import import_module

from commands.errors import CommandError, Interrupted, UsageError, print_error
from commands.table import COMMANDS, DEFAULT

HELP = ("-h", "--help", "help")


def main(arguments):
    """Runs ./run.

    Args:
        arguments: Those of the command line, without the program.

    Returns:
        Exit status: 0, 1 for a failure, 2 for wrong arguments, 128 and the number for a signal.
    """
    try:
        return dispatch(arguments) or 0
    except CommandError as error:
        print_error(error)
        return error.status
    except OSError as error:
        print_error(CommandError(str(error)))
        return 1
    except Interrupted as signal:
        return signal.status
    except KeyboardInterrupt:
        return 130


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
    return import_module(f"commands.subcommands.{name}")
