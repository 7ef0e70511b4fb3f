"""Names what the packages at and below PATH ask for, and which Debian package has it.

They ask by package.xml, by components of catkin in CMakeLists.txt, and by their launch files.
The names are rosdep's: Debian's list of ROS packages, those of config/rosdep/, and what
`rosdep update` has brought, if it was run. Packages of the folder itself, of Paddock (with its
stand-ins for what Debian lacks) and of a ROS that is sourced count as there. --names prints only
the Debian packages to install, for scripts.
Exits 0 if everything is there or in Debian, 1 if something is nowhere.
"""

import functools
import glob
import os
import re
import subprocess
from dataclasses import dataclass, field

from commands import sources
from commands.bootstrap import left_out, old_code, packages, ros, workspace
from commands.bootstrap.lists import available as existing
from commands.bootstrap.lists import installed
from commands.bootstrap.workspace import (
    given_way,
    manifests_below,
    manifests_of,
    users_packages,
)
from commands.errors import CommandError, UsageError, say
from commands.paths import CACHE, PYTHON, ROOT, SOURCES, os_release, read, read_xml, write

USAGE = "[--names] [PATH]"
OTHER_TAGS = ("doc_depend", "group_depend")  # that end with depend, too
OUR_LIST = os.path.join(ROOT, "config", "rosdep", "paddock.yaml")
ROSDEPS_LIST = os.path.join(ROOT, "config", "rosdep", "rosdep.yaml")  # of ./run add --refresh
LOOKUP = os.path.join(ROOT, "commands", "rosdep_lookup.py")
CONDITION = os.path.join(ROOT, "commands", "manifest_condition.py")
ROSDEP, VCS = "/usr/bin/rosdep", "/usr/bin/vcs"
WANTED = os.path.join(CACHE, "apt-users.txt")  # what packages in src/ need of Debian
WIDTH = 96
# Stand-ins without C++ of packages that Debian has: C++ that includes their headers needs Debian's.
PYTHON_ONLY = ("cv_bridge",)
VARIABLES = ("ROS_VERSION=1", "ROS_PYTHON_VERSION=3", "ROS_DISTRO=noetic")  # of conditions
_IN_LAUNCH_FILE = re.compile(r"\bpkg\s*=\s*[\"']([\w-]+)[\"']|\$\(find ([\w-]+)\)")


def add_arguments(parser):
    """Declares path and --names."""
    parser.add_argument(
        "path", nargs="?", default=".", metavar="PATH", help="a package or a workspace (.)"
    )
    parser.add_argument(
        "--names", action="store_true", help="only the names of Debian packages to install"
    )


def run(options, _rest):
    """Prints the answer.

    Raises:
        CommandError: apt has no lists, so it would know nothing.
    """
    if not os.path.isdir(options.path):
        raise UsageError(f"path is {options.path!r}; it must be a folder")
    if not has_lists():
        raise CommandError("apt has no lists of packages", "As root: apt-get update")
    answer = find(options.path)
    if options.names:
        say("\n".join(to_install(answer)), end="\n" if answer.missing else "")
    else:
        say("\n".join(page(answer)))
    return 1 if answer.nowhere else 0


def find_manifests(folder):
    """Lists the package.xml files at and below a folder, as catkin finds them.

    Raises:
        UsageError: There are none.
    """
    manifests = manifests_below(folder)
    if not manifests:
        raise UsageError(f"there is no package.xml at or below {folder!r}")
    return manifests


def folders_of(words):
    """Returns the folders of packages that words stand for: paths, packages, launch files.

    Raises:
        UsageError: A word is none of these.
    """
    folders = []
    for word in words:
        path = workspace.package_folder(word) or word
        if os.path.isfile(path):
            path = os.path.dirname(os.path.abspath(path))
            while not os.path.exists(f"{path}/package.xml") and path != os.path.dirname(path):
                path = os.path.dirname(path)
        if os.path.isdir(path) and manifests_below(path):
            folders.append(path)
        elif not (folders and word.endswith(".launch")):  # PACKAGE FILE.launch, as of roslaunch
            raise UsageError(f"{word!r} is no package, and neither a folder nor a file of one")
    return folders


def read_manifest(path):
    """Reads a package.xml.

    Returns:
        (name, dict from a dependency to the tags that ask for it, in the file's order).

    Raises:
        UsageError: It is no package.xml.
    """
    from xml.etree import ElementTree

    try:
        root = ElementTree.fromstring(read(path))
    except (ValueError, ElementTree.ParseError) as error:
        raise UsageError(f"{path} is not XML: {error}") from None
    name = (root.findtext("name") or "").strip()
    if root.tag != "package" or not name:
        raise UsageError(f"{path} is no package.xml: it has no <package> with a <name>")
    wanted = {}
    for element in root:
        text, tag = (element.text or "").strip(), element.tag
        asks = text and tag.endswith("depend") and tag not in OTHER_TAGS
        if asks and _stands(element.get("condition")):
            wanted.setdefault(text, []).append(tag)
    return name, wanted


