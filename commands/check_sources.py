"""Which sources build a plugin or program that is missing, for ./run check."""

import os
import re

import rospkg

from commands import check_remedies

_LIBRARY = re.compile(r"lib([\w.+-]+)\.so")
_BUILT = re.compile(r"(?:add_library|add_executable)\s*\(\s*([^\s)]+)([^)]*)", re.IGNORECASE)
# Headers that a C++ file includes and that do not exist here -> whose they are.
ABSENT = {
    "gazebo": "Gazebo's headers",
    "ignition": "Gazebo's headers",
    "controller_interface": "ros_control's headers",
    "controller_manager": "ros_control's headers",
    "hardware_interface": "ros_control's headers",
}
_INCLUDED = re.compile(r"#\s*include\s*[<\"](\w+)/")
_PROJECT = re.compile(r"project\s*\(\s*(\w+)", re.IGNORECASE)
_INSIDE = re.compile(r"^\s*add_subdirectory\s*\(\s*([^\s)]+)", re.IGNORECASE | re.MULTILINE)
SOURCES_LIMIT = 400  # packages whose CMakeLists.txt is read
SUBFOLDERS = 4  # depth to which add_subdirectory is followed


def builders(report):
    """Looks for the packages that would build what is missing.

    Args:
        report: What was observed: models with their losses, nodes that cannot start.

    Returns:
        Dict from a library's or program's name to (package, whether its sources are there, headers
        that they need and that do not exist here): nodes of packages that are not installed have
        (package, False, "").
    """
    rospack = rospkg.RosPack()
    wanted, answer = set(), {}
    for text in report.get("lost", []) + [
        text for model in report.get("models", ()) for text in model["lost"]
    ]:
        wanted.update(_LIBRARY.findall(check_remedies.finding(text)))
    for package, kind in report["cannot"]:
        if package not in rospack.list():
            answer[kind] = (package, False, "")
        else:
            wanted.add(kind)
    if wanted:
        answer.update(_found_in_sources(rospack, wanted))
    return answer


def _found_in_sources(rospack, wanted):
    answer = {}
    for package in rospack.list()[:SOURCES_LIMIT]:
        project = None
        for folder, text in _cmake_files(rospack.get_path(package)):
            project = project or _PROJECT.search(text)
            for name, files in _BUILT.findall(text):
                name = name.replace("${PROJECT_NAME}", project.group(1) if project else "")
                if name in wanted:
                    answer[name] = (package, True, _against(folder, files.split()))
    return answer


def _cmake_files(folder, depth=0):
    """(folder, text) of a CMakeLists.txt and of those that it names with add_subdirectory."""
    try:
        with open(
            os.path.join(folder, "CMakeLists.txt"), encoding="utf-8", errors="replace"
        ) as stream:
            text = stream.read()
    except OSError:
        return
    yield folder, text
    for name in _INSIDE.findall(text) if depth < SUBFOLDERS else ():
        yield from _cmake_files(os.path.join(folder, name.strip('"')), depth + 1)


def _against(folder, files):
    """Whose headers the sources of a target include that do not exist here; "" if none."""
    for name in files:
        try:
            with open(os.path.join(folder, name), encoding="utf-8", errors="replace") as stream:
                included = _INCLUDED.findall(stream.read())
        except OSError:  # a word of CMake
            continue
        owners = [ABSENT[header] for header in included if header in ABSENT]
        if owners:
            return owners[0]
    return ""
