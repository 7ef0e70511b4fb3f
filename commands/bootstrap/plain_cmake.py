"""Packages of users that catkin does not build, by <build_type> of their package.xml.

Those of plain CMake are built before the workspace and installed into devel/, where its packages
find them. Those of other tools (ROS 2's ament) are left out.
"""

import os
import re
from xml.etree import ElementTree

from commands.bootstrap import left_out
from commands.bootstrap.step import StepFailed
from commands.paths import BUILD, DEVEL, ROOT, read

PLAIN, CATKIN = "cmake", "catkin"
NO_TESTS = os.path.join(ROOT, "config", "cmake", "without_tests.cmake")
WITHOUT_TESTS, WITH_TESTS = f"-DCMAKE_PROJECT_INCLUDE={NO_TESTS}", "-UCMAKE_PROJECT_INCLUDE"
NOT_BUILT = "file INSTALL cannot find"  # what CMake says
OPTIONS = os.path.join(ROOT, "config", "cmake", "plain")  # NAME.cmake sets options of a package
FOLDER = os.path.join(BUILD, "plain")
JOB = 1.5e6  # of memory for a compiler, as those of PCL's and Ceres's templates take [kB]


def foreign(packages):
    """Finds packages that are not catkin's.

    Args:
        packages: Of each name the folder.

    Returns:
        Dict from the name to the build type.
    """
    result = {name: _build_type(folder) for name, folder in packages.items()}
    return {name: kind for name, kind in result.items() if kind != CATKIN}


def _build_type(folder):
    try:
        root = ElementTree.fromstring(read(os.path.join(folder, "package.xml")))
    except (ValueError, ElementTree.ParseError):
        return CATKIN  # which says what is wrong with it
    kinds = [
        (element.text or "").strip()
        for element in root.findall("export/build_type")
        if "2" not in element.get("condition", "")  # $ROS_VERSION == 2
    ]
    return kinds[0] if kinds and kinds[0] else CATKIN


def build(step, environ, packages):
    """Builds the packages of plain CMake, each after those that it asks for.

    Args:
        packages: All packages of a user: of each name the folder.

    Yields:
        Command lines with their environment, as Step takes them.

    Returns:
        List of LeftOut: what is of another tool or could not be built.
    """
    kinds = foreign(packages)
    refused = [
        left_out.LeftOut(name, "", f"its build type is {kind}, catkin's and cmake are built here")
        for name, kind in sorted(kinds.items())
        if kind != PLAIN
    ]
    for name in _in_order({name: packages[name] for name, kind in kinds.items() if kind == PLAIN}):
        text = yield from _build(step, environ, packages[name], name, WITHOUT_TESTS)
        if NOT_BUILT in text:  # it installs its programs for tests
            text = yield from _build(step, environ, packages[name], name, WITH_TESTS)
        if text:
            refused.append(left_out.of_plain_cmake(name, text))
    return refused


def _build(step, environ, folder, name, option):
    """Builds a package, with an option of cmake; returns the log of a failure, else nothing."""
    begin = os.path.getsize(step.log) if step.begun is not None else 0
    into = os.path.join(FOLDER, name)
    prefixes = [DEVEL, *filter(None, environ.get("CMAKE_PREFIX_PATH", "").split(":"))]
    cache = os.path.join(OPTIONS, f"{name}.cmake")
    try:
        yield (
            [
                *("cmake", "-S", folder, "-B", into),
                *(("-C", cache) if os.path.exists(cache) else ()),
                f"-DCMAKE_INSTALL_PREFIX={DEVEL}",
                f"-DCMAKE_PREFIX_PATH={';'.join(prefixes)}",
                "-DCMAKE_BUILD_TYPE=Release",
                "-DBUILD_TESTING=OFF",
                option,
            ],
            environ,
        )
        yield ["make", "-C", into, "-O", jobs(), "install"], environ
    except StepFailed:
        with open(step.log, encoding="utf-8", errors="replace") as stream:
            stream.seek(begin)
            return stream.read()
    return ""


def jobs(memory="/proc/meminfo"):
    """Returns make's option: as many compilers as there are cores, and memory that is free."""
    free = re.search(r"MemAvailable: *(\d+)", read(memory))
    cores = len(os.sched_getaffinity(0))
    return f"-j{max(1, min(cores, int(free[1]) // int(JOB))) if free else cores}"


def _in_order(packages):
    """Lists names so that each comes after what its package.xml asks for."""
    wanted = {name: left_out.asked_for(folder) for name, folder in packages.items()}
    result = []
    while len(result) < len(packages):
        rest = [name for name in sorted(packages) if name not in result]
        free = [name for name in rest if not (wanted[name] & set(rest)) - {name}]
        result += free or rest  # a circle is cmake's to name
    return result
