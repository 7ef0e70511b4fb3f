"""argparse for the commands: one parser each, errors of one message, help from docstrings."""

import argparse
import ast
import os
import re
import sys

from commands.errors import UsageError
from commands.paths import read
from commands.table import COMMANDS

WELCOME = """\
Without a command: the track, the car and the teleop window; without a display, the same as demo.
With launch arguments (NAME:=VALUE, of deepracer_teleop/launch/drive.launch): the window, which
needs a display, for example ./run track:=hard rviz:=true.
"""
CLOSING = """\
./run COMMAND --help says more. Every command does what set-up is missing first: Debian packages
as root or through sudo, Python packages into .venv, and the build of the workspace.

completion in this shell: source <(./run completion)
"""


def formatter(prog):
    """Makes the formatter of all helps: texts as they are, 100 columns."""
    return argparse.RawDescriptionHelpFormatter(prog, width=100)


class Parser(argparse.ArgumentParser):
    """A parser that raises UsageError where argparse would print its usage and exit."""

    def error(self, message):
        """Turns argparse's error into one message."""
        message = re.sub("^argument ", "", message)
        for theirs, ours in (
            (": expected one argument", " needs a value"),
            (": expected at least one argument", " needs a value"),
        ):
            if message.endswith(theirs):
                message = message[: -len(theirs)] + ours
        raise self.usage_error(message)

    def usage_error(self, message):
        """Makes a UsageError that shows the usage."""
        usage = " ".join(self.format_usage().split())
        return UsageError(message, usage, f"{self.prog} --help says more")

    def flags(self):
        """Lists the long options that the help shows."""
        return [
            flag
            for action in self._actions
            for flag in action.option_strings
            if action.help != argparse.SUPPRESS and flag.startswith("--")
        ]

    def option(self, flag):
        """Returns the action of an option; None if there is no such option."""
        return self._option_string_actions.get(flag)

    def words(self):
        """Lists the values that arguments without a flag can have."""
        return [word for action in self._get_positional_actions() for word in values(action) or ()]


def values(action):
    """Lists the values that an argument can have, as its type or it tells; None if unknown."""
    complete = getattr(action, "complete", getattr(getattr(action, "type", 0), "complete", 0))
    return complete() if complete else None


def parser_of(name, module):
    """Builds the parser of a command.

    Args:
        name: The command; empty for none.
        module: Its module: docstring, USAGE, add_arguments(parser) and LAUNCH where it has them.
    """
    launch = getattr(module, "LAUNCH", None)
    prog = f"./run {name}".strip()
    parser = Parser(
        prog=prog,
        usage=f"{prog} {getattr(module, 'USAGE', '')}".strip(),
        description=module.__doc__,
        epilog=launch and launch.help(),
        formatter_class=formatter,
        allow_abbrev=False,
    )
    if hasattr(module, "add_arguments"):
        module.add_arguments(parser)
    return parser


def split(name, module, arguments, does=""):
    """Parts a command's own options from the command behind them.

    Args:
        name, module: As of parser_of().
        arguments: All of them; "--" may stand between the two.
        does: What is done to the command, where it has to be another one of ./run.

    Returns:
        (argparse.Namespace, list of words).

    Raises:
        UsageError: An option is wrong, or the command.
    """
    parser, at = parser_of(name, module), 0
    while at < len(arguments) and arguments[at].startswith("-") and arguments[at] != "--":
        action = parser.option(arguments[at])
        at += 2 if action is not None and action.nargs is None else 1  # a value is behind it
    options, rest = parser.parse_known_args(arguments[:at])
    if rest:
        raise parser.usage_error(f"unknown argument {rest[0]!r}")
    words = arguments[at + (arguments[at : at + 1] == ["--"]) :]
    if does and words and ":=" not in words[0] and (words[0] not in COMMANDS or words[0] == name):
        raise UsageError(
            f"the {name} {does} a command of ./run, and {words[0]!r} is none",
            f"For any program: ./run {name} exec PROGRAM ...",
        )
    return options, words


def other_commands(name):
    """Makes the function complete() of a command that takes another one behind it."""
    return lambda words: [] if words else [command for command in COMMANDS if command != name]


