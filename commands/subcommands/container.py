"""Runs Paddock in a container, on systems without a ROS 1: builds the image, starts it.

It needs Podman, which need not be root's, or Docker, and nothing else: set-up happens in the image.
Its first build takes some minutes; later ones have nothing to do until the clone changes.

COMMAND is what otherwise stands behind ./run; without one: web, the world on a page in the browser.
  ./run container                                         # open the printed address
  ./run container desk                                    # the window, in the browser
  ./run container --workspace ~/catkin_ws exec roslaunch my_car drive.launch gui:=true
--workspace is a catkin workspace of yours: the packages of its src/ are built, at each start, in
the container, which reads but does not change them.

On Linux the container has this machine's network, so what it prints is what a browser here opens.
Elsewhere, and with --publish, ports 6080 (desk) and 7080 (page) are published on 127.0.0.1, for a
desk or page that is shared (COMMAND: web --share) with a password (DESK_PASSWORD, or
PADDOCK_WEB_PASSWORD, of the environment); in the printed address put 127.0.0.1 for the machine.
"""

import os
import shlex
import shutil
import sys

from commands import parsing
from commands.errors import CommandError, UsageError, say
from commands.paths import ROOT

USAGE = "[--workspace FOLDER] [--engine ENGINE] [--publish] [--print] [COMMAND ...]"
COMMAND = True  # options behind the command are its own
PASSES_ON = True
ENGINES = ("podman", "docker")
IMAGE = "paddock"
SOURCES = "/home/paddock/paddock/src/workspace"  # of the workspace, in the image
PORTS = (6080, 7080)  # the desk's and the page's
PASSWORDS = ("DESK_PASSWORD", "PADDOCK_WEB_PASSWORD")
SELINUX = "/sys/fs/selinux/enforce"
HOW = "Debian, Ubuntu, WSL: apt install podman; Fedora has it; macOS: Podman or Docker Desktop"


def add_arguments(parser):
    """Declares the options."""
    parser.add_argument("--workspace", metavar="FOLDER", help="a catkin workspace, with src/")
    parser.add_argument("--engine", metavar="ENGINE", help="podman or docker (what there is)")
    parser.add_argument("--publish", action="store_true", help="ports instead of the network")
    parser.add_argument("--print", action="store_true", help="print the two lines, run nothing")


def run(arguments):
    """Builds the image and becomes the container."""
    options, words = split(arguments)
    engine = options.engine or next(filter(shutil.which, ENGINES), None)
    publish = options.publish or sys.platform != "linux"
    terminal = options.print or (sys.stdin.isatty() and sys.stdout.isatty())
    lines = commands(engine or ENGINES[0], options.workspace, publish, terminal, words)
    if options.print:
        print(*map(shlex.join, lines), sep="\n")
        return 0
    if not engine or not shutil.which(engine):
        raise CommandError(f"there is no {engine or ' or '.join(ENGINES)} on this machine", HOW)
    build, start = lines
    say(shlex.join(build))
    import subprocess

    if subprocess.run(build, check=False).returncode != 0:
        raise CommandError(f"{engine} could not build the image", "docs/container.md has remedies")
    say(shlex.join(start))
    os.execvp(engine, start)


def split(arguments):
    """Parts the options from the command behind them.

    Returns:
        (argparse.Namespace, list of words).

    Raises:
        UsageError: A value cannot be used.
    """
    options, words = parsing.split("container", sys.modules[__name__], arguments, "runs")
    if options.engine not in (None, *ENGINES):
        raise UsageError(f"engine is {options.engine!r}; it must be {' or '.join(ENGINES)}")
    if options.workspace is not None:
        folder = os.path.abspath(os.path.expanduser(options.workspace))
        if not os.path.isdir(f"{folder}/src"):
            raise UsageError(f"workspace is {options.workspace!r}, which has no folder src")
        if ":" in folder:
            raise UsageError(f"workspace is {options.workspace!r}; a mount takes no ':' in it")
        options.workspace = folder
    return options, words


def commands(engine, workspace, publish, terminal, words):
    """Gives the two command lines.

    Args:
        engine: "podman" or "docker".
        workspace: Folder of a catkin workspace; None for none.
        publish: Whether ports are published; else the container has the machine's network.
        terminal: Whether it is started in one.
        words: The command of ./run and its arguments; none: web.

    Returns:
        (argv that builds the image, argv that starts it).
    """
    start = [engine, "run", "--rm", "--init"]
    if terminal:
        start.append("-it")
    if publish:
        for port in PORTS:
            start += ["-p", f"127.0.0.1:{port}:{port}"]
        start += [word for name in PASSWORDS if os.environ.get(name) for word in ("-e", name)]
    else:
        start += ["--network", "host"]
    if workspace is not None:
        start += ["-v", f"{workspace}/src:{SOURCES}:ro"]
        if os.path.exists(SELINUX):  # which lets no container read a home otherwise
            start += ["--security-opt", "label=disable"]
    return [engine, "build", "-t", IMAGE, ROOT], [*start, IMAGE, *(words or ["web"])]


complete = parsing.other_commands("container")
