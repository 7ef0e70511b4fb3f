#!/usr/bin/env python3
"""Disable the stand-ins of packages that are there: installed, or brought by a user.

Puts an (untracked) CATKIN_IGNORE file into each stand-in whose real package is below a ROS, below
ROS_PACKAGE_PATH or beside the stand-ins in the same workspace, removes it from the others, and
prints the names of those disabled. Run it before the build, with no environment of this workspace
sourced. ./run does the same by the functions below.
"""

import os
import re
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
MARKER = "CATKIN_IGNORE"
MARK = "by ./run: a real package of this name is used\n"
OURS_MARK = "by ./run: the stand-in of this name is used, as the real package needs Gazebo itself\n"
REFUSED_MARK = "by ./run: catkin refuses its package.xml\n"  # until the next build
LISTED_MARKS = (OURS_MARK, REFUSED_MARK)
IGNORE = (MARKER, "AMENT_IGNORE")
SKIPPED = ("build", "devel", "install")
DEFAULT_FOLDERS = ("/opt/ros/noetic/share", "/usr/share")
# Sources of these cannot be built without Gazebo: of what a user brings, these do not replace ours.
NEED_GAZEBO = (
    "gazebo_dev",
    "gazebo_plugins",
    "gazebo_ros",
    "gazebo_ros_control",
    "hector_gazebo_plugins",
    "realsense_gazebo_plugin",
    "roboticsgroup_gazebo_plugins",
    "roboticsgroup_upatras_gazebo_plugins",
    "steer_bot_hardware_gazebo",
)


def opened(path, flags):
    """Opens a file for open(): a pipe that nobody writes to is empty, and is not waited for."""
    return os.open(path, flags | os.O_NONBLOCK)


def read(path):
    """Returns a file's text; empty where there is no such file."""
    try:
        with open(path, encoding="utf-8", errors="replace", opener=opened) as stream:
            return stream.read()
    except OSError:
        return ""


def manifests_below(folder, skipped=None):
    """Lists the package.xml files at and below a folder, as catkin finds them.

    Args:
        skipped: A folder that is not searched; None: all are.
    """
    result, seen = [], set()
    for directory, below, files in os.walk(folder, followlinks=True):
        real = os.path.realpath(directory)
        if real in seen:  # a link to a folder above
            below[:] = []
            continue
        seen.add(real)
        own = "package.xml" in files and read(os.path.join(directory, MARKER)) in LISTED_MARKS
        if any(name in files for name in IGNORE) and not own:
            below[:] = []
        elif "package.xml" in files:
            result.append(os.path.join(directory, "package.xml"))
            below[:] = []
        else:
            below[:] = sorted(
                name
                for name in below
                if not name.startswith(".")
                and name not in SKIPPED
                and os.path.join(directory, name) != skipped
            )
    return result


def packages_below(folder, skipped=None):
    """Finds the packages at and below a folder, without those that catkin refuses: of each name its
    folder."""
    result = {}
    for path in manifests_below(folder, skipped):
        name, package = name_of(path), os.path.dirname(path)
        if name and read(os.path.join(package, MARKER)) != REFUSED_MARK:
            result.setdefault(name, package)
    return result


def name_of(manifest):
    """Returns the name of the package of a package.xml; empty: it has none."""
    named = re.search(r"<name>\s*(\S+?)\s*</name>", read(manifest))
    return named[1] if named else ""


def real_packages(folders):
    """Returns the names of all packages below some folders.

    Args:
        folders: where to search; stand-ins, also through links, are skipped.
    """
    standins = os.path.realpath(HERE) + os.sep
    result = set()
    for folder in filter(os.path.isdir, folders):
        if os.path.basename(os.path.normpath(folder)) == "share":  # installed: one folder a package
            below = {os.path.basename(path): path for path in _folders_of(folder)}
        else:
            below = packages_below(folder)
        result |= {
            name
            for name, path in below.items()
            if not (os.path.realpath(path) + os.sep).startswith(standins)
        }
    return result


def _folders_of(share):
    for entry in os.scandir(share):
        if os.path.isfile(os.path.join(entry.path, "package.xml")):
            yield entry.path


def give_way(folder, real, result=()):
    """Disables the stand-ins of real packages and enables the others.

    Args:
        folder: the folder of the stand-ins, one package per folder.
        real: names of the packages that exist elsewhere.
        result: names of stand-ins that are left out of the build, but stay findable.

    Returns:
        Sorted names of the disabled stand-ins.
    """
    disabled = []
    for name in sorted(os.listdir(folder)) if os.path.isdir(folder) else []:
        package = os.path.join(folder, name)
        if not os.path.isfile(os.path.join(package, "package.xml")):
            continue
        marker = os.path.join(package, MARKER)
        if name in real:
            disabled.append(name)
        if name in real and name not in result:
            if not os.path.exists(marker):
                _write(marker, MARK)
        elif os.path.exists(marker) and _is_ours(read(marker)):  # one by hand stays
            os.remove(marker)
    return disabled


def keep_ours(users):
    """Hides a user's copies of packages that need Gazebo, in whose place the stand-ins stay.

    Args:
        users: the user's packages: of each name its folder.

    Returns:
        Sorted names of the user's packages that are hidden.
    """
    hidden = sorted(set(users) & set(NEED_GAZEBO))
    for name in hidden:
        marker = os.path.join(users[name], MARKER)
        if not os.path.exists(marker):
            _write(marker, OURS_MARK)
    return hidden


def mark_refused(folders, refused):
    """Hides the packages of some folders that are refused, and no others of them."""
    for folder in folders:
        marker = os.path.join(folder, MARKER)
        if folder in refused:
            _write(marker, REFUSED_MARK)
        elif read(marker) == REFUSED_MARK:
            os.remove(marker)


def _is_ours(text):
    return text.startswith("by ./run:")


def _write(path, text):
    with open(path, "w", encoding="utf-8") as stream:
        stream.write(text)


def main():
    folders = os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep)
    users = packages_below(os.path.dirname(HERE), skipped=HERE)
    real = real_packages(list(DEFAULT_FOLDERS) + folders)
    real |= set(users) - set(keep_ours(users))
    for name in give_way(HERE, real):
        print(name)
    return 0


if __name__ == "__main__":
    sys.exit(main())
