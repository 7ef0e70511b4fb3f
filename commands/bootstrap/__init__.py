"""Set-up: Debian packages, Python packages in .venv, the catkin workspace, the solver.

These four steps run beside each other as far as they can. One whose inputs have not changed is
skipped; an interrupted one leaves no stamp and is done again by the next ./run. Two ./run at once
wait for each other. ros.py tells on which ROS 1.
"""

import sys

from commands.bootstrap import packages, ros, venv, workspace
from commands.bootstrap.step import SetupLock, run_beside
from commands.errors import CommandError
from commands.paths import OWN, ROOT


def need_own():
    """Refuses to change another user's clone.

    Raises:
        CommandError: It is one.
    """
    if OWN:
        return
    if not ready():
        raise CommandError(
            f"{ROOT} is not set up, and belongs to another user",
            "Its owner has to type ./run setup there.",
        )
    raise CommandError(
        f"{ROOT} belongs to another user, who alone can do that",
        "Your own packages: source its setup.bash, then catkin_make in a workspace of yours.",
    )


def ready():
    """Returns whether nothing is missing; Debian packages are not looked at."""
    return venv.ready() and workspace.ready()


def prepare():
    """Does what is missing.

    Raises:
        CommandError: A step failed, or the clone is another user's.
        SystemExit: Debian packages could not be installed, and ./run has said why.
        Interrupted: A signal ended it.
    """
    need_own()
    with SetupLock():
        if ros.prefix():
            missing = not ready()
            if missing or sys.stdout.isatty():
                ros.announce()
            if missing:
                ros.check()
        steps = [*packages.steps(), *venv.steps()]
        steps += workspace.steps(changing=bool(steps))
        if steps:
            run_beside(steps)
