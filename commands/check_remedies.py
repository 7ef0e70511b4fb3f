"""What takes the place of what cannot work here, for ./run check: packages and plugins by name."""

import os
import re
import subprocess

from commands import sources
from commands.bootstrap import left_out
from commands.errors import CommandError
from commands.paths import GAZEBO
from commands.subcommands import deps

# Packages that have no sources for Noetic -> what does the same.
SAME = {"cmd_vel_mux": "twist_mux"}
# Libraries of Gazebo plugins that are not here -> what is.
PLUGINS = {
    "hector_gazebo_thermal_camera": "libgazebo_ros_camera.so has the image in its own colors",
}
GENERIC = "./run deps PATH names Debian's packages, others have to be in your workspace as sources"
_WITHOUT_PATH = re.compile(r"Package\[([^]]*)\] does not have a path")  # of gazebo_ros
_NOT_FOUND = re.compile(
    r"Resource not found: (?:The following package was not found in .*: )?([\w-]+)"
    r"|\b[Pp]ackage '([\w-]+)' not found"
)


def for_package(name, existing=deps.existing, resolve=deps.resolve):
    """A sentence's end: where a ROS package comes from, or what does the same.

    Args:
        existing: From names of Debian packages to those that exist.
        resolve: See deps.resolve().
    """
    if name in SAME:
        return f"{SAME[name]} does the same, it comes by ./run add"  # not by --for
    return from_debian(lambda: existing(resolve([name])[name])) or sources.adding(name) or GENERIC


def from_debian(find):
    """A sentence's end: how to install Debian's packages, or "" where there are none.

    Args:
        find: Function without arguments: names of the packages that exist; it asks apt.
    """
    try:
        known = find()
    except (OSError, subprocess.CalledProcessError, CommandError, SystemExit):  # no apt here
        known = ()
    return deps.apt_get(sorted(known))


def finding(text):
    """What a sentence says is missing, without the ones that there are or may be meant."""
    return text.partition("; ")[0]


def for_plugin(library, has_sources=False):
    """A sentence's end: what takes the place of a plugin's library (libNAME.so), or builds it.

    Args:
        has_sources: A package that is there has its sources.
    """
    name = re.sub("^lib", "", library).partition(".so")[0]
    is_built = has_sources and not os.path.isdir(GAZEBO)
    return PLUGINS.get(name, left_out.GAZEBO if is_built else left_out.OWN)


def named_packages(text):
    """Names of the packages that a message of roslaunch misses."""
    return [first or second for first, second in _NOT_FOUND.findall(text or "")]


def unspawned(report):
    """Names of the packages for whose lack spawn_urdf_model has refused a model."""
    names = [_WITHOUT_PATH.search(line) for line in report.get("errors", ())]
    return list(dict.fromkeys(name.group(1) for name in names if name))


def missing_packages(report):
    """Names of the packages that are not there, of what check_observer.py has written."""
    names = [
        package for package, is_there, *_ in report.get("builders", {}).values() if not is_there
    ]
    names += [*unspawned(report), *named_packages(report.get("refused"))]
    return list(dict.fromkeys(names))
