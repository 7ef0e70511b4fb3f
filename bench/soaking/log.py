"""What the log of a session may not have in it."""

import re

CONTEXT = 40  # most lines of a traceback that are told
_COLOURS = re.compile(r"\x1b(\[[0-9;]*m|\][^\x07]*\x07)")
_MARKS = ("Traceback (most recent call last)", "Segmentation fault", "core dumped", "MemoryError")
# Of roslaunch, of rospy while a master is gone, and of the master's own log on a full disk.
_THEIRS = ("roslaunch", "rosmaster", "xmlrpc/client.py", "rosgraph/xmlrpc.py", "logging/")


def problems(text, known=_THEIRS):
    """Tracebacks and crashes in a log.

    Args:
        text: The log.
        known: Words of tracebacks that are not ours.

    Returns:
        Excerpts, each once.
    """
    lines, found = _COLOURS.sub("", text).splitlines(), {}
    for number, line in enumerate(lines):
        if any(mark in line for mark in _MARKS):
            excerpt = "\n".join(_excerpt(lines[number : number + CONTEXT]))
            if not any(word in excerpt for word in known):
                found.setdefault(excerpt, None)
    return list(found)


def _excerpt(lines):
    """A traceback: its first line, the indented ones, and the error."""
    end = 1
    while end < len(lines) and lines[end].startswith(" "):
        end += 1
    return lines[: end + 1] if end > 1 else lines[:1]
