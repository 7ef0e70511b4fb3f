"""What roslaunch and its nodes have written, for ./run check: what did not start, died, and why."""

import json
import os
import re

from commands import check_python
from commands.windows import needs_screen

ERRORS = 50  # lines of errors that are kept, of the first and of the last
REFUSED_LINES = 2  # lines of roslaunch's own error that are kept
LONGEST = 300  # characters of a node's line
DIED = "died.jsonl"  # in the folder of nodes' output: a line for each death, by check_roslaunch
_COLORS = re.compile(r"\x1b(\[[0-9;]*m|\][^\x07]*\x07)")
_CANNOT = re.compile(r"cannot launch node of type \[([\w.-]+)/([\w./-]+)\]")
_UNABLE = re.compile(r"Unable to launch \[([\w/.-]+?)(?:-\d+)?\]")
_NOT_FOUND = re.compile(r"error while attempting to run:\s+(\S+)")
_REFUSED = re.compile(r"RLException: ((?:while processing .*\n)*.*(?:\n[ \t]+\S.*|(?:\n- .*)+)?)")
_TRACEBACK = "The traceback for the exception was written"
_CAUSE = re.compile(r"^(?:error|xacro|ERROR|Resource not found): .*", re.MULTILINE)
_NO_FILE = re.compile(r"\[Errno 2\] No such file or directory: '([^']+)'")
_LOGGED = re.compile(r"\[?(?:ERROR|FATAL)\]?:? (?:\[[^]]*\]: )?(.*)")  # a line of a node's log
_OF_PACKAGE = re.compile(r"\$\(find ([\w-]+)\)/([\w./+-]+)")
_IMAGE = re.compile(r'failed to open image file "(/[^"]+)"')  # map_server's error
# What programs say that have no display, or no terminal.
_SCREEN = re.compile(
    r"no display name|(?:can't|cannot|could not|unable to|failed to) (?:open|connect to)"
    r"(?: the)?(?: X)? ?(?:display|server)|missing X server|no available video device"
    r"|'\w+' interactive framework|unable to init server|XOpenDisplay"
    r"|Inappropriate ioctl for device",
    re.IGNORECASE,
)


def read(path, folder, is_package):
    """Reads the output of a launch.

    Args:
        path: Of roslaunch's own.
        folder: Of that of its nodes, and of DIED.
        is_package: Whether a name is that of a ROS package.

    Returns:
        died: of each node that has ended with an error its name, package, program, exit code, how
        often, why, whether it wants a screen, and the path of the program; cannot: (package, type)
        of nodes that could not start; unable: nodes whose program could not be run; interpreters:
        (script, missing interpreter); errors: lines of errors; refused: why roslaunch refuses the
        file, or None.
    """
    text = _text(path)
    nodes = {name: _text(os.path.join(folder, name)) for name in sorted(os.listdir(folder))}
    lines = [
        *text.splitlines(),
        *(line for output in nodes.values() for line in output.splitlines()),
    ]
    errors = _errors(lines)
    died = {}
    for line in nodes.pop(DIED, "").splitlines():
        node = json.loads(line)
        node["times"] = died.get(node["name"], {}).get("times", 0) + 1
        died[node["name"]] = node
    for node in died.values():
        said = nodes.get(node.pop("output"), "")
        node["why"] = why(said, is_package)
        node["screen"] = needs_screen(node["program"]) or bool(_SCREEN.search(said[-2000:]))
    return {
        "died": list(died.values()),
        "cannot": sorted(set(_CANNOT.findall(text))),
        "unable": sorted(set(_UNABLE.findall(text))),
        "interpreters": missing_interpreters(_NOT_FOUND.findall(text)),
        "errors": errors[:ERRORS] + errors[ERRORS:][-ERRORS:],
        "refused": _refused(text),
    }


def append_nodes(path, folder):
    """Appends what nodes have written to what roslaunch has."""
    with open(path, "a", encoding="utf-8") as stream:
        for name in sorted(os.listdir(folder)):
            if name != DIED:
                stream.write(f"\n==== {name}\n{_text(os.path.join(folder, name))}")


