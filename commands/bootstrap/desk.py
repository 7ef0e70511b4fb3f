"""What ./run desk needs beyond the set-up: noVNC, which brings nodejs; its tests: Chromium."""

from commands.bootstrap import packages
from commands.bootstrap.lock import SetupLock

PACKAGES = "apt-desk.txt"  # in config/
OF_TESTS = "apt-desk-test.txt"


def prepare(tests=False):
    """Installs what is missing, after bootstrap.prepare().

    Args:
        tests: Whether ./run test desk is to run.

    Raises:
        SystemExit: Debian packages could not be installed, and ./run has said why.
        Interrupted: A signal ended it.
    """
    with SetupLock():
        packages.prepare_more(PACKAGES)
        if tests:
            packages.prepare_more(OF_TESTS)
