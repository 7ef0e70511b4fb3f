"""Why Python ended a node, for ./run check: the exception in its output."""

import os
import re

from commands import check_remedies, sources
from commands.subcommands import deps

# Lines of a traceback, then the exception; of a SyntaxError there is no more than the place.
_RAISED = re.compile(
    r'((?:^[ \t]+File "[^"\n]+", line \d+.*\n(?:^[ \t]+(?!File ").*\n)*)+)'
    r"^([A-Za-z_][\w.]*(?::.*)?)$",
    re.MULTILINE,
)
_PLACE = re.compile(r'File "([^"\n]+)", line (\d+)')
_ABSENT = re.compile(r"No module named '([\w.]+)'")
# What Python 3 says of programs for Python 2, and modules that have other names in it.
_PYTHON_2 = re.compile(
    r"Missing parentheses in call to|TabError|leading zeros in decimal|invalid decimal literal"
    r"|multiple exception types must be parenthesized"
    r"|'dict' object has no attribute '(iter|has_key)"
    r"|name '(raw_input|unicode|xrange|long|basestring|unichr|reduce|cmp|execfile|file)' is not"
)
_MODULES_OF_PYTHON_2 = {
    "ConfigParser", "HTMLParser", "Queue", "SocketServer", "StringIO", "Tkinter", "__builtin__",
    "cPickle", "cStringIO", "commands", "httplib", "thread", "tkMessageBox", "urllib2", "urlparse",
}  # fmt: skip


def exception(text):
    """The last exception in a program's output, with the file and line that raised it, or ""."""
    tracebacks = _RAISED.findall(text)
    if not tracebacks:
        return ""
    block, raised = tracebacks[-1]
    path, line = _PLACE.findall(block)[-1]
    return f"{raised.strip()} ({os.path.basename(path)}, line {line})"


def remedy(said, is_package, existing=deps.existing):
    """A sentence's end: what helps against an exception, or "".

    Args:
        is_package: whether a name is that of a ROS package.
        existing: from names of Debian packages to those that exist.
    """
    absent = _ABSENT.search(said)
    module = absent.group(1).partition(".")[0] if absent else ""
    if module in _MODULES_OF_PYTHON_2 or _PYTHON_2.search(said):
        return "; it is written for Python 2, which neither ROS Noetic nor Debian runs"
    if not module:
        return ""
    if is_package(module):
        return f"; package {module} is not built: ./run setup builds what is in src/"
    name = "python3-" + module.lower().replace("_", "-")
    pip = f"if it is on PyPI: ./run exec python -m pip install {module}"
    debian = check_remedies.from_debian(lambda: existing([name]))
    return f"; {debian or sources.adding(module) or pip}"
