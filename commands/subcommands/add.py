"""Brings ROS packages from their sources into src/, installs what they need of Debian, builds them.

NAME is one of --list (config/sources/NAME.repos: each was built and started with Paddock), or the
URL of a git repository, with #BRANCH at its end if it is not to be the default branch. For example:
  ./run add navigation gmapping
  ./run add https://github.com/somebody/their_robot.git#noetic-devel
  ./run add models PACKAGE|FILE|MODEL ...     # of Gazebo's database: those that they name
Packages in src/ take the place of stand-ins of the same name. What cannot be built is left out and
named. A repository that is in src/ already stays as it is. Submodules come, too. Of a package that
is in two repositories the one of --list is used, else the one that came last.
"""

import glob
import json
import os
import re
import subprocess

from commands import bootstrap, gazebo_models, processes
from commands.bootstrap import left_out, step, workspace
from commands.errors import CommandError, UsageError, say
from commands.git import git
from commands.paths import CACHE, SOURCES, relative, write
from commands.sources import Repository, entries_of, entry_of, folder_of, listed
from commands.subcommands import deps, setup

USAGE = "[--from FOLDER] NAME|URL ... | --list"
ARCHIVES = {".tar": "tar", ".tar.gz": "tar", ".tgz": "tar", ".tar.bz2": "tar", ".zip": "zip"}
ATTEMPTS = 3  # at bringing a repository
LOCK = "add.lock"
PART = ".part"  # in src/, out of catkin's sight: what is being brought


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
    with step.SetupLock(os.path.join(CACHE, LOCK), "bringing packages"):
        return add(options.names, options.folder)


def add(names, folder):
    """Brings and builds; one ./run at a time."""
    if names[0] == "models":
        deps.prepare()
        clone = folder and local(gazebo_models.REPOSITORY, folder).url
        return gazebo_models.add(names[1:], clone)
    wanted = entries_of(names)
    before = set(workspace.users_packages())
    deps.prepare()
    repositories = {
        repository.name: repository for entry in wanted for repository in entry.repositories
    }
    without = [name for entry in wanted for name in entry.without]
    for repository in repositories.values():
        bring(repository, folder, without)
    leave_copies([*repositories])
    users = workspace.users_packages()
    deps.offer(list(users.values()), setup.asked)
    bootstrap.prepare()
    entries = left_out.saved()
    for line in left_out.lines(entries):
        say(line)
    gone = {entry.package for entry in entries if not entry.program}
    new = sorted(set(users) - before - gone)
    say(f"here now: {', '.join(new) or 'nothing new'}")
    if new and deps.has_lists():
        for line in deps.launched(deps.find([users[name] for name in new])):
            say(line)
    for entry in wanted:
        for command in entry.next:
            say(f"  {command}")
    return 0


def print_list():
    """Prints the names, what they are and their branches."""
    for name in listed():
        entry = entry_of(name)
        there = all(
            os.path.isdir(os.path.join(SOURCES, repository.name))
            for repository in entry.repositories
        )
        say(f"{name}{' (in src/)' if there else ''}: {entry.about}")
        for repository in entry.repositories:
            say(f"    {repository.url} {repository.version}")
        say(f"    {entry.version}")
    return 0


def bring(repository, folder=None, without=()):
    """Brings a repository into src/, by vcstool: all of it, or nothing.

    Args:
        folder: Where clones and archives are; None: from the network.
        without: Names of packages that are disabled in it.

    Raises:
        CommandError: It is not there, or not as it should be.
        Interrupted: A signal ended it.
    """
    target = os.path.join(SOURCES, repository.name)
    if os.path.lexists(target):
        return say(f"{relative(target)} is there already, and stays as it is")
    source = repository if folder is None else local(repository, folder)
    say(f"{relative(target)}: {source.url} {source.version}".rstrip())
    import shutil

    part = os.path.join(SOURCES, PART)
    place = os.path.join(part, repository.name)
    shutil.rmtree(part, ignore_errors=True)  # of a ./run that was killed
    try:
        _import(source, part)
        bring_submodules(place, folder)
        leave_out(without, place)
        os.rename(place, target)
    finally:
        shutil.rmtree(part, ignore_errors=True)


