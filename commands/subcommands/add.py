"""Brings ROS packages from their sources into src/, installs what they need of Debian, builds them.

NAME is one of --list (config/sources/NAME.repos: each was built and started with Paddock), or the
URL of a git repository, with #BRANCH at its end if it is not to be the default branch. For example:
  ./run add navigation gmapping
  ./run add https://github.com/somebody/their_robot.git#noetic-devel
Packages in src/ take the place of stand-ins of the same name. What cannot be built is left out and
named. A repository that is in src/ already stays as it is. Submodules come, too. Of a package that
is in two repositories the one of --list is used, else the one that came last.
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
ATTEMPTS = 3  # at bringing a repository
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
    repositories = {each.name: each for _, entry in wanted for each in entry.repositories}
    for repository in repositories.values():
        bring(repository, options.folder)
    leave_copies([*repositories])
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
        folder = folder_of(url)
        if not re.fullmatch(r"[\w.-]+", folder):
            raise UsageError(f"URL is {name!r}; its last part must name the repository")
        return Listed("", "", (), (Repository(folder, "git", url, version),))
    if name not in listed():
        raise UsageError(
            f"name is {name!r}; there are {', '.join(listed())}, or the URL of a repository"
        )
    return read_list(os.path.join(FOLDER, f"{name}.repos"))


def folder_of(url):
    """Returns the name of the folder into which git clones a URL."""
    return re.sub(r"\.git$", "", url.rstrip("/").rpartition("/")[2].rpartition(":")[2])


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
    for _ in range(ATTEMPTS):
        done = subprocess.run(
            [deps.VCS, "import", "--retry", "0", "--input", path, SOURCES],
            env={**os.environ, "GIT_TERMINAL_PROMPT": "0", "LC_ALL": "C"},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            check=False,
        )
        if done.returncode == 0:
            break
        import shutil

        shutil.rmtree(target, ignore_errors=True)  # half of it is none, and stops the next attempt
    else:
        lines = [line for line in done.stdout.splitlines() if line.strip(" .=E")]
        causes = [line for line in lines if re.search(r"\b(fatal|error):", line)]
        what = f"{found.url} {found.version}".rstrip()
        raise CommandError(f"{what} cannot be brought", *(causes or lines[-3:])[:3])
    bring_submodules(target, folder)


def bring_submodules(target, folder=None):
    """Fills the empty submodules of a repository and theirs; one that cannot be had is named.

    Args:
        target: The repository's folder.
        folder: Where clones are; None: from the network.
    """
    for path, url in submodules(target):
        into = os.path.join(target, path)
        if os.path.isdir(into) and os.listdir(into):
            continue
        if folder is None:
            done = _git(target, "submodule", "update", "--init", "--", path)
        else:
            name = folder_of(url)
            try:
                source = local(Repository(name, "git", url), folder).url
            except CommandError as error:
                say(f"left out: submodule {relative(into)} ({url}): {error}")
                continue
            done = _git(target, "clone", "--quiet", source, path)
            commit = _git(target, "rev-parse", f"HEAD:{path}").stdout.strip()
            if done.returncode == 0 and _git(into, "checkout", "--quiet", commit).returncode != 0:
                say(f"{relative(into)}: {source} does not have {commit}, its newest commit is used")
        if done.returncode != 0:
            lines = [line for line in done.stderr.splitlines() if line.strip()]
            reason = next((line for line in lines if "fatal" in line), "".join(lines[-1:]))
            say(f"left out: submodule {relative(into)} ({url}): {reason}")
            continue
        say(f"{relative(into)}: {url}, a submodule")
        bring_submodules(into, folder)


def submodules(target):
    """Lists the (path, URL) of a repository's submodules."""
    file = os.path.join(target, ".gitmodules")
    if not (os.path.exists(file) and os.path.exists(os.path.join(target, ".git"))):
        return []
    fields = {}
    for line in _git(target, "config", "-f", file, "--list").stdout.splitlines():
        key, _, value = line.partition("=")
        name, _, field = key.rpartition(".")
        fields.setdefault(name, {})[field] = value
    return [
        (each["path"], each["url"]) for each in fields.values() if {"path", "url"} <= each.keys()
    ]


def _git(folder, *words):
    """Runs git; GitHub's addresses for those who have a key become those for everybody."""
    instead = [
        word
        for address in ("git@github.com:", "ssh://git@github.com/", "git://github.com/")
        for word in ("-c", f"url.https://github.com/.insteadOf={address}")
    ]
    return subprocess.run(
        ["git", *instead, *words],
        cwd=folder,
        env={**os.environ, "GIT_TERMINAL_PROMPT": "0", "LC_ALL": "C"},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=False,
    )


def leave_copies(names):
    """Disables all but one of the packages of a name, by CATKIN_IGNORE: catkin wants one.

    Args:
        names: Repositories that have just been brought.
    """
    of_list = {
        each.name
        for name in listed()
        for each in read_list(os.path.join(FOLDER, f"{name}.repos")).repositories
    }

    def rank(path):
        repository = os.path.relpath(path, SOURCES).split(os.sep)[0]
        last = names.index(repository) if repository in names else -1
        return repository in of_list, last

    for name, folders in sorted(workspace.copies().items()):
        used = max(folders, key=rank)
        for path in folders:
            if path != used:
                write(os.path.join(path, "CATKIN_IGNORE"), "")
                say(
                    f"{name}: {relative(used)} is used; {relative(path)} is disabled by its file "
                    "CATKIN_IGNORE"
                )


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
