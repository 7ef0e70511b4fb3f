"""Installs and builds what is missing, and starts nothing.

Installs the Debian packages of config/apt.txt that are missing (as root, or with sudo), puts the
packages of config/requirements.txt into .venv and builds the catkin workspace into build/ and
devel/. Steps whose inputs have not changed are skipped; an interrupted set-up can be started
again. Details go to .cache/log/.
"""

from commands import bootstrap
from commands.errors import say
from commands.paths import ROOT


def run(_options, _rest):
    """Sets up."""
    bootstrap.prepare()
    say(f"ready: {ROOT}")