def _import(result, folder):
    """Lets vcstool make a repository in a folder.

    Raises:
        CommandError: It cannot be had.
        Interrupted: A signal ended it.
    """
    import shutil
    import tempfile

    path = os.path.join(CACHE, "sources.repos")
    fields = {"type": result.kind, "url": result.url}
    if result.version:
        fields["version"] = result.version
    write(path, json.dumps({"repositories": {result.name: fields}}))  # YAML reads 1.10 as a number
    for _ in range(ATTEMPTS):
        os.makedirs(folder, exist_ok=True)
        with tempfile.TemporaryFile("w+", errors="replace") as said:
            status = processes.run_child(
                [deps.VCS, "import", "--retry", "0", "--input", path, folder],
                env={**os.environ, "GIT_TERMINAL_PROMPT": "0", "LC_ALL": "C"},
                stdin=subprocess.DEVNULL,
                stdout=said,
                stderr=subprocess.STDOUT,
                pass_fds=step.held_locks(),
                grace=step.GRACE,
            )
            if status == 0:
                return
            said.seek(0)
            lines = [line for line in said.read().splitlines() if line.strip(" .=E")]
        shutil.rmtree(folder, ignore_errors=True)  # half of it stops the next attempt
    causes = [line for line in lines if re.search(r"\b(fatal|error):", line)]
    what = f"{result.url} {result.version}".rstrip()
    raise CommandError(f"{what} cannot be brought", *(causes or lines[-3:])[:3])


def bring_submodules(target, folder=None):
    """Fills the empty submodules of a repository and theirs; one that cannot be had is named.

    Args:
        target: The repository's folder.
        folder: Where clones are; None: from the network.
    """
    for path, url in submodules(target):
        into = os.path.join(target, path)
        shown = _shown(into)
        if os.path.isdir(into) and os.listdir(into):
            continue
        if folder is None:
            done = git(target, "submodule", "update", "--init", "--", path)
        else:
            name = folder_of(url)
            try:
                source = local(Repository(name, "git", url), folder).url
            except CommandError as error:
                say(f"left out: submodule {shown} ({url}): {error}")
                continue
            done = git(target, "clone", "--quiet", source, path)
            commit = git(target, "rev-parse", f"HEAD:{path}").stdout.strip()
            if done.returncode == 0 and git(into, "checkout", "--quiet", commit).returncode != 0:
                say(f"{shown}: {source} does not have {commit}, its newest commit is used")
        if done.returncode != 0:
            lines = [line for line in done.stderr.splitlines() if line.strip()]
            reason = next((line for line in lines if "fatal" in line), "".join(lines[-1:]))
            say(f"left out: submodule {shown} ({url}): {reason}")
            continue
        say(f"{shown}: {url}, a submodule")
        bring_submodules(into, folder)


def submodules(target):
    """Lists the (path, URL) of a repository's submodules."""
    file = os.path.join(target, ".gitmodules")
    if not (os.path.exists(file) and os.path.exists(os.path.join(target, ".git"))):
        return []
    fields = {}
    for line in git(target, "config", "-f", file, "--list").stdout.splitlines():
        key, _, value = line.partition("=")
        name, _, field = key.rpartition(".")
        fields.setdefault(name, {})[field] = value
    return [
        (module["path"], module["url"])
        for module in fields.values()
        if {"path", "url"} <= module.keys()
    ]


def _shown(path):
    """Returns for messages where in src/ something will be."""
    return relative(path).replace(f"{PART}/", "", 1)


def leave_copies(names):
    """Disables all but one of the packages of a name, by CATKIN_IGNORE: catkin wants one.

    Args:
        names: Repositories that have just been brought.
    """
    of_list = {known.name for name in listed() for known in entry_of(name).repositories}

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


def leave_out(names, folder):
    """Disables packages at and below a folder by CATKIN_IGNORE.

    Args:
        names: Of packages.
    """
    for name, path in sorted(workspace.manifests_of(folder).items()):
        if name in names:
            write(os.path.join(path, "CATKIN_IGNORE"), "")
            say(f"{name}: {_shown(path)} is disabled by its file CATKIN_IGNORE")


def _target(member):
    """Returns what a member of a tar points to, as a name in it; a device is outside."""
    if member.issym():
        return os.path.join(os.path.dirname(member.name), member.linkname)
    if member.islnk():
        return member.linkname
    return member.name if member.isreg() or member.isdir() else os.devnull


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
    """Returns the one folder in which all of an archive is; empty: there is none such.

    Raises:
        CommandError: It is damaged, or has something that would be unpacked elsewhere.
    """
    import tarfile
    import zipfile
    import zlib

    try:
        if kind == "zip":
            with zipfile.ZipFile(path) as archive:
                names, targets = archive.namelist(), []
        else:
            with tarfile.open(path) as archive:
                members = archive.getmembers()
            names = [member.name for member in members]
            targets = [_target(member) for member in members]
    except (tarfile.TarError, zipfile.BadZipFile, zlib.error, OSError, EOFError) as error:
        raise CommandError(f"{path} cannot be unpacked: {error}") from None
    for name in (*names, *targets):
        if os.path.normpath(name).split(os.sep)[0] in ("", os.pardir):
            raise CommandError(f"{path} is not unpacked: {name!r} of it is outside of it")
    tops = {name.partition("/")[0] for name in names if name.partition("/")[0] not in ("", ".")}
    inside = any("/" in name.rstrip("/") for name in names)
    return tops.pop() if len(tops) == 1 and inside else ""
