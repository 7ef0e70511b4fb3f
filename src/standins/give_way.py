#!/usr/bin/env python3
"""Disable the stand-ins of packages that are installed on the machine.

Puts an (untracked) CATKIN_IGNORE file into each stand-in whose package rospkg finds outside
this source folder, removes it from the others, and prints the names of those disabled.
Run it before the build, with no environment of this workspace sourced.
"""

import os
import sys

import rospkg

HERE = os.path.dirname(os.path.abspath(__file__))
MARKER = "CATKIN_IGNORE"
DEFAULT_FOLDERS = ("/opt/ros/noetic/share", "/usr/share")


def real_packages(folders):
    """Returns the names of all packages below some folders.

    Args:
        folders: where to search; packages in this workspace, also through links, are skipped.
    """
    workspace = os.path.dirname(os.path.dirname(os.path.realpath(HERE))) + os.sep

    def _outside(path):
        return not (os.path.realpath(path) + os.sep).startswith(workspace)

    rospack = rospkg.RosPack([p for p in folders if os.path.isdir(p) and _outside(p)])
    return {name for name in rospack.list() if _outside(rospack.get_path(name))}


def give_way(folder, real):
    """Disables the stand-ins of installed packages and enables the others.

    Args:
        folder: the folder of the stand-ins, one package per folder.
        real: names of the packages that exist elsewhere.

    Returns:
        Sorted names of the disabled stand-ins.
    """
    disabled = []
    for name in sorted(os.listdir(folder)):
        package = os.path.join(folder, name)
        if not os.path.isfile(os.path.join(package, "package.xml")):
            continue
        marker = os.path.join(package, MARKER)
        if name in real:
            disabled.append(name)
            with open(marker, "w", encoding="utf-8"):
                pass
        elif os.path.exists(marker):
            os.remove(marker)
    return disabled


def main():
    folders = os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep)
    for name in give_way(HERE, real_packages(list(DEFAULT_FOLDERS) + folders)):
        print(name)
    return 0


if __name__ == "__main__":
    sys.exit(main())
