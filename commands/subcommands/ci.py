"""Builds and tests the packages at and below PATH as a CI does it: from nothing to JUnit files.

Sets up what is missing, installs the Debian packages that their package.xml files ask for (as root
or through sudo), builds them in a workspace of its own on top of this one, and runs what is in
their folders test/ and tests/: each .test by rostest, test_*.py by pytest. JUnit files and logs go
to --out, and so does what tests write to the folder PADDOCK_RESULTS, such as films. Exits 0 only if
at least one test ran and none failed. docs/ci.md has a workflow file.
"""

import os

from commands import environment
from commands.errors import CommandError, UsageError, say

USAGE = "[--out FOLDER] [PATH]"


def add_arguments(parser):
    """Declares path and --out."""
    parser.add_argument(
        "path", nargs="?", default=".", metavar="PATH", help="a package or a workspace (.)"
    )
    parser.add_argument(
        "--out", default="paddock-results", metavar="FOLDER", help="of results (paddock-results)"
    )


def run(options, _rest):
    """Builds and tests.

    Raises:
        CommandError: Something does not build, or a test failed.
    """
    from commands.ci import Tests, Workspace, install_dependencies

    if not os.path.isdir(options.path):
        raise UsageError(f"path is {options.path!r}; it must be a folder")
    workspace = Workspace(options.path)
    environ = environment.ready()
    install_dependencies(options.path, environ)
    tests = Tests(workspace, environ, options.out)
    workspace.build(tests.run_logged, environ)
    tests.run()
    say(f"results in {options.out}/: {tests.passed} passed, {len(tests.failed)} files failed")
    if tests.failed:
        raise CommandError(f"tests failed: {', '.join(tests.failed)}")
    if not tests.passed:
        raise CommandError(
            "there is no test to run", "Put a .test or test_*.py into the package's folder test/"
        )
