"""Names what the package.xml files at and below PATH ask for, and which Debian package has it.

Packages of the folder itself and of Paddock (with its stand-ins for what Debian lacks) count as
there. --names prints only the Debian packages to install, for scripts. Exits 0 if everything is
there or in Debian, 1 if something is neither in Debian nor in Paddock.
"""

import os

from commands import dependencies
from commands.errors import CommandError, UsageError, say

USAGE = "[--names] [PATH]"


def add_arguments(parser):
    """Declares path and --names."""
    parser.add_argument(
        "path", nargs="?", default=".", metavar="PATH", help="a package or a workspace (.)"
    )
    parser.add_argument(
        "--names", action="store_true", help="only the names of Debian packages to install"
    )


def run(options, _rest):
    """Prints the answer.

    Raises:
        CommandError: apt has no lists, so it would know nothing.
    """
    if not os.path.isdir(options.path):
        raise UsageError(f"path is {options.path!r}; it must be a folder")
    if not dependencies.has_lists():
        raise CommandError("apt has no lists of packages", "As root: apt-get update")
    found = dependencies.find(options.path)
    if options.names:
        say("\n".join(dependencies.to_install(found)), end="\n" if found.missing else "")
    else:
        say("\n".join(dependencies.page(found)))
    return 1 if found.nowhere else 0
