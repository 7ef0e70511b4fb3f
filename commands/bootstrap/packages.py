"""Step 1, Debian packages: those of every set-up, those of ./run desk."""

import os

from commands import processes, signature
from commands.bootstrap import ros
from commands.bootstrap.step import STEPS, SetupLock, SpeakingStep
from commands.paths import ROOT

WANTED = os.path.join(ROOT, "config", "apt.txt")
FIRST_LIST = "apt-first.txt"  # in config/, as the other lists
INSTALLED = "/var/lib/dpkg/status"
DESK_SERVER_LIST = "apt-desk-server.txt"
DESK_LIST = "apt-desk.txt"
DESK_TEST_LIST = "apt-desk-test.txt"


def steps():
    """Installs what the other steps begin with, config/apt-first.txt; gives the step that installs
    the rest: config/apt.txt, and Debian's ROS in config/apt-ros.txt unless another one is used.

    It looks only if one of them or what is installed changed since last time.

    Returns:
        List of one step, or of none.

    Raises:
        SystemExit: It failed, and ./run has said why.
        Interrupted: A signal ended it.
    """
    key = f"{ROOT} {ros.prefix()}"
    if signature.unchanged("packages", key):
        return []
    _install(FIRST_LIST, str(STEPS))

    def install(_step):
        yield _command(), None
        first = os.path.join(ROOT, "config", FIRST_LIST)
        signature.save("packages", key, [WANTED, first, ros.LIST, INSTALLED])

    promises = ("packages",)
    return [SpeakingStep(1, "Debian packages", install, "", "install_packages", promises)]


def prepare_more(name, steps=1):
    """Installs what another list names and is missing; the caller holds the SetupLock.

    Args:
        name: The list, a file in config/; nothing happens if there is no such file.
        steps: How many steps the caller has, this one is the first.

    Raises:
        SystemExit: It failed, and ./run has said why.
        Interrupted: A signal ended it.
    """
    if os.path.exists(os.path.join(ROOT, "config", name)):
        _install(name, str(steps))


def prepare(*names):
    """Installs what lists name and is missing, after bootstrap.prepare(), see prepare_more()."""
    with SetupLock():
        for name in names:
            prepare_more(name)


def _install(*arguments):
    status = processes.run_child(_command(*arguments), session=False, grace=None)
    if status != 0:
        raise SystemExit(processes.exit_status(status))


def _command(*arguments):
    return ["bash", os.path.join(ROOT, "run"), "--packages", *arguments]