def without_tests(wanted):
    """Lists what of read_manifest()'s dependencies not only tests ask for."""
    return [name for name, tags in wanted.items() if tags != ["test_depend"]]


def readable(paths):
    """Reads package.xml files; of several, those that are none are named and left out.

    Returns:
        Dict from the path of each to what read_manifest() returns.

    Raises:
        UsageError: There is one, and it is none.
    """
    found = {}
    for path in paths:
        try:
            found[path] = read_manifest(path)
        except UsageError as error:
            if len(paths) == 1:
                raise
            say(f"left out: {error}")
    return found


def named_in_launch_files(folder):
    """Returns the packages of which the launch files of a package start nodes or take files."""
    named = [_IN_LAUNCH_FILE.findall(read_xml(path)) for path in launch_files(folder)]
    return {first or second for pairs in named for first, second in pairs}


def launch_files(folder):
    """Lists the launch files at and below a folder."""
    return sorted(glob.glob(f"{glob.escape(folder)}/**/*.launch", recursive=True))


def in_cpp(manifest, name):
    """Returns whether C++ beside or below a package.xml includes headers of a package."""
    wanted = re.compile(rf"#\s*include\s*[<\"]{re.escape(name)}/")
    return any(wanted.search(text) for text in old_code.texts(os.path.dirname(manifest))[1])


@functools.lru_cache(maxsize=None)
def _stands(condition):
    """Whether a condition of format 3 (REP 149) lets a dependency stand; None: there is none."""
    if not condition:
        return True
    command = [PYTHON, "-I", CONDITION, condition, *VARIABLES]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode == 3:
        prepare()  # catkin_pkg comes with rosdep
        done = subprocess.run(command, capture_output=True, text=True)
    return done.stdout.strip() != "False"  # what is no condition is named by catkin


