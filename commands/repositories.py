"""Repositories of sources: brought into src/ by vcstool, all of one or nothing, with submodules."""

import glob
import json
import os
import re

from commands.bootstrap import step
from commands.errors import CommandError, UsageError, say
from commands.git import git
from commands.paths import CACHE, SOURCES, read, relative, write
from commands.sources import Repository, folder_of
from commands.subcommands import deps

ARCHIVES = {".tar": "tar", ".tar.gz": "tar", ".tgz": "tar", ".tar.bz2": "tar", ".zip": "zip"}
ATTEMPTS = 3  # at bringing a repository
UNASKED = "Nobody has asked for this package: ./run add"  # how a CATKIN_IGNORE of ours begins
_lost = {}  # (folder, URL, version) that cannot be brought: not asked for again -> CommandError
PART = ".part"  # in src/, out of catkin's sight: what is being brought


def bring(repository, folder=None):
    """Brings a repository, or what is released of it, into src/; enables its packages.

    Args:
        folder: Where clones and archives are; None: from the network.

    Returns:
        List of the folders' names.

    Raises:
        CommandError: It is not there, or not as it should be.
        Interrupted: A signal ended it.
    """
    place = folder, repository.url, repository.version
    if place not in _lost:
        try:
            _bring(repository, folder)
            return [repository.name]
        except CommandError as error:
            if not repository.released:
                raise
            say(f"{'; '.join([str(error), *error.advice[:1]])}: its release is looked for")
            _lost[place] = error
    try:
        return [name for each in repository.released for name in bring(each, folder)]
    except CommandError:
        raise _lost[place] from None


def _bring(repository, folder):
    """Brings a repository by vcstool: all of it, or nothing."""
    target = os.path.join(SOURCES, repository.name)
    if os.path.lexists(target):
        enable(target, repository.only, is_new=False)
        return say(f"{relative(target)} is there already, and stays as it is")
    source = repository if folder is None else local(repository, folder)
    say(f"{relative(target)}: {source.url} {source.version}".rstrip())
    import shutil

    part = os.path.join(SOURCES, PART)
    place = os.path.join(part, repository.name)
    shutil.rmtree(part, ignore_errors=True)  # of a ./run that was killed
    try:
        _import(source, part)
        if repository.released and not _manifests(place).keys() & set(repository.only):
            raise CommandError(f"{source.url} has no package.xml of {', '.join(repository.only)}")
        bring_submodules(place, folder)
        enable(place, repository.only, is_new=True)
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

    path = os.path.join(CACHE, "sources.repos")
    fields = {"type": result.kind, "url": result.url}
    if result.version:
        fields["version"] = result.version
    write(path, json.dumps({"repositories": {result.name: fields}}))  # YAML reads 1.10 as a number
    for _ in range(ATTEMPTS):
        os.makedirs(folder, exist_ok=True)
        command = [deps.VCS, "import", "--retry", "0", "--input", path, folder]
        status, lines = step.run_quietly(command)
        if status == 0:
            return
        shutil.rmtree(folder, ignore_errors=True)  # half of it stops the next attempt
        if any("invalid reference" in line for line in lines):
            break
    lines = [line for line in lines if line.strip(" .=E")]
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


def _manifests(folder):
    """Reads the package.xml files of a repository: of each name (its folder, what it asks for)."""
    result = {}
    for path in glob.glob(f"{glob.escape(folder)}/**/package.xml", recursive=True):
        try:
            name, wanted = deps.read_manifest(path)
        except UsageError:
            continue
        result[name] = os.path.dirname(path), deps.without_tests(wanted)
    return result


def enable(folder, only, is_new):
    """Enables packages of a repository, with those of it that they need; disables the others.

    Args:
        folder: Of the repository.
        only: Their names; empty, or all of other repositories: all.
        is_new: Whether it has just been brought; else none is disabled.
    """
    manifests = _manifests(folder)
    needed, left = set(), [name for name in only if name in manifests] or list(manifests)
    while left:
        name = left.pop()
        if name in manifests and name not in needed:
            needed.add(name)
            left += manifests[name][1]
    disabled = []
    for name, (path, _) in manifests.items():
        marker = os.path.join(path, "CATKIN_IGNORE")
        if name in needed and read(marker).startswith(UNASKED):
            os.remove(marker)
        elif name not in needed and is_new and not os.path.exists(marker):
            write(marker, f"{UNASKED} {name}\n")
            disabled.append(name)
    if disabled:
        say(f"  not asked for, disabled by CATKIN_IGNORE: {', '.join(sorted(disabled))}")


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
    named = (folder_of(repository.url), repository.name, f"{repository.name}.git")
    for path in [os.path.join(folder, name) for name in named]:
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
