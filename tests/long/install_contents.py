"""What the sources ask of the install space: files, executables, modules and references."""

import os
import re
import xml.etree.ElementTree as ElementTree

from install_tree import ROOT, cache_entry

# What is no data of a package: its sources become modules and executables.
NO_DATA = {"CMakeLists.txt", "CATKIN_IGNORE", "README.md", "pyproject.toml", "setup.py"}
NO_DATA_FOLDERS = {
    "__pycache__",
    ".pytest_cache",
    "docs",
    "env-hooks",  # these two have places of their own: see test_install_space.py
    "include",
    "nodes",
    "packaging",
    "scripts",
    "src",
    "test",
}
XML = {".launch", ".sdf", ".urdf", ".world", ".xacro", ".xml"}
TEXT = {".config", ".rviz", ".yaml"}
FIND = re.compile(r"\$\(find ([\w-]+)\)([^\s'\"<>:;,]*)")
URI = re.compile(r"package://([\w-]+)([^\s'\"<>:;,]*)")
SUBSTITUTION = re.compile(r"\$\([^)]*\)|\$\{[^}]*\}")


def packages():
    """Gives name -> source folder of every package that is built, stand-ins included."""
    left_out = cache_entry("CATKIN_BLACKLIST_PACKAGES").split(";")
    found = {}
    for path in sorted((ROOT / "src").glob("**/package.xml")):
        name = ElementTree.parse(path).findtext("name")
        if name not in left_out:
            found[name] = path.parent
    return found


def data_files(folder):
    """Gives the paths below a package's share folder that its sources ask for."""
    for path in sorted(folder.rglob("*")):
        below = path.relative_to(folder)
        if path.is_file() and below.parts[0] not in NO_DATA | NO_DATA_FOLDERS:
            yield below.with_suffix("") if below.suffix == ".in" else below


def executables(folder):
    """Gives the names of a package's nodes and scripts."""
    for place in ("nodes", "scripts"):
        yield from sorted(path.name for path in (folder / place).glob("*") if path.is_file())


def modules(folder):
    """Gives the paths of the Python modules below a folder, without generated messages."""
    return {
        path.relative_to(folder)
        for path in folder.rglob("*.py")
        if path.relative_to(folder).parts[1:2] not in (("msg",), ("srv",))
    }


def references(path):
    """Gives what a file names by $(find PACKAGE)/FILE or package://PACKAGE/FILE.

    Comments of XML count for nothing.

    Returns:
        Set of (package, path below its share folder), with * for what is substituted.
    """
    if path.suffix in XML:
        elements = list(ElementTree.parse(path).iter())
        texts = [
            value for element in elements for value in (element.text, *element.attrib.values())
        ]
    else:
        texts = [path.read_text(encoding="utf-8")] if path.suffix in TEXT else []
    return {reference for text in texts for reference in references_in(text or "")}


def references_in(text):
    """As references, of a text."""
    for pattern in (FIND, URI):
        for package, rest in pattern.findall(SUBSTITUTION.sub(substitute, text)):
            yield package, rest.lstrip("/")


def substitute(match):
    """Gives what stands for a substitution: $(find) stays, anything may come from the others."""
    return match.group() if match.group().startswith("$(find ") else "*"


def found(prefix, package, below):
    """Gives what roslaunch would find for a reference: executables first, then files.

    Args:
        prefix: Of the install space.
        below: Path below the package's share folder; * stands for anything.
    """
    share = prefix / "share" / package
    if not below:
        return [share] if share.is_dir() else []
    return executables_found(prefix, package, below.rpartition("/")[2]) or list(share.glob(below))


def executables_found(prefix, package, name):
    """Gives what rosrun would find for a name; * stands for anything."""
    paths = (prefix / "lib" / package).glob(name)
    return [path for path in paths if path.is_file() and os.access(path, os.X_OK)]


def nodes_of(path):
    """Gives (package, type) of the nodes of a launch file, with * for what is substituted."""
    return {
        (node.get("pkg"), SUBSTITUTION.sub("*", node.get("type")))
        for node in ElementTree.parse(path).iter("node")
    }


def dependencies(manifest):
    """Gives the catkin packages that a package.xml needs at run time or for building on it."""
    tags = ("depend", "exec_depend", "build_export_depend", "buildtool_export_depend")
    names = {element.text for tag in tags for element in ElementTree.parse(manifest).iter(tag)}
    return {name for name in names if not name.startswith(("python3-", "libjs-"))}
