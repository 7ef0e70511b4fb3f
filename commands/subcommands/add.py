"""Brings ROS packages from their sources into src/, installs what they need of Debian, builds them.

NAME is one of --list (config/sources/NAME.repos: each was built and started with Paddock), or the
URL of a git repository, with #BRANCH at its end if it is not to be the default branch. For example:
  ./run add navigation gmapping
  ./run add https://github.com/somebody/their_robot.git#noetic-devel
Packages in src/ take the place of stand-ins of the same name. What cannot be built is left out and
named. A repository that is in src/ already stays as it is.
"""

import glob
import os
import re
import subprocess
from dataclasses import dataclass

from commands import bootstrap
from commands.bootstrap import left_out, workspace
from commands.errors import CommandError, UsageError, say
from commands.paths import CACHE, ROOT, SOURCES, read, relative, write
from commands.subcommands import deps, setup

USAGE = "[--from FOLDER] NAME|URL ... | --list"
FOLDER = os.path.join(ROOT, "config", "sources")
ARCHIVES = {".tar": "tar", ".tar.gz": "tar", ".tgz": "tar", ".tar.bz2": "tar", ".zip": "zip"}
URL = re.compile(r"(?:[a-z+]+://|[\w.-]+@[\w.-]+:).+")


@dataclass(frozen=True)
class Repository:
    """A repository of sources.

    Attributes:
        name: Its folder in src/.
        kind: As vcstool names it: git, tar, zip.
        url: Where it is.
        version: Branch, tag or commit; of an archive the folder in it. Empty: the default branch.
    """

    name: str
    kind: str
    url: str
    version: str = ""


@dataclass(frozen=True)
class Listed:
    """What a file of config/sources/ says.

    Attributes:
        about: What it is, in one line.
        version: Why these branches.
        next: Commands to type then.
        repositories: Tuple of Repository.
    """

    about: str
    version: str
    next: tuple
    repositories: tuple


def add_arguments(parser):
    """Declares names, --from and --list."""
    names = parser.add_argument("names", nargs="*", metavar="NAME", help="of --list, or a URL")
    names.complete = listed
    parser.add_argument(
        "--from",
        dest="folder",
        metavar="FOLDER",
        help="take clones (NAME, NAME.git) or archives (NAME.tar.gz, NAME.zip ...) from there "
        "instead of the network",
    )
    parser.add_argument("--list", action="store_true", help="tell what there is")


def run(options, _rest):
    """Brings, builds and says what there is now."""
    if options.list:
        return print_list()
    if not options.names:
        raise UsageError("add needs a name", f"usage: ./run add {USAGE}")
    wanted = [(name, entry_of(name)) for name in options.names]
    before = set(workspace.users_packages())
    deps.prepare()
    for repository in {
        each.name: each for _, entry in wanted for each in entry.repositories
    }.values():
        bring(repository, options.folder)
    users = workspace.users_packages()
    deps.offer(list(users.values()), setup.asked)
    bootstrap.prepare()
    entries = left_out.saved()
    for entry in entries:
        say(entry.line())
    gone = {entry.package for entry in entries if not entry.program}
    new = sorted(set(users) - before - gone)
    say(f"here now: {', '.join(new) or 'nothing new'}")
    for _, entry in wanted:
        for command in entry.next:
            say(f"  {command}")
    return 0


def listed():
    """Lists the names of config/sources/."""
    return sorted(
        os.path.basename(path)[: -len(".repos")] for path in glob.glob(f"{FOLDER}/*.repos")
    )


def entry_of(name):
    """Returns what a name of the list or a URL stands for.

    Raises:
        UsageError: It is neither.
    """
    if URL.fullmatch(name):
        url, _, version = name.partition("#")
        folder = re.sub(r"\.git$", "", url.rstrip("/").rpartition("/")[2].rpartition(":")[2])
        if not re.fullmatch(r"[\w.-]+", folder):
            raise UsageError(f"URL is {name!r}; its last part must name the repository")
        return Listed("", "", (), (Repository(folder, "git", url, version),))
    if name not in listed():
        raise UsageError(
            f"name is {name!r}; there are {', '.join(listed())}, or the URL of a repository"
        )
    return read_list(os.path.join(FOLDER, f"{name}.repos"))


