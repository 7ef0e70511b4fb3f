"""Step 1, Debian packages. ./run does it in bash, as there may be no python3 yet."""

import os

from commands import processes, signature
from commands.paths import ROOT

WANTED = os.path.join(ROOT, "config", "apt.txt")
INSTALLED = "/var/lib/dpkg/status"


def prepare():
    """Installs what config/apt.txt names and is missing, unless neither changed since last time.

    Raises:
        SystemExit: It failed, and ./run has said why.
        Interrupted: A signal ended it.
    """
    if signature.unchanged("packages", ROOT):
        return
    status = processes.run_child(
        ["bash", os.path.join(ROOT, "run"), "--packages"], session=False, grace=None
    )
    if status != 0:
        raise SystemExit(status if status > 0 else 128 - status)
    signature.save("packages", ROOT, [WANTED, INSTALLED])
