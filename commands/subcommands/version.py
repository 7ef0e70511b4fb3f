"""Prints the version, and what somebody who helps needs to know of this machine.

Sets nothing up and starts nothing.
"""

import os
import platform
import re
import subprocess

from commands.bootstrap import ros, workspace
from commands.git import OURS
from commands.paths import ROOT, os_release, read


def run(_options, _rest):
    """Prints the lines."""
    print(f"Paddock {version()}{commit()}")
    print(f"{system()}, Python {platform.python_version()}, {platform.machine()}")
    on = f" on {ros.prefix()}" if ros.prefix() else ""
    print(f"built{on}" if os.path.exists(workspace.STAMP) else "not built yet: ./run setup")


def version():
    """Returns the version that pyproject.toml says."""
    text = read(os.path.join(ROOT, "pyproject.toml"))
    return re.search(r'^version = "(.*)"$', text, re.MULTILINE)[1]


def commit():
    """Returns the commit in brackets, "changed" if files differ; empty outside of a git clone."""
    describe = ["describe", "--always", "--dirty= changed", "--exclude=*"]
    try:
        done = subprocess.run([*OURS, *describe], capture_output=True, text=True, timeout=20)
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return f" ({done.stdout.strip()})" if done.returncode == 0 else ""


def system():
    """Returns the name of the operating system."""
    return os_release().get("PRETTY_NAME", platform.system())
