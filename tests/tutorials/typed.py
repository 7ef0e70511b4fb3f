"""Whether what a command line names exists: commands, options, launch arguments, nodes, files.

`check()` takes any line of a page, also one with the reader's own names (capitals), with choices
(`a|b`) or with what may be left out (`[...]`), and raises where a word of ours is not there.
"""

import importlib
import itertools
import re
import shlex
from pathlib import Path

from selection import name_of

from commands import parsing, sources
from commands.cli import subcommand
from commands.errors import UsageError
from commands.launching import LaunchFile, track_names
from commands.table import COMMANDS, DEFAULT

ROOT = Path(__file__).resolve().parents[2]
RUN = ("./run", "PADDOCK/run", "/opt/paddock/run")
INNER = ("desk", "container", "bare")  # a command of ./run stands behind their options
PACKAGES = {path.parent.name: path.parent for path in (ROOT / "src").rglob("package.xml")}
PACKAGES.update(
    (path.parent.name, path.parent) for path in ROOT.glob("tests/drop_in/*/package.xml")
)
FOREIGN = re.compile(r"husky|turtlebot3|map_server|my_car|my_lab")  # packages that the reader has
ROS = {  # tool -> what may stand behind it
    "rostopic": ("list", "echo", "pub", "hz", "info"),
    "rosservice": ("list", "call"),
    "rosparam": ("list", "set", "get", "load"),
    "rosbag": ("record", "info", "play"),
}
TOOLS = {  # of others
    *("roslaunch", "rosrun", "roscore", "python", "python3", "bash", "ruff", "catkin_make", "true"),
    *("git", "podman", "docker", "buildah", "apt", "apt-get", "sudo", "source", ".", "cd", "rm"),
    *("mkdir", "touch", "ssh", "sed", "pip", "make", "cat", "ls", "cp", "rviz", "CMD..."),
}
MODULES = ("pytest",)  # behind python -m
STAGES = ("unit", "lint", "ros", "soak", "learning", "desk", "web", "tutorials", "long")
_texts = []


def check(line):
    """Checks a line and the commands in it.

    Raises:
        AssertionError: A word is not there; it says which.
    """
    text = re.sub(r"\s+#.*", "", line)
    if text.startswith("sudo refused, "):  # an error's text
        return
    for part in re.split(r" && |; ", text) if "'" not in text and '"' not in text else [text]:
        if '"' not in part:
            part = re.sub(r"[\[\]]", " ", part)
        try:
            words = shlex.split(part)
        except ValueError:  # a quotation that was parted
            words = part.split()
        _check(words[: words.index("||")] if "||" in words else words)


def _check(words):
    while words and re.match(r"[A-Z_]+=|sudo$|-E$|timeout$|\d+$|export$", words[0]):
        words = words[1:]
    if words and words[0] in RUN:
        _check_run(words[1:])
    elif words and "=" not in words[0]:
        _check_tool(words)


def _check_run(words):
    if not words or words[0] in ("--help", "..."):
        return
    if ":=" in words[0]:
        return _check_arguments(words, [subcommand(DEFAULT).LAUNCH])
    name, *rest = words
    if _is_own(name):
        return None
    assert name in COMMANDS, f"./run has no command {name!r}"
    module = subcommand(name)
    if name == "exec":
        return _check_tool(rest) if rest else None
    options = parsing.parser_of(name, module)
    flags = {flag: action for action in options._actions for flag in action.option_strings}
    if name in INNER:
        while rest and rest[0].startswith("--"):
            assert rest[0] in flags, f"./run {name} has no option {rest[0]}"
            rest = rest[1 if flags[rest[0]].nargs == 0 else 2 :]
        return _check_run(rest)
    passes_on = getattr(module, "PASSES_ON", False) and name == "test"
    for at, word in enumerate(rest):
        if word.startswith("--") and word != "--" and not passes_on:
            action = flags.get(word.partition("=")[0])
            assert action, f"./run {name} has no option {word}"
            value = rest[at + 1] if at + 1 < len(rest) else ""
            if action.type and "|" in value and not _is_own(value):
                for each in value.split("|"):
                    action.type(each)
    if rest and not any(map(_is_own, rest)) and not passes_on and "|" not in "".join(rest):
        _parse(options, rest)
    _check_words(name, rest)
    launches = [getattr(module, each, None) for each in ("LAUNCH", "BESIDE", "BACK")]
    given = [word for word in rest if re.match(r"\w+:=", word)]
    assert not given or hasattr(module, "LAUNCH"), f"./run {name} has no launch arguments"
    if name != "check":
        _check_arguments(given, [each for each in launches if each])
    return None


