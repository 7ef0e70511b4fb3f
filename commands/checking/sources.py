"""Which package holds the C++ sources of a plugin or node that is not there."""

import os
import re

import rospkg

_LIBRARY = re.compile(r"lib([\w.+-]+)\.so")
_BUILT = re.compile(r"(?:add_library|add_executable)\s*\(\s*(\S+)", re.IGNORECASE)
_PROJECT = re.compile(r"project\s*\(\s*(\w+)", re.IGNORECASE)
LIMIT = 400  # CMakeLists.txt files that are read


def builders(found):
    """Looks for the packages that would build what is missing.

    Args:
        found: What observer.py has found: models with their losses, nodes that cannot start.

    Returns:
        Dict from a library's or program's name to (package, whether its sources are there): nodes
        of packages that are not installed have (package, False).
    """
    rospack = rospkg.RosPack()
    wanted, answer = set(), {}
    for text in found.get("lost", []) + [
        text for model in found.get("models", ()) for text in model["lost"]
    ]:
        wanted.update(_LIBRARY.findall(text))
    for package, kind in found["cannot"]:
        if package not in rospack.list():
            answer[kind] = (package, False)
        else:
            wanted.add(kind)
    if wanted:
        answer.update(_found_in_sources(rospack, wanted))
    return answer


def _found_in_sources(rospack, wanted):
    answer = {}
    for package in rospack.list()[:LIMIT]:
        path = os.path.join(rospack.get_path(package), "CMakeLists.txt")
        if not os.path.isfile(path):
            continue
        with open(path, encoding="utf-8", errors="replace") as stream:
            text = stream.read()
        project = _PROJECT.search(text)
        for name in _BUILT.findall(text):
            name = name.rstrip(")").replace("${PROJECT_NAME}", project.group(1) if project else "")
            if name in wanted:
                answer[name] = (package, True)
    return answer
