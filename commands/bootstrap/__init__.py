"""Set-up in three steps: Debian packages, Python packages in .venv, the catkin workspace.

A step whose inputs have not changed is skipped; an interrupted one leaves no stamp and is done
again by the next ./run. Two ./run at once wait for each other.
"""

from commands.bootstrap import packages, venv, workspace
from commands.bootstrap.step import SetupLock


def prepare():
    """Does what is missing.

    Raises:
        CommandError: A step failed.
        Interrupted: A signal ended it.
    """
    with SetupLock():
        packages.prepare()
        venv.prepare()
        workspace.prepare()