def _parse(options, rest):
    try:
        options.parse_known_args(rest)
    except UsageError as error:  # a file that the reader makes
        if not re.search(r"there is no file|the path of an? ", str(error)):
            raise
    if "--track" in rest:
        for word in itertools.takewhile(
            lambda word: not word.startswith("-"), rest[rest.index("--track") + 1 :]
        ):
            assert word in track_names() or "." in word, f"there is no track {word!r}"


def _check_words(name, rest):
    """What some commands take as words."""
    plain = [word for word in rest if re.fullmatch(r"[a-z][\w/]*", word)]
    if name == "test":
        files = [f"{path.relative_to(ROOT)} {name_of(path, ROOT)}" for path in _tests()]
        for word in plain:
            assert word in (*STAGES, "project", "physics") or any(word in p for p in files), (
                f"no test {word!r}"
            )
    elif name == "add":
        for word in plain if plain[:1] != ["models"] else ():
            assert word in (*sources.names(), "gazebo"), f"./run add knows no {word}"
    elif name == "bench":
        for word in plain:
            assert (ROOT / "bench" / "sections" / f"{word}.py").is_file(), f"no section {word!r}"
    elif name == "cluster":
        assert set(plain) <= {"head", "join"}, rest
    elif name == "check":
        assert all(".launch" not in word or word.endswith(".launch") for word in rest), rest
    elif name == "setup" and "--with" in rest:
        for word in rest[rest.index("--with") + 1].split(","):
            lists = [f"apt-{word}.txt", f"requirements-{word}.txt"]
            assert any((ROOT / "config" / each).is_file() for each in lists), f"no list {word}"


def _tests():
    return [*ROOT.glob("tests/**/test_*.py"), *ROOT.glob("src/*/test/*.py"), ROOT / "src/standins"]


def _check_arguments(words, launches):
    for word in (each for each in words if ":=" in each):
        name = word.partition(":=")[0]
        launch = next((each for each in launches if name in each.arguments()), None)
        assert launch or _is_own(name), f"no launch argument {name!r}"
        if launch and not _is_own(word) and "|" not in word and name != "track":
            launch.check([word])


def _check_tool(words):
    tool, *rest = words
    assert tool in TOOLS or tool in ROS or _is_own(tool), f"there is no program {tool!r}"
    if tool == "roslaunch" and rest:
        _check_roslaunch(*rest)
    elif tool == "rosrun" and rest:
        package, node = rest[:2]
        if _is_ours(package):
            found = [PACKAGES[package] / folder / node for folder in ("nodes", "scripts", ".")]
            assert any(path.is_file() for path in found), f"{package} has no node {node!r}"
    elif tool in ROS and rest:
        assert rest[0] in ROS[tool], f"{tool} has no {rest[0]!r}"
        for name in rest[1:]:
            if re.fullmatch(r"(/\w+)+", name):
                assert _is_in_sources(name.rsplit("/", 1)[1]), f"nothing is called {name}"
            elif re.fullmatch(r"\w+_msgs/\w+", name):
                package, kind = name.split("/")
                messages = importlib.import_module(f"{package}.msg")
                assert hasattr(messages, kind), f"there is no message {name}"
    elif tool in ("python", "python3"):
        if rest[:1] == ["-m"]:
            assert rest[1] in MODULES, f"there is no module {rest[1]}"
        files = [word for word in rest if re.match(r"[a-z]+/", word)] or rest[:1]
        for word in files:
            known = (
                (ROOT / word).exists() or word[0] in ".-" or _is_own(word) or word == "example.py"
            )
            assert known, f"there is no file {word}"


def _check_roslaunch(package, file="", *words):
    if package == "...":
        return
    assert file.endswith(".launch"), f"{file!r} is no launch file"
    if not _is_ours(package) or _is_own(file):
        return
    launch = LaunchFile(package, file)
    launch.path = str(PACKAGES[package] / "launch" / file)
    assert Path(launch.path).is_file(), f"{package} has no {file}"
    _check_arguments(words, [launch])


def _is_own(word):
    """Whether a word is the reader's: in capitals, a value, a path."""
    return word == word.upper() or bool(re.search(r"[A-Z]{2}|\.\.\.|[$~<]", word))


def _is_ours(package):
    if FOREIGN.search(package) or _is_own(package) or package == "...":
        return False
    assert package in PACKAGES, f"there is no package {package!r}"
    return True


def _is_in_sources(name):
    if not _texts:
        suffixes = (".py", ".yaml", ".launch", ".xacro", ".js", ".srv")
        paths = [path for path in (ROOT / "src").rglob("*") if path.suffix in suffixes]
        paths += [path for path in (ROOT / "docs" / "tutorials").glob("*.md")]
        _texts.append("\n".join(path.read_text() for path in paths))
    return re.search(rf"\b{re.escape(name)}\b", _texts[0]) is not None