def resolve(names, debians_ros=True):
    """Asks rosdep which Debian packages names stand for; installs rosdep if it is missing.

    Args:
        names: Of dependencies.
        debians_ros: Whether a ROS package may be Debian's.

    Returns:
        Dict from each name to a list of Debian packages, empty where rosdep does not know it. Names
        of Python modules and libraries that it does not know are taken for Debian's own.

    Raises:
        CommandError: rosdep's library ended with an error.
    """
    import json

    prepare()
    lists = [OUR_LIST, *([sources.DEBIANS_LIST] if debians_ros else []), ROSDEPS_LIST]
    names = sorted(set(names))
    done = subprocess.run(
        [PYTHON, "-I", LOOKUP, os_release().get("VERSION_CODENAME", "sid"), *lists],
        input=json.dumps(names),
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode != 0:
        raise CommandError(f"rosdep: {(done.stderr.strip().splitlines() or ['it died'])[-1]}")
    known = json.loads(done.stdout)
    return {name: known.get(name) or _as_debian(name) for name in names}


def _as_debian(name):
    dashed = name.replace("_", "-").lower()
    if dashed.startswith("python-"):  # rosdep's names of the time of Python 2
        return [f"python3-{dashed[len('python-') :]}"]
    return [dashed] if dashed.startswith(("python3-", "lib")) else []


def prepare():
    """Installs what looks names up and brings sources, if it is missing."""
    if not all(map(os.path.exists, (ROSDEP, VCS))):
        packages.prepare("apt-sources.txt")


def has_lists():
    """Returns whether apt knows more than what is installed."""
    done = subprocess.run(["apt-cache", "policy"], capture_output=True, text=True, check=True)
    return any("http" in line or "file:" in line for line in done.stdout.splitlines())


@dataclass
class Answer:
    """The lists; their entries are names of

    Attributes:
        packages: Packages of the folder.
        here: Of them, those that another one asks for.
        paddock: In Paddock's workspace, with those of its stand-ins.
        sourced: In a ROS that is not Debian's.
        installed: Dependency -> Debian packages, all installed.
        missing: Dependency -> Debian packages that are there to be installed.
        nowhere: Dependency -> packages that ask for it.
        launched: What only launch files ask for and is not there -> Debian packages that have it.
    """

    packages: list = field(default_factory=list)
    here: list = field(default_factory=list)
    paddock: list = field(default_factory=list)
    sourced: list = field(default_factory=list)
    installed: dict = field(default_factory=dict)
    missing: dict = field(default_factory=dict)
    nowhere: dict = field(default_factory=dict)
    launched: dict = field(default_factory=dict)


def ours():
    """Lists the packages of Paddock's workspace, and what its stand-ins answer for."""
    users = users_packages()
    names = set(manifests_of(SOURCES)) - set(given_way(users))
    return names | users.keys() | {"gazebo"}


def of_sourced_ros():
    """Lists the packages of a ROS that is not Debian's."""
    files = glob.glob(f"{ros.share()}/*/package.xml") if ros.prefix() else []
    return {os.path.basename(os.path.dirname(path)) for path in files}


def find(folder, existing=existing, installed=installed, paddock=None, resolve=resolve, tests=True):
    """Looks up everything that the packages of a folder ask for.

    Args:
        folder: Or a list of folders.
        tests: Whether what only tests ask for counts.
        existing, installed: From names of Debian packages to those of which it is true.
        resolve: See resolve().
        paddock: Names of Paddock's packages; None to look.

    Returns:
        Answer.
    """
    folders = [folder] if isinstance(folder, str) else folder
    manifests = readable([path for place in folders for path in find_manifests(place)])
    paddock = ours() if paddock is None else paddock
    sourced = of_sourced_ros()
    answer = Answer(packages=[name for name, _ in manifests.values()])
    asking, launching = {}, set()
    for path, (name, wanted) in manifests.items():
        place = os.path.dirname(path)
        wanted = wanted if tests else without_tests(wanted)
        for dependency in dict.fromkeys([*wanted, *left_out.components_of(place)]):
            asking.setdefault(dependency, []).append(name)
        launching |= named_in_launch_files(place)
        paddock = paddock - {name for name in PYTHON_ONLY if name in asking and in_cpp(path, name)}
    elsewhere = {*answer.packages, *paddock, *sourced}
    launching -= elsewhere | asking.keys()
    possible = resolve({*asking, *launching} - elsewhere, not ros.prefix())
    known = existing([choice for choices in possible.values() for choice in choices])
    there = installed(known)
    for name in [*sorted(asking), *sorted(launching)]:
        choices = [choice for choice in possible.get(name, ()) if choice in known]
        lacking = [choice for choice in choices if choice not in there]
        if name in answer.packages:
            answer.here.append(name)
        elif name in paddock:
            answer.paddock.append(name)
        elif name in sourced:
            answer.sourced.append(name)
        elif name in launching:
            if lacking or not choices:
                answer.launched[name] = lacking
        elif not choices:
            answer.nowhere[name] = asking[name]
        elif lacking:
            answer.missing[name] = lacking
        else:
            answer.installed[name] = choices
    return answer


def page(answer):
    """Returns the lines that are printed."""
    lines = [f"packages: {', '.join(answer.packages)}"]
    for title, names in (
        ("asked for and here", answer.here),
        ("in Paddock", answer.paddock),
        (f"in {ros.prefix()}", answer.sourced),
        ("installed from Debian", list(answer.installed)),
    ):
        if names:
            lines += _wrapped(f"{title}: {', '.join(names)}")
    if answer.missing:
        lines.append("in Debian, not installed:")
        lines += [f"  {name}: {' '.join(packages)}" for name, packages in answer.missing.items()]
        names = " ".join(to_install(answer))
        lines.append(f"  apt-get install --no-install-recommends {names}")
    if answer.nowhere:
        places = ["Debian", ros.prefix(), "Paddock"]
        lines.append(f"neither in {' nor in '.join(filter(None, places))}:")
        lines += [
            f"  {name}, for {', '.join(asker)}{_with(sources.adding(name))}"
            for name, asker in answer.nowhere.items()
        ]
        if sum(bool(sources.adding(name)) for name in answer.nowhere) > 1:
            lines.append("  ./run add --for PATH brings all of these at once")
    return lines + launched(answer)


def launched(answer):
    """Returns the lines that say what launch files ask for and is not there."""
    if not answer.launched:
        return []
    return ["launch files also ask for:"] + [
        f"  {name}{_with(apt_get(packages) or sources.adding(name))}"
        for name, packages in answer.launched.items()
    ]


def apt_get(names):
    """Returns the command that installs Debian packages; empty: there are none."""
    return f"apt-get install {' '.join(names)}" if names else ""


def _with(remedy):
    return f": {remedy}" if remedy else ""


def to_install(answer):
    """Lists the Debian packages to install."""
    return sorted({package for packages in answer.missing.values() for package in packages})


def offer(folders, ask):
    """Installs what packages need of Debian, after naming it.

    Args:
        folders: The packages' folders.
        ask: Function of a question that returns whether to do it.

    Raises:
        SystemExit: Debian packages could not be installed, and ./run has said why.
    """
    if not has_lists():
        return
    answer = find(folders)
    names = to_install(answer)
    if not names:
        return
    for line in _wrapped(f"packages in src/ need of Debian: {' '.join(names)}"):
        say(line)
    if ask("Install them?"):
        write(WANTED, "".join(f"{name}\n" for name in names))
        packages.prepare(os.path.relpath(WANTED, os.path.join(ROOT, "config")))


def _wrapped(text):
    import textwrap

    return textwrap.wrap(text, WIDTH, subsequent_indent="  ", break_on_hyphens=False)
