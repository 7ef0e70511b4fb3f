"""What could not be built: which package and program, by what cause, and what helps.

Read from the logs of cmake and of make -k, which builds all that does not need it.
"""

import glob
import os
import re
from dataclasses import asdict, dataclass

from commands import sources
from commands.paths import BUILD, SOURCES, VENV_PYTHON, read, read_xml, write

FILE = os.path.join(BUILD, ".left_out")
# Run by a Python that has catkin_pkg, with folders: what is refused, and why, a line each.
PARSE = """
import sys
from catkin_pkg.package import parse_package
for folder in sys.argv[1:]:
    try:
        parse_package(folder, [])
    except Exception as error:
        print(folder, " ".join(str(error).split()) or type(error).__name__, sep="\\t")
"""
GAZEBO = "./run add gazebo brings its libraries (docs/cpp_plugins.md)"
OF_PADDOCK = "none is needed: Paddock's own plugin of that name is used"
OWN = "a Python class can take its place (docs/tutorials/your_own_simulation.md)"
SIMULATOR_HEADERS = ("gazebo", "ignition", "gz", "sdf")
CONTROL_HEADERS = (
    "combined_robot_hw",
    "controller_interface",
    "controller_manager",
    "effort_controllers",
    "gazebo_ros",
    "gazebo_ros_control",
    "gazebo_plugins",
    "hardware_interface",
    "joint_limits_interface",
    "joint_trajectory_controller",
    "position_controllers",
    "transmission_interface",
    "velocity_controllers",
)
_ESCAPES = re.compile(r"\x1b\[[0-9;]*m")
_PROCESSING = re.compile(r"-- (?:\+\+\+ processing catkin package: '(\S+)'|~~  - (\S+))")
_NO_CONFIG = re.compile(r"Could not find a package configuration file provided by\s+\"([^\"]+)\"")
_NO_MODULE = re.compile(r"Could NOT find (\w+)")
_NO_PKG_CONFIG = re.compile(r"No package '([^']+)' found")
_NO_HEADER = re.compile(r"fatal error: ([^\s:]+): No such file or directory")
_COMPILER = re.compile(r"^(/\S+?):(\d+):(?:\d+:)? (?:fatal )?error: (.*)$")
_LINKER = re.compile(r"(undefined reference to .*|cannot find -l\S+.*)$")
_FAILED = re.compile(r"\*\*\* \[(.+)\] Error \d+")
_TARGET = re.compile(r"^(?:\./)?(.+)/CMakeFiles/([^/]+)\.dir/")
# Names of libraries that a decorator of Paddock's plugins enters: @model_plugin("a", "b", rule=...
_LIBRARIES = re.compile(r'^@\w+_plugin\(\s*((?:"[\w.]+"[,\s]*)+)', re.MULTILINE)
NO_ERROR = "the log has no error of it"
_DEPEND = re.compile(r"<(\w*depend)\b[^>]*>\s*([\w-]+)\s*</")
_reported = set()  # by this process


@dataclass(frozen=True)
class LeftOut:
    """A package or a program that is not built.

    Attributes:
        package: The package's name.
        program: Its target; empty: the whole package.
        cause: Why.
        remedy: What helps; may be empty.
        missing: Name of the package that is missing; may be empty.
    """

    package: str
    program: str
    cause: str
    remedy: str = ""
    missing: str = ""

    def line(self):
        """Returns what is printed."""
        what = f"{self.package} ({self.program})" if self.program else self.package
        return f"left out: {what}: {self.cause}{self.remedy and f'; {self.remedy}'}"


def saved():
    """Lists what the last build left out."""
    text = read(FILE)
    if not text:
        return []
    import json

    return [LeftOut(**fields) for fields in json.loads(text)]


def save(entries):
    """Keeps what a build left out."""
    import json

    write(FILE, json.dumps([asdict(entry) for entry in entries]))


def lines(entries):
    """Lists what is printed of entries: a command that builds and then tells says each once."""
    new = [entry for entry in entries if entry not in _reported]
    _reported.update(new)
    return [entry.line() for entry in new]


def refused(folders, environ=None):
    """Finds the packages whose package.xml catkin refuses, which would end every build.

    Args:
        folders: Of packages.
        environ: Of the ROS whose catkin it is; None: the caller's.

    Returns:
        Dict from a folder to catkin's reason.
    """
    if not folders:
        return {}
    import subprocess

    command = [VENV_PYTHON, "-c", PARSE, *folders]
    done = subprocess.run(
        command, env=environ, capture_output=True, text=True, errors="replace", check=False
    )
    return dict(line.split("\t", 1) for line in done.stdout.splitlines())


def before_configuration(users, is_there):
    """Finds packages that cmake would refuse: what they ask for as components of catkin is missing.

    Args:
        users: Packages of a user: of each name its folder.
        is_there: From the name of a package to whether the ROS, or Paddock, has it.

    Returns:
        List of LeftOut; packages that need another one of it follow it.
    """
    wanted = {name: components_of(folder) for name, folder in users.items()}
    result = {}
    while True:
        more = {}
        for name in users.keys() - result.keys():
            for component in wanted[name]:
                if component in result:
                    more[name] = LeftOut(name, "", f"it needs {component}, which is left out")
                elif component not in users and not is_there(component):
                    more[name] = LeftOut(name, "", *_missing(component, f"it needs {component}"))
        if not more:
            return list(result.values())
        result.update(sorted(more.items()))


