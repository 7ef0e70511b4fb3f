"""What roslaunch and the nodes wrote: which nodes died, which could not start, what was refused."""

import os
import re

ERRORS = 50  # lines of errors that are kept
REFUSED_LINES = 2  # lines of roslaunch's own error that are kept
_COLOURS = re.compile(r"\x1b(\[[0-9;]*m|\][^\x07]*\x07)")
_DIED = re.compile(
    r"\[([\w/.-]+?)(?:-\d+)?\] process has died \[pid \d+, exit code (-?\d+), cmd (\S+)"
)
_CANNOT = re.compile(r"cannot launch node of type \[([\w.-]+)/([\w./-]+)\]")
_UNABLE = re.compile(r"Unable to launch \[([\w/.-]+?)(?:-\d+)?\]")
_REFUSED = re.compile(r"RLException: (.*(?:\n\s+\S.*)?)")
_TRACEBACK = "The traceback for the exception was written"
_CAUSE = re.compile(r"^(?:error|xacro|ERROR|Resource not found): .*", re.MULTILINE)


def read(path):
    """Reads the output of a launch.

    Args:
        path: Of the file that holds it.

    Returns:
        died: (node, exit code, name of its program); cannot: (package, type) of nodes that could
        not start; unable: nodes whose program could not be run; errors: lines of errors; refused:
        why roslaunch refuses the file, or None.
    """
    with open(path, encoding="utf-8", errors="replace") as stream:
        text = _COLOURS.sub("", stream.read())
    lines = (line.strip() for line in text.splitlines())
    return {
        "died": [
            (name, int(code), os.path.basename(program))
            for name, code, program in _DIED.findall(text)
            if int(code) != 0
        ],
        "cannot": sorted(set(_CANNOT.findall(text))),
        "unable": sorted(set(_UNABLE.findall(text))),
        "errors": [line for line in lines if re.match(r"\[?(ERROR|FATAL)\b", line)][:ERRORS],
        "refused": _refused(text),
    }


def _refused(text):
    """Why roslaunch gave up: its last words before it mentions the traceback, and their cause."""
    found = _REFUSED.search(text)
    end = found.start() if found else text.find(_TRACEBACK)
    if end < 0:
        return None
    words = [" ".join(found.group(1).split())] if found else []
    causes = [line for line in _CAUSE.findall(text[:end]) if not words or line not in words[0]]
    if not words and not causes:
        lines = [line.strip() for line in text[:end].splitlines() if line.strip()]
        causes = [line for line in lines if not line.startswith("ROS path")][-1:]
    return "; ".join(words + causes[:REFUSED_LINES])