def _text(path):
    with open(path, encoding="utf-8", errors="replace") as stream:
        return _COLORS.sub("", stream.read())


def _errors(lines):
    """Lines of errors, without what gazebo_ros_control logs of joints that need no gains, and what
    roslaunch logs of other nodes."""
    lines = [line.strip() for line in lines if "No p gain specified for pid." not in line]
    lines = [line for line in lines if not _CANNOT.search(line)]
    return [line for line in lines if re.match(r"\[?(ERROR|FATAL)\b", line)]


def why(said, is_package):
    """What a node has said of its end: the exception, else its last error, else its last line."""
    raised = check_python.exception(said)
    if raised:
        return raised + check_python.remedy(raised, is_package)
    lines = [line.strip() for line in said.splitlines() if line.strip()]
    for line in _errors(lines)[-1:]:
        logged = _LOGGED.fullmatch(line)
        text = logged.group(1) if logged else line
        return text + _elsewhere(text)
    return lines[-1][:LONGEST] if lines else ""


def _elsewhere(text):
    """What helps where map_server's error names an image in a folder of its author's machine."""
    image = _IMAGE.search(text)
    if not image or os.path.isdir(os.path.dirname(image.group(1))):
        return ""
    return (
        f"; there is no such folder here: with 'image: {os.path.basename(image.group(1))}' in the "
        "map's YAML file it is looked for beside that file"
    )


def missing_interpreters(paths):
    """(path, interpreter) of scripts whose first line names a program that does not exist."""
    missing = {}
    for path in paths:
        try:
            with open(path, "rb") as script:
                first = script.readline(256).decode(errors="replace").strip()
        except OSError:
            continue
        words = first[2:].split() if first.startswith("#!") else []
        if words and not os.path.exists(words[0]):
            missing[path] = words[0]
    return sorted(missing.items())


def _refused(text):
    """Why roslaunch gave up: its last words before it mentions the traceback, and their cause."""
    refusal = _REFUSED.search(text)
    end = refusal.start() if refusal else text.find(_TRACEBACK)
    if end < 0:
        return None
    missing = _NO_FILE.search(text)
    if missing:  # roslaunch says it of the file, of who includes it and of the parser
        return f"there is no file {missing.group(1)}"
    words = [_shortened(refusal.group(1))] if refusal else []
    causes = [line for line in _CAUSE.findall(text[:end]) if not words or line not in words[0]]
    if not words and not causes:
        lines = [line.strip() for line in text[:end].splitlines() if line.strip()]
        causes = [line for line in lines if not line.startswith("ROS path")][-1:]
    return "; ".join(dict.fromkeys(words + causes[:REFUSED_LINES]))


def _shortened(said):
    """An error without the files that include the one that it is about."""
    files = re.findall(r"while processing (.*):\n", said)
    cause = " ".join(said.rpartition("while processing")[2].partition(":\n")[2].split())
    return f"{cause} (in {files[-1]})" if files and cause else " ".join(said.split())


def moved(texts, packages):
    """Looks for files of another machine or of a package that is not there in packages of this one.

    Args:
        packages: Name -> folder.

    Returns:
        Dict from a path that does not exist to $(find PACKAGE)/...: below a folder that is named as
        a package; of a package that is not there, where one package alone has that file.
    """
    places = {}
    for text in texts:
        for name, rest in _OF_PACKAGE.findall(text):
            folders = packages.items() if name not in packages else ()
            there = [each for each, folder in folders if os.path.exists(f"{folder}/{rest}")]
            if len(there) == 1:
                places[f"$(find {name})/{rest}"] = f"$(find {there[0]})/{rest}"
    for path in dict.fromkeys(
        p for text in texts for p in re.findall(r"(?<![\w)])/[\w./+-]+", text)
    ):
        path = path.rstrip(".:")
        parts = path.split("/")[1:]
        if len(parts) < 3 or os.path.exists(path):
            continue
        for number, part in enumerate(parts[:-1]):
            rest = "/".join(parts[number + 1 :])
            if part in packages and os.path.exists(os.path.join(packages[part], rest)):
                places[path] = f"$(find {part})/{rest}"
                break
    return places