def read_list(path):
    """Reads a file of vcstool whose comments say what it is, why these versions, what to type next.

    Raises:
        CommandError: It is not in that format.
    """
    words, repositories, fields = {"about": [], "version": [], "next": []}, [], {}
    for line in read(path).splitlines():
        comment = re.fullmatch(r"# (about|version|next): (.*)", line)
        entry = re.fullmatch(r"  ([\w.-]+):", line)
        value = re.fullmatch(r"    (type|url|version): (\S+)", line)
        if comment:
            words[comment[1]].append(comment[2])
        elif entry:
            fields = {}
            repositories.append((entry[1], fields))
        elif value:
            fields[value[1]] = value[2]
        elif line.strip() not in ("", "repositories:"):
            raise CommandError(f"{relative(path)}: the line {line!r} is not of a .repos file")
    return Listed(
        " ".join(words["about"]),
        " ".join(words["version"]),
        tuple(words["next"]),
        tuple(
            Repository(name, each["type"], each["url"], each.get("version", ""))
            for name, each in repositories
        ),
    )


def print_list():
    """Prints the names, what they are and their branches."""
    for name in listed():
        entry = read_list(os.path.join(FOLDER, f"{name}.repos"))
        there = all(os.path.isdir(os.path.join(SOURCES, each.name)) for each in entry.repositories)
        say(f"{name}{' (in src/)' if there else ''}: {entry.about}")
        for each in entry.repositories:
            say(f"    {each.url} {each.version}")
        say(f"    {entry.version}")
    return 0


def bring(repository, folder=None):
    """Brings a repository into src/, by vcstool.

    Args:
        folder: Where clones and archives are; None: from the network.

    Raises:
        CommandError: It is not there, or not as it should be.
    """
    target = os.path.join(SOURCES, repository.name)
    if os.path.exists(target):
        say(f"{relative(target)} is there already, and stays as it is")
        return
    found = repository if folder is None else local(repository, folder)
    path = os.path.join(CACHE, "sources.repos")
    version = f"    version: {found.version}\n" if found.version else ""
    write(
        path,
        f"repositories:\n  {found.name}:\n    type: {found.kind}\n    url: {found.url}\n{version}",
    )
    say(f"{relative(target)}: {found.url} {found.version}".rstrip())
    done = subprocess.run(
        [deps.VCS, "import", "--input", path, SOURCES],
        env={**os.environ, "GIT_TERMINAL_PROMPT": "0"},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    if done.returncode != 0:
        import shutil

        shutil.rmtree(target, ignore_errors=True)  # half of it is none
        lines = [line for line in done.stdout.splitlines() if line.strip(" .=E")]
        what = f"{found.url} {found.version}".rstrip()
        raise CommandError(f"{what} cannot be brought", *lines[-3:])


def local(repository, folder):
    """Finds the clone or the archive of a repository in a folder.

    Raises:
        CommandError: There is none.
    """
    folder = os.path.realpath(folder)
    for name in (repository.name, f"{repository.name}.git"):
        path = os.path.join(folder, name)
        if os.path.exists(os.path.join(path, ".git")) or os.path.exists(os.path.join(path, "HEAD")):
            return Repository(repository.name, "git", path, repository.version)
    for path in sorted(glob.glob(os.path.join(folder, f"{glob.escape(repository.name)}*"))):
        rest = os.path.basename(path)[len(repository.name) :]
        kind = next((kind for end, kind in ARCHIVES.items() if rest.endswith(end)), None)
        if kind and (rest in ARCHIVES or rest[0] in "-_"):
            return Repository(repository.name, kind, f"file://{path}", top_folder(path, kind))
    raise CommandError(
        f"{folder} has neither {repository.name}, a clone, nor an archive of it "
        f"({', '.join(f'{repository.name}{end}' for end in ARCHIVES)})"
    )


def top_folder(path, kind):
    """Returns the one folder in which all of an archive is; empty: there is none such."""
    if kind == "zip":
        import zipfile

        with zipfile.ZipFile(path) as archive:
            names = archive.namelist()
    else:
        import tarfile

        with tarfile.open(path) as archive:
            names = archive.getnames()
    tops = {name.partition("/")[0] for name in names if name.partition("/")[0] not in ("", ".")}
    inside = any("/" in name.rstrip("/") for name in names)
    return tops.pop() if len(tops) == 1 and inside else ""