def overview():
    """Returns the help of ./run itself."""
    width = max(map(len, COMMANDS))
    table = "\n".join(f"  {name:{width}}  {summary}" for name, summary in COMMANDS.items())
    return Parser(
        prog="./run",
        usage="./run [COMMAND] [ARGUMENTS]",
        description=WELCOME,
        epilog=f"commands:\n{table}\n\n{CLOSING}",
        formatter_class=formatter,
    ).format_help()


def one_of(name, choices, aliases=None):
    """Makes an argument type that takes one of some words.

    Args:
        name: What the argument is, for messages.
        aliases: Dict from other words to one of them.
    """

    def read(value):
        value = (aliases or {}).get(value, value)
        if value not in choices:
            raise UsageError(f"{name} is {value!r}; there are {', '.join(choices)}")
        return value

    read.complete = lambda: choices
    return read


def whole_number(name, least=1, most=None):
    """Makes an argument type that takes a whole number; most: None for no limit."""
    valid = f", {least} or more" if most is None else f" from {least} to {most}"

    def read(value):
        number = int(value) if value.isascii() and value.isdigit() else -1
        if number < least or number > (number if most is None else most):
            raise UsageError(f"{name} is {value!r}; it must be a whole number{valid}")
        return number

    return read


def number(name, most):
    """Makes an argument type that takes a number above 0, at most some other one."""

    def read(value):
        try:
            number = float(value)
        except ValueError:
            number = 0.0
        if not 0.0 < number <= most:
            raise UsageError(f"{name} is {value!r}; it must be a number above 0, at most {most}")
        return number

    return read


port = whole_number("port", 1, 65535)


def asked_password(variable, what, lengths, is_valid):
    """Takes a password out of the environment, so that programs do not inherit it, or asks for one.

    Args:
        what: What it is for.
        lengths: How long it has to be, as text.
        is_valid: From a password to whether it can be used.

    Raises:
        UsageError: There is none, and nobody to ask; or it cannot be used.
    """
    password = os.environ.pop(variable, None)
    if password is None:
        if not sys.stdin.isatty():
            raise UsageError(f"--share needs a password, and {variable} is not set")
        import getpass

        password = getpass.getpass(f"password for the {what} ({lengths}): ")
    if not is_valid(password):
        raise UsageError(f"the {what}'s password has {len(password)} characters; {lengths}")
    return password


def folder_name(value):
    """Argument type of the name of a folder of results."""
    if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_.-]*", value):
        raise UsageError(f"name is {value!r}; it must be letters, digits, '_', '-' and '.'")
    return value


def add_options(parser, *rows):
    """Declares options with a value, a row each: flag, name of the value, type, default, help; and
    how many values, where they are several."""
    for flag, metavar, kind, default, text, *count in rows:
        many = {"nargs": count[0]} if count else {}
        parser.add_argument(flag, metavar=metavar, type=kind, default=default, help=text, **many)


def existing_file(value):
    """Argument type of a file; gives its path without links."""
    if not os.path.isfile(value):
        raise UsageError(f"there is no file {value!r}")
    return os.path.realpath(value)


def declare(parser, script):
    """Declares a script's options, so that help and completion tell what it really takes.

    Args:
        parser: Gets each option that the script declares with add_argument().
    """
    for call in ast.walk(ast.parse(read(script))):
        if isinstance(call, ast.Call) and getattr(call.func, "attr", "") == "add_argument":
            flags = [value for value in map(_constant, call.args) if value]
            given = {keyword.arg: _constant(keyword.value) for keyword in call.keywords}
            if flags and flags[0].startswith("-"):
                kinds = {name: given[name] for name in ("nargs", "metavar") if given.get(name)}
                if str(given.get("action")).startswith("store_"):
                    kinds = {"action": "store_true"}
                parser.add_argument(*flags, help=given.get("help") or "", **kinds)


def keys(script, name):
    """Lists the keys of a dict that a script assigns to a name."""
    if not os.path.exists(script):
        return []
    for node in ast.parse(read(script)).body:
        targets = [getattr(target, "id", "") for target in getattr(node, "targets", [])]
        if name in targets and isinstance(node.value, ast.Dict):
            return [key.value for key in node.value.keys]
    return []


def _constant(node):
    return node.value if isinstance(node, ast.Constant) else None
