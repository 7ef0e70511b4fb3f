"""Set-up in three steps: Debian packages, Python packages in .venv, the catkin workspace.

A step whose inputs have not changed is skipped; an interrupted one leaves no stamp and is done
again by the next ./run. Two ./run at once wait for each other. ros.py tells on which ROS 1.
"""

import sys

from commands.bootstrap import packages, ros, venv, workspace
from commands.bootstrap.step import SetupLock


def prepare():
    """Does what is missing.

    Raises:
        CommandError: A step failed.
        Interrupted: A signal ended it.
    """
    with SetupLock():
        if ros.prefix():
            missing = not (venv.ready() and workspace.ready())
            if missing or sys.stdout.isatty():
                ros.announce()
            if missing:
                ros.check()
        packages.prepare()
        venv.prepare()
        workspace.prepare()
