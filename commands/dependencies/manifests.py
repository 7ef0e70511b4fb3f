"""package.xml files: their names and what they depend on (REP 127, 140, 149)."""

import os

from commands.errors import UsageError

KINDS = (
    "depend",
    "build_depend",
    "build_export_depend",
    "buildtool_depend",
    "buildtool_export_depend",
    "exec_depend",
    "run_depend",
    "test_depend",
)
RUN_ONLY = ("exec_depend", "run_depend", "test_depend")
SKIPPED = ("build", "devel", "install")  # by catkin
IGNORE = ("CATKIN_IGNORE", "AMENT_IGNORE")


def find(folder):
    """Lists the package.xml files at and below a folder, as catkin finds them.

    Raises:
        UsageError: There are none.
    """
    found = []
    for directory, below, files in os.walk(folder):
        if any(name in files for name in IGNORE):
            below[:] = []
        elif "package.xml" in files:
            found.append(os.path.join(directory, "package.xml"))
            below[:] = []
        else:
            below[:] = sorted(n for n in below if not n.startswith(".") and n not in SKIPPED)
    if not found:
        raise UsageError(f"there is no package.xml at or below {folder!r}")
    return found


def read(path):
    """Reads a package.xml.

    Returns:
        (name, dict from a dependency to the tags that ask for it, in the file's order).

    Raises:
        UsageError: It is no package.xml.
    """
    from xml.etree import ElementTree

    try:
        root = ElementTree.parse(path).getroot()
    except ElementTree.ParseError as error:
        raise UsageError(f"{path} is not XML: {error}") from None
    name = (root.findtext("name") or "").strip()
    if root.tag != "package" or not name:
        raise UsageError(f"{path} is no package.xml: it has no <package> with a <name>")
    wanted = {}
    for element in root:
        text = (element.text or "").strip()
        if element.tag in KINDS and text and _for_ros_1(element.get("condition", "")):
            wanted.setdefault(text, []).append(element.tag)
    return name, wanted


def _for_ros_1(condition):
    """Whether a condition of format 3 lets a dependency stand, as far as ROS_VERSION goes."""
    words = condition.replace("'", "").replace('"', "").split()
    if len(words) != 3 or words[0] != "$ROS_VERSION" or words[1] not in ("==", "!="):
        return True
    return (words[2] == "1") == (words[1] == "==")
