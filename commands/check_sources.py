"""Which sources build a plugin or program that is missing, for ./run check."""

import glob
import os
import re

import rospkg

from commands import check_remedies, check_verdict
from commands.bootstrap import left_out
from commands.paths import read

_LIBRARY = re.compile(r"lib([\w.+-]+)\.so")
_BUILT = re.compile(r"(?:add_library|add_executable)\s*\(\s*([^\s)]+)([^)]*)", re.IGNORECASE)
_INCLUDED = re.compile(r"#\s*include\s*[<\"](\w+)/")
_PROJECT = re.compile(r"project\s*\(\s*(\w+)", re.IGNORECASE)
SOURCES_LIMIT = 400  # packages whose CMakeLists.txt are read


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
    for text in check_verdict.losses(report):
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
        below, project = f"{glob.escape(rospack.get_path(package))}/**/CMakeLists.txt", None
        for path in sorted(glob.glob(below, recursive=True), key=len):  # the package's own first
            text = read(path)
            project = project or _PROJECT.search(text)
            for name, files in _BUILT.findall(text):
                name = name.replace("${PROJECT_NAME}", project.group(1) if project else "")
                if name in wanted:
                    answer[name] = (package, True, _against(os.path.dirname(path), files.split()))
    return answer


def _against(folder, files):
    """Whose headers the sources of a target include that do not exist here; "" if none."""
    for path in filter(os.path.isfile, (os.path.join(folder, name) for name in files)):
        for header in _INCLUDED.findall(read(path)):
            if owner := left_out.owner_of(header):
                return f"{owner}'s headers"
    return ""
