"""Step 1, Debian packages: those of every set-up, those of ./run desk."""

import os

from commands import processes, signature
from commands.bootstrap import ros
from commands.bootstrap.step import SetupLock
from commands.paths import ROOT

WANTED = os.path.join(ROOT, "config", "apt.txt")
INSTALLED = "/var/lib/dpkg/status"
DESK_LIST = "apt-desk.txt"  # in config/
DESK_TEST_LIST = "apt-desk-test.txt"


def prepare():
    """Installs what is missing of config/apt.txt, and of Debian's ROS in config/apt-ros.txt unless
    another one is used; looks only if one of them or what is installed changed since last time.

    Raises:
        SystemExit: It failed, and ./run has said why.
        Interrupted: A signal ended it.
    """
    key = f"{ROOT} {ros.prefix()}"
    if signature.unchanged("packages", key):
        return
    _install()
    signature.save("packages", key, [WANTED, ros.LIST, INSTALLED])


def prepare_more(name, steps=1):
    """Installs what another list names and is missing; the caller holds the SetupLock.

    Args:
        name: The list, a file in config/.
        steps: How many steps the caller has, this one is the first.

    Raises:
        SystemExit: It failed, and ./run has said why.
        Interrupted: A signal ended it.
    """
    _install(name, str(steps))


def _install(*arguments):
    command = ["bash", os.path.join(ROOT, "run"), "--packages", *arguments]
    status = processes.run_child(command, session=False, grace=None)
    if status != 0:
        raise SystemExit(processes.exit_status(status))


def prepare_browser():
    """Installs Chromium and what drives it, after bootstrap.prepare().

    Raises:
        SystemExit: Debian packages could not be installed, and ./run has said why.
        Interrupted: A signal ended it.
    """
    with SetupLock():
        prepare_more(DESK_TEST_LIST)


def prepare_desk(tests=False):
    """Installs what is missing, after bootstrap.prepare().

    Args:
        tests: Whether ./run test desk is to run.

    Raises:
        SystemExit: Debian packages could not be installed, and ./run has said why.
        Interrupted: A signal ended it.
    """
    with SetupLock():
        prepare_more(DESK_LIST)
        if tests:
            prepare_more(DESK_TEST_LIST)