def components_of(folder):
    """Lists the components of catkin that the CMakeLists.txt of a package requires in any case."""
    text = re.sub(r"#.*", "", read(os.path.join(folder, "CMakeLists.txt")))
    result, depth = [], 0
    for call in re.finditer(r"\b(if|endif|find_package)\s*\(([^()]*)\)", text, re.I):
        kind, words = call[1].lower(), call[2].split()
        depth += {"if": 1, "endif": -1}.get(kind, 0)
        if kind == "find_package" and depth == 0 and words[:1] == ["catkin"]:
            rest = words[words.index("REQUIRED") + 1 :] if "REQUIRED" in words else []
            result += [word for word in rest if re.fullmatch(r"[a-z][a-z0-9_-]*", word)]
    return result


def asked_for(folder, tags=None):
    """Returns what the package.xml of a package asks for.

    Args:
        tags: By which elements; None: by any.
    """
    text = read_xml(os.path.join(folder, "package.xml"))
    return {name for tag, name in _DEPEND.findall(text) if tags is None or tag in tags}


def of_configuration(log):
    """Finds the packages that cmake could not configure.

    Args:
        log: What cmake printed.

    Returns:
        List of LeftOut, one a package; empty: none is to blame.
    """
    package, result = "", {}
    lines = _ESCAPES.sub("", log).splitlines()
    for at, line in enumerate(lines):
        named = _PROCESSING.match(line)
        if named and named[1]:
            package = named[1]
        if line.startswith("CMake Error") and package and package not in result:
            result[package] = _configuration(package, lines[at : at + 25])
    return list(result.values())


def _configuration(package, lines):
    end = next((n for n, line in enumerate(lines) if n and re.match(r"-- |CMake", line)), 25)
    text = " ".join(" ".join(lines[:end]).split())
    for pattern in (_NO_CONFIG, _NO_PKG_CONFIG, _NO_MODULE):
        match = pattern.search(text)
        if match:
            return LeftOut(package, "", *_missing(match[1], f"it needs {match[1]}"))
    words = re.sub(r"^CMake Error(?: at \S+:\d+)?[^:]*:(?:\d+ \(\w+\):)?\s*", "", text)
    return LeftOut(package, "", f"cmake: {words.partition(' Call Stack')[0][:200].strip()}")


def _missing(name, cause):
    generic = "./run deps names the Debian package that has it, ./run add --list sources"
    return cause, sources.adding(name) or generic, name


def of_plain_cmake(name, log):
    """Tells why a package of plain CMake could not be built.

    Args:
        log: What cmake and make printed.

    Returns:
        LeftOut.
    """
    lines = _lines_of(log)
    for at, line in enumerate(lines):
        if line.startswith("CMake Error"):
            return _configuration(name, lines[at : at + 25])
        if error := _error_in(line):
            return _entry(name, "", error[1])
    return _entry(name, "", NO_ERROR)


def _lines_of(log):
    """Returns what programs printed, without colors and with plain quotes."""
    return _ESCAPES.sub("", log).replace("‘", "'").replace("’", "'").splitlines()


def _error_in(line):
    """Returns the file, or "", and the error that a compiler or linker tells in a line; or None."""
    compiler, linker = _COMPILER.match(line), _LINKER.search(line)
    if compiler:
        path, number, text = compiler.groups()
        return path, f"{os.path.basename(path)}:{number}: {text}"
    return linker and ("", linker[1])


def of_build(log, packages):
    """Finds the programs that make could not build.

    Args:
        log: What make -k -O printed: what each compiler says is in one piece, before make's line.
        packages: Folders in the workspace, relative to src/, of all packages: folder -> name.

    Returns:
        List of LeftOut, one a target; package is empty where it is not known.
    """
    result, errors = {}, []
    for line in _lines_of(log):
        if error := _error_in(line):
            errors.append(error)
        elif _FAILED.search(line):
            failed = _FAILED.search(line)[1]
            match = _TARGET.match(failed.split(": ")[-1])
            if not match:  # a whole target, of which a file has failed before
                continue
            package, target = _package_at(match[1], packages), match[2]
            if (package, target) not in result:
                result[package, target] = _entry(package, target, _error_of(failed, errors))
            errors = []
    return list(result.values())


def _package_at(folder, packages):
    while folder and folder not in packages:
        folder = os.path.dirname(folder)
    return packages.get(folder, "")


def _error_of(failed, errors):
    """Returns the error that belongs to what make names: PACKAGE/CMakeFiles/TARGET.dir/FILE.o."""
    source = failed.partition(".dir/")[2].partition(".dir/")[2] or failed.partition(".dir/")[2]
    source = re.sub(r"\.o$", "", source)
    for path, error in errors:
        if source and path.endswith(f"/{source}"):
            return error
    return errors[0][1] if errors else NO_ERROR


def _entry(package, target, error):
    header = _NO_HEADER.search(f"fatal error: {error.partition(': ')[2]}")
    if header:
        first = header[1].partition("/")[0]
        owner = owner_of(first)
        if owner:
            remedy = OF_PADDOCK if _is_own(target) else GAZEBO if owner == "Gazebo" else OWN
            return LeftOut(package, target, f"it includes {owner}'s {header[1]}", remedy)
        return LeftOut(package, target, *_missing(first, f"it includes {header[1]}"))
    return LeftOut(package, target, error[:200], "see .cache/log/build_workspace.log")


def _is_own(library):
    """Whether Paddock has a plugin of that library in Python."""
    files = glob.glob(os.path.join(SOURCES, "bullet_sim/src/bullet_sim/plugins/*.py"))
    return any(
        f'"{library}"' in names for path in files for names in _LIBRARIES.findall(read(path))
    )


def owner_of(header):
    """Returns whose headers are below a folder, of those that do not exist here; or ""."""
    if header in SIMULATOR_HEADERS:
        return "Gazebo"
    return "ros_control" if header in CONTROL_HEADERS else ""
