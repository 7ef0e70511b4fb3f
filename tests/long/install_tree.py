"""The install space in a temporary directory, and what runs from it with nothing else sourced."""

import os
import re
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import psutil

ROOT = Path(__file__).resolve().parents[2]
BUILD = ROOT / "build"
INSTALL_LIMIT = 400.0  # wall time of the install rules [s]
COMMAND_LIMIT = 180.0  # wall time of one command in the install space [s]


@dataclass(frozen=True)
class Overlay:
    """What Launched starts a launch file from: the install space, seen from one of its packages."""

    package: str
    setup: Path
    environment: dict


class InstallSpace:
    """What `catkin_make install` leaves, moved away from where it was installed to.

    The checkout's own build folder is installed through DESTDIR, as packagers do; its devel space
    and its install folder stay as they are.

    Attributes:
        prefix: Path of the install space.
        environment: Variables before its setup.bash is sourced: nothing of the devel space.
    """

    def __init__(self):
        self._directory = tempfile.TemporaryDirectory(prefix="install_space_")
        self.path = Path(self._directory.name)
        self.prefix = self.path / "install"
        (self.path / "home").mkdir()
        self.environment = {
            "HOME": str(self.path / "home"),
            "LANG": "C.UTF-8",
            "PATH": f"{Path(sys.prefix) / 'bin'}:/usr/sbin:/usr/bin:/sbin:/bin",
            "ROS_IP": "127.0.0.1",
        }

    def install(self):
        """Installs.

        Raises:
            AssertionError: An install rule failed; the message holds the output.
        """
        for script in BUILD.glob("**/catkin_generated/python_distutils_install.sh"):
            # setup.py copies here first and would install modules that have gone since
            shutil.rmtree(script.parents[1] / "lib", ignore_errors=True)
        destination = self.path / "destdir"
        done = subprocess.run(
            ["cmake", "--install", str(BUILD)],
            env=dict(os.environ, DESTDIR=str(destination)),
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            check=False,
            timeout=INSTALL_LIMIT,
        )
        if done.returncode != 0:
            raise AssertionError(f"the install rules fail:\n{done.stdout}")
        installed = cache_entry("CMAKE_INSTALL_PREFIX").lstrip(os.sep)
        (destination / installed).rename(self.prefix)

    def overlay(self, package):
        """Gives what Launched needs for a launch file of a package."""
        return Overlay(package, self.prefix / "setup.bash", self.environment)

    def run(self, *command, limit=COMMAND_LIMIT, **variables):
        """Runs a command with the install space sourced and nothing else.

        Args:
            limit: Wall time [s].
            variables: Of the environment, set after the install space is sourced.

        Returns:
            subprocess.CompletedProcess with the texts of stdout and stderr.
        """
        line = f'source {self.prefix}/setup.bash && exec env "$@"'
        given = [f"{name}={value}" for name, value in variables.items()]
        return subprocess.run(
            ["bash", "-c", line, "bash", *given, *map(str, command)],
            env=self.environment,
            cwd=self.path,
            capture_output=True,
            text=True,
            check=False,
            timeout=limit,
        )

    def close(self):
        """Deletes it."""
        self._directory.cleanup()


def cache_entry(name):
    """Gives the value of an entry of the build's CMakeCache.txt."""
    text = (BUILD / "CMakeCache.txt").read_text()
    return re.search(rf"^{name}:\w+=(.*)$", text, re.MULTILINE).group(1)


def descendants(pid):
    """Gives the ids of the processes that a process has started, and they in turn."""
    return [child.pid for child in psutil.Process(pid).children(recursive=True)]
