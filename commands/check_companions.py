"""Launch files that bring what the checked ones do not, for ./run check: a world, robot, spawner.

Many packages split them: one file starts the world, another spawns the robot or its controllers.
"""

import os
import re

from commands.bootstrap import workspace
from commands.paths import read, read_xml
from commands.subcommands import deps

BRINGS = {  # what is missing -> text of a launch file that brings it
    "world": re.compile(r"empty_world\.launch|type=[\"'](?:gzserver|gazebo)[\"']"),
    "robot": re.compile(r"type=[\"']spawn_(?:model|urdf)[\"']"),
    "controllers": re.compile(
        r"type=[\"']spawner[\"']|type=[\"']controller_manager[\"'][^>]*spawn"
    ),
}
LISTED = 3  # files that a sentence names


def find(folder, package_path, checked=()):
    """Looks through the launch files of a package and of those beside it.

    Args:
        folder: Of the package.
        package_path: ROS_PACKAGE_PATH; above its folders nothing is searched.
        checked: (package, file) of what was checked, which is left out.

    Returns:
        Dict from "world", "robot", "controllers" to a list of (package, file): those that bring it,
        first those that a README names, then the same package's. Files with a world of their own
        bring nothing but that.
    """
    companions = {name: [] for name in BRINGS}
    parent = os.path.dirname(folder)
    sources = [path.rstrip("/") for path in package_path.split(":") if path]
    inside = any(f"{parent}/".startswith(f"{path}/") for path in sources)
    is_installed = os.path.basename(parent) == "share"  # all packages of a ROS
    beside = workspace.manifests_of(parent if inside and not is_installed else folder)
    for package, path in sorted(beside.items(), key=lambda item: (item[1] != folder, item[0])):
        if workspace.top(os.path.realpath(path)) in workspace.OURS:
            continue
        for name, file in ((os.path.basename(file), file) for file in deps.launch_files(path)):
            if (package, name) in checked:
                continue
            text = read_xml(file)
            brings = [what for what, pattern in BRINGS.items() if pattern.search(text)]
            for what in ["world"] if "world" in brings else brings:
                companions[what].append((package, name))
    readmes = _readmes(parent if len(beside) > 1 else folder, beside.values())
    for files in companions.values():
        files.sort(key=lambda file: not re.search(rf"(?<![\w-]){re.escape(file[1])}", readmes))
    return companions


def _readmes(folder, packages):
    """Text of the README files in some folders."""
    texts = []
    for path in {folder, *packages}:
        names = os.listdir(path) if os.path.isdir(path) else ()
        paths = [os.path.join(path, name) for name in names if name.lower().startswith("readme")]
        texts += [read(file) for file in paths if os.path.isfile(file)]
    return "\n".join(texts)


def hint(report, what, otherwise=""):
    """A sentence's end that names the files which bring what is missing.

    Args:
        report: What check_observer.py has written, with what find() has found as "companions".
        what: "world", "robot" or "controllers".
        otherwise: The end where there is no such file.
    """
    files = report.get("companions", {}).get(what, ())
    if not files:
        return otherwise
    named = ", ".join(f"+ {package} {name}" for package, name in files[:LISTED])
    more = f" and {len(files) - LISTED} more" if len(files) > LISTED else ""
    return f"; if another launch file brings it, add it to the command: {named}{more}"
