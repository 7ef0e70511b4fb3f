"""Installs and builds what is missing, and starts nothing.

Installs the Debian packages of config/apt.txt that are missing (as root, or with sudo), puts the
packages of config/requirements.txt into .venv, builds the catkin workspace into build/ and devel/,
and compiles the solver. What tests and learning need besides comes with ./run test, ./run train and
the others that need it. ROS 1 is Debian's (config/apt-ros.txt), unless another one is sourced in
the shell: then everything is built on that one, now and in later shells, until .venv is deleted.
Packages that you have put into src/ are built, too: what rosdep says that they need of Debian is
named and installed (asked for on a terminal), and what cannot be built is left out and named.
Steps whose inputs have not changed are skipped; an interrupted set-up can be started again. Details
go to .cache/log/.
"""

import os
import sys

from commands import bootstrap
from commands.bootstrap import left_out, venv, workspace
from commands.bootstrap.venv import EXTRAS
from commands.errors import UsageError, say
from commands.paths import ROOT
from commands.subcommands import deps

USAGE = "[--with LIST] [--environment]"


def add_arguments(parser):
    """Declares --with and --environment."""
    wanted = parser.add_argument(
        "--with",
        dest="lists",
        metavar="LIST",
        type=_lists,
        default=[],
        help="also what other commands install when they first need it, for example gym,learning "
        f"(there are {', '.join(EXTRAS)})",
    )
    wanted.complete = lambda: EXTRAS
    text = "print what setup.bash evaluates: the environment of ./run exec, as shell commands"
    parser.add_argument("--environment", action="store_true", help=text)


def run(options, _rest):
    """Sets up."""
    if options.environment:
        return print_environment()
    users = workspace.users_packages()
    if users:
        deps.offer(list(users.values()), asked)
    bootstrap.prepare()
    if options.lists:
        venv.prepare_extras(*options.lists)
    for line in left_out.lines(left_out.saved()):
        say(line)
    say(f"ready: {ROOT}")


def asked(question):
    """Asks on a terminal; without one, as for Paddock's own packages, the answer is yes."""
    if not (sys.stdin.isatty() and sys.stdout.isatty()):
        return True
    return input(f"{question} [Y/n] ").strip().lower() in ("", "y", "yes")


def _lists(value):
    names = value.split(",")
    for name in names:
        if name not in EXTRAS:
            raise UsageError(f"list is {name!r}; there are {', '.join(EXTRAS)}")
    return names


def print_environment():
    """Sets up, which is told on stderr, and prints the changes to the caller's environment."""
    from commands import environment

    kept = os.dup(1)
    os.dup2(2, 1)
    after = environment.ready()
    lines = changes(environment.callers(), after)
    os.dup2(kept, 1)
    print("\n".join(lines))


def changes(before, after):
    """Lists the commands, for bash and zsh, that turn one environment into another.

    Args:
        before: The shell's variables as a dict.
        after: What they shall be; HOME stays.
    """
    import shlex

    gone = [f"unset {name}" for name in before if name not in after]
    return gone + [
        f"export {name}={shlex.quote(value)}"
        for name, value in after.items()
        if before.get(name) != value and name != "HOME"
    ]
