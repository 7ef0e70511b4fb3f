"""Runs COMMAND on a Debian with nothing installed; needs root.

The Debian is a folder that mmdebstrap fills (kept for later runs), the project in it a clone of
what is committed here. COMMAND is ./run test by default; a single word is a line of bash:
  ./run bare
  ./run bare --suite trixie ./run demo
  ./run bare './run demo && ./run test soak'
The exit status is the command's. What it leaves in test-results/ goes to test-results/ here, or to
test-results/bare/ if this clone has results of its own; what it leaves in out/ goes to out/bare/.

Nothing of the machine stays: no process, no mount, no folder, also after Ctrl-C. Downloaded
packages are kept in ~/.cache/paddock/bare and can be deleted at any time. It uses the network, the
mirror of Debian, the proxies and the settings of pip of this machine.
"""

import os
import shutil
import subprocess
import sys

from commands import parsing, processes
from commands.bare.host import SUITES
from commands.errors import CommandError, say
from commands.git import OURS
from commands.paths import OUT, ROOT, SYSTEM_PATH

USAGE = "[--suite bookworm|trixie] [COMMAND ...]"
COMMAND = True  # options behind the command are its own
PASSES_ON = True
DEFAULT = ["./run", "test"]
PACKAGES = "apt-bare.txt"  # in config/
TOOLS = ("bwrap", "git", "mmdebstrap", "pip3")
RESULTS = os.path.join(ROOT, "test-results")
MARK = "bare.txt"  # in a folder of results: they are a bare machine's


class Refusal(CommandError):
    """This machine cannot have a bare one."""

    status = 2


def add_arguments(parser):
    """Declares the suite and --check."""
    parser.add_argument(
        "--suite",
        metavar="SUITE",
        default="bookworm",
        type=parsing.one_of("suite", SUITES),
        help="of Debian: bookworm (12, the default) or trixie (13)",
    )
    parser.add_argument(
        "--check", action="store_true", help="only say whether it works here: exit status 0 or 2"
    )


def run(arguments):
    """Runs the command; its exit status is the machine's."""
    from commands.bare.machine import Machine

    options, words = parsing.split("bare", sys.modules[__name__], arguments)
    words = words or DEFAULT
    check()
    if options.check:
        return 0
    prepare()
    results = RESULTS if ours() else os.path.join(RESULTS, "bare")
    with processes.Signals() as signals, Machine(options.suite, signals) as machine:
        machine.make()
        announce(options.suite, words, results)
        status = machine.run(words)
        machine.copy_results(
            {"test-results": results, "out": os.path.join(OUT, "bare")},
            mark=(MARK, f"results of ./run bare {' '.join(words)}\n"),
        )
    return status


def check():
    """Refuses what cannot work, before anything is made.

    Raises:
        Refusal: Something is missing.
    """
    from commands.bare.machine import isolation

    if os.geteuid() != 0:
        raise Refusal(
            f"a bare machine needs root (for mmdebstrap, mount and chroot), and this is user "
            f"{os.geteuid()}; sudo ./run bare would do"
        )
    missing = missing_tools()
    if missing and not shutil.which("apt-get", path=SYSTEM_PATH):
        raise Refusal(
            f"a bare machine needs {' and '.join(missing)}, and there is no apt-get to install "
            "what is missing; a Debian has it"
        )
    if not os.path.exists(os.path.join(ROOT, ".git")):
        raise Refusal(
            f"a bare machine gets what is committed, and {ROOT} is no git clone; git clone makes "
            "one"
        )
    if not isolation():
        raise Refusal(
            "a bare machine needs the right to mount and to chroot, which root has not here; a "
            "machine of its own, or a container with CAP_SYS_ADMIN (--privileged), would do"
        )


def missing_tools():
    """Lists the programs that are not installed here."""
    path = f"{os.environ.get('PATH', '')}:{SYSTEM_PATH}"
    return [name for name in TOOLS if not shutil.which(name, path=path)]


def prepare():
    """Installs what is missing of TOOLS."""
    if missing_tools():
        from commands.bootstrap import packages

        packages.prepare(PACKAGES)


def ours():
    """Returns whether ./test-results may be replaced: there is none, or a bare machine's alone."""
    if not os.path.isdir(RESULTS) or not os.listdir(RESULTS):
        return True
    mark = os.path.join(RESULTS, MARK)
    if not os.path.isfile(mark):
        return False
    paths = (os.path.join(folder, name) for folder, _, names in os.walk(RESULTS) for name in names)
    written = (os.lstat(path).st_mtime for path in paths)
    return max(written) <= os.stat(mark).st_mtime  # ./run test has not been here since


def announce(suite, words, results):
    """Tells what runs where, before it does: the command's own last line stays the last."""
    state = subprocess.run([*OURS, "status", "--porcelain"], capture_output=True, text=True)
    changed = len(state.stdout.splitlines())
    if changed:
        say(f"bare: not in it: {changed} changed or new files, which are not committed")
    say(f"bare: Debian {suite}, results go to {os.path.relpath(results, ROOT)}/ and out/bare/")
    say(f"bare: {' '.join(words)}")
