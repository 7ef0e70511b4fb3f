"""Shows the window, rviz and the viewer in a browser; this machine needs no screen.

COMMAND is what otherwise stands behind ./run: nothing (the track, the car and the window), launch
arguments, truck, lap, world, demo, exec with any program. For example:
  ./run desk rviz:=true
  ./run desk truck
  ./run desk lap --driver line
  ./run desk exec roslaunch my_car drive.launch
truck, lap and world have no window of their own and get rviz:=true, unless rviz or gui is given.

Windows stand side by side on a screen in memory (TigerVNC, i3); noVNC brings it into the browser.
Open the address that is printed: it has a token that is new at each start. Several browsers see
and use the same screen. The desk ends with its command, or with Ctrl-C.

Only this machine gets in; from another one: ssh -L 6080:127.0.0.1:6080 HOST, then the same address.
--share lets other machines in directly, with the token and a password of 6 to 8 characters
(DESK_PASSWORD, or asked for); nothing is encrypted then, so only in a network that you trust.
"""

import getpass
import os
import re
import sys

from commands import environment, processes
from commands.errors import UsageError, say
from commands.paths import ROOT

USAGE = "[--size WxH] [--port N] [--share] [COMMAND ...]"
COMMAND = True  # options behind the command are its own
PASSES_ON = True
# What lets commands that start no window show something.
SHOWN = {"truck": ["rviz:=true"], "world": ["rviz:=true"], "lap": ["rviz:=true"]}
ALWAYS = {"lap": ["platform:=xcb"]}  # the window of the drivers that use one


def add_arguments(parser):
    """Declares the desk's own options."""
    parser.add_argument(
        "--size", metavar="WxH", default="1600x900", type=_size, help="of the screen (1600x900)"
    )
    parser.add_argument(
        "--port", metavar="N", type=_port, help="for browsers (6080, or the next free one)"
    )
    parser.add_argument("--share", action="store_true", help="let other machines in, by password")


def run(arguments):
    """Runs the command on a desk; its exit status is the desk's."""
    from commands.bootstrap import packages
    from commands.desk.session import Desk

    options, words = split(arguments)
    command = [os.path.join(ROOT, "run"), *shown(words)]
    password = asked_password() if options.share else None
    environment.ready()
    packages.prepare_desk()
    with Desk(environment.callers(), options.size, options.port, password) as desk:
        say(f"the desk, in a browser: {desk.url}")
        return processes.exit_status(desk.run(command))


def split(arguments):
    """Parts the desk's options from the command behind them.

    Returns:
        (argparse.Namespace, list of words).
    """
    from commands.cli import COMMANDS
    from commands.parsing import parser_of

    module = sys.modules[__name__]
    own, at = list(arguments), 0
    while at < len(own) and own[at].startswith("-"):
        at += 2 if own[at] in ("--size", "--port") else 1
    words = own[at:]
    if words and ":=" not in words[0] and (words[0] not in COMMANDS or words[0] == "desk"):
        raise UsageError(
            f"the desk shows a command of ./run, and {words[0]!r} is none",
            "For any program: ./run desk exec PROGRAM ...",
        )
    parser = parser_of("desk", module)
    options, rest = parser.parse_known_args(own[:at])
    if rest:
        raise parser.usage_error(f"unknown argument {rest[0]!r}")
    return options, words


def shown(words):
    """Adds to a command's words what makes it show something, if it has no window by itself."""
    name = words[0] if words else ""
    given = {word.partition(":=")[0] for word in words if ":=" in word}
    more = SHOWN.get(name, []) if not given & {"rviz", "gui"} and "--back" not in words else []
    return [*words, *more, *ALWAYS.get(name, [])]


def asked_password():
    """Returns the password of DESK_PASSWORD, or asks for one.

    Raises:
        UsageError: There is none, or VNC cannot use it.
    """
    from commands.desk.session import PASSWORD_LENGTHS

    password = os.environ.pop("DESK_PASSWORD", None)
    if password is None:
        if not sys.stdin.isatty():
            raise UsageError("--share needs a password, and DESK_PASSWORD is not set")
        password = getpass.getpass("password for the desk (6 to 8 characters): ")
    if len(password) not in PASSWORD_LENGTHS or not (password.isascii() and password.isprintable()):
        raise UsageError(
            f"the desk's password has {len(password)} characters; VNC takes 6 to 8 of ASCII"
        )
    return password


def complete(words):
    """Lists the commands that can stand on a desk."""
    from commands.table import COMMANDS

    return [name for name in COMMANDS if name != "desk"] if not words else []


def _size(text):
    if not re.fullmatch(r"[1-9]\d{2,3}x[1-9]\d{2,3}", text):
        raise UsageError(f"size is {text!r}; it must be WIDTHxHEIGHT in pixels, such as 1600x900")
    return text


def _port(text):
    if not (text.isascii() and text.isdigit() and 1 <= int(text) <= 65535):
        raise UsageError(f"port is {text!r}; it must be a whole number from 1 to 65535")
    return int(text)
