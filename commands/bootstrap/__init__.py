"""Set-up: Debian packages, Python packages in .venv, the catkin workspace, the solver.

These four steps run beside each other as far as they can. One whose inputs have not changed is
skipped; an interrupted one leaves no stamp and is done again by the next ./run. Two ./run at once
wait for each other. ros.py tells on which ROS 1.
"""

import sys

from commands.bootstrap import packages, ros, venv, workspace
from commands.bootstrap.step import SetupLock, run_beside


def prepare():
    """Does what is missing.

    Raises:
        CommandError: A step failed.
        SystemExit: Debian packages could not be installed, and ./run has said why.
        Interrupted: A signal ended it.
    """
    with SetupLock():
        if ros.prefix():
            missing = not (venv.ready() and workspace.ready())
            if missing or sys.stdout.isatty():
                ros.announce()
            if missing:
                ros.check()
        steps = [*packages.steps(), *venv.steps()]
        steps += workspace.steps(changing=bool(steps))
        if steps:
            run_beside(steps)
