"""What makes a build of the workspace necessary, and the stand-ins that give way."""

import os

from commands.paths import ROOT, SOURCES

STANDINS = os.path.join(SOURCES, "standins")
NAMES = ("CMakeLists.txt", "package.xml", "setup.py", "CATKIN_IGNORE")
SUFFIXES = (".msg", ".srv", ".action", ".cfg", ".cmake", ".in", ".cpp", ".h")
LISTED = ("nodes", "scripts")  # folders whose files are linked or wrapped by the build
GENERATED = os.path.join(SOURCES, "CMakeLists.txt")  # by catkin_make


def installed_elsewhere():
    """Lists stand-ins whose real package is installed; they are left out of the build."""
    shares = ["/usr/share"]
    if os.path.isdir("/opt/ros"):
        shares += [f"/opt/ros/{name}/share" for name in sorted(os.listdir("/opt/ros"))]
    names = sorted(os.listdir(STANDINS)) if os.path.isdir(STANDINS) else []
    return [
        name
        for name in names
        if any(os.path.exists(f"{share}/{name}/package.xml") for share in shares)
    ]


def scan():
    """Walks the sources.

    Returns:
        directories: Every directory, as nothing can come or go without changing one of them.
        contents: Files whose content counts.
        names: Files whose presence counts.
    """
    directories, contents, names = [], [], []
    for directory, subdirectories, files in os.walk(SOURCES):
        subdirectories[:] = sorted(name for name in subdirectories if name != "__pycache__")
        directories.append(directory)
        listed = any(name in LISTED for name in os.path.relpath(directory, ROOT).split(os.sep))
        for name in sorted(files):
            path = os.path.join(directory, name)
            built_from = name in NAMES or name.endswith(SUFFIXES)
            installed = (listed or name == "__init__.py") and not name.endswith(".pyc")
            if not (built_from or installed) or os.path.islink(path) or path == GENERATED:
                continue
            if built_from:
                contents.append(path)
            if installed:
                names.append(path)
    return directories, contents, names


def build_key(contents, names):
    """Gives one text for everything that a build depends on.

    Args:
        contents: Files whose content counts.
        names: Files whose presence counts.
    """
    import hashlib

    whole = hashlib.sha256("\n".join([ROOT, *installed_elsewhere(), *names]).encode())
    for path in contents:
        with open(path, "rb") as stream:
            content = hashlib.sha256(stream.read()).hexdigest()
        whole.update(f"\n{content} {path}".encode())
    return whole.hexdigest()


def packages(contents):
    """Lists the workspace's packages: the folders of package.xml, relative to the clone."""
    return sorted(
        os.path.relpath(os.path.dirname(path), ROOT)
        for path in contents
        if os.path.basename(path) == "package.xml"
    )
