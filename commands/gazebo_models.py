"""Models of Gazebo's database for ./run add models: those that files name, and what these name.

They go to MODELS, a sparse checkout of osrf/gazebo_models, which GAZEBO_MODEL_PATH has.
"""

import glob
import os
import re
import shutil

from commands import sources
from commands.bootstrap import workspace
from commands.errors import CommandError, UsageError, say
from commands.git import git
from commands.paths import CACHE, MODELS, read_xml, relative

REPOSITORY = sources.Repository(
    "gazebo_models", "git", "https://github.com/osrf/gazebo_models.git", "master"
)
NAMING = (".world", ".sdf", ".urdf", ".xacro", ".launch", ".gazebo")  # files that name models
NAMED = re.compile(r"model://([^/\s<\"']+)")
BUILT_IN = frozenset(("sun", "ground_plane"))  # Paddock has them


def add(words, clone=None):
    """Brings the models that are not there and says how large they are.

    Args:
        words: Models, packages, and paths of files or folders that name models.
        clone: Where a clone of the repository is; None: from the network.

    Raises:
        UsageError: A word is none of these.
        CommandError: They cannot be had.
    """
    known = sources.database()
    wanted = set().union(*(_named_by(word, known) for word in words)) & known - BUILT_IN
    brought = set()
    while wanted - brought:  # models may name others
        new = {name for name in wanted - brought if not os.path.isdir(_path(name))}
        _check_out(sorted(wanted), clone)  # those that are there, too: half of one may be
        brought |= wanted
        wanted = set().union(*map(_names_in, map(_path, wanted))) & known - BUILT_IN
        for name in sorted(new):
            say(f"{name}: {_size(_path(name)) / 1e6:.1f} MB")
    say(
        f"in {relative(MODELS)}: {', '.join(sorted(brought)) or 'nothing of the database is named'}"
    )


def named_in(folders):
    """Models of the database that files in folders name."""
    return set().union(*map(_names_in, folders)) & sources.database() - BUILT_IN


def _path(name):
    return os.path.join(MODELS, name)


def _named_by(word, known):
    """Names of models that a word stands for."""
    if word in known:
        return {word}
    if os.path.exists(word):
        return _names_in(word)
    package = workspace.package_folder(word)
    if package:
        return _names_in(package)
    raise UsageError(
        f"{word!r} is no model of Gazebo's database, no package and no file",
        "config/gazebo_models.txt lists the models",
    )


def _names_in(path):
    """Names of all models that a file, or files of a folder, name."""
    if os.path.isfile(path):
        return set(NAMED.findall(read_xml(path)))
    result = set()
    for directory, below, files in os.walk(path):
        below[:] = [name for name in below if not name.startswith(".")]
        for name in files:
            if name.endswith(NAMING):
                result.update(NAMED.findall(read_xml(os.path.join(directory, name))))
    return result


def _check_out(names, clone):
    part = f"{MODELS}.part"
    if not os.path.isdir(os.path.join(MODELS, ".git")):
        few = ("--depth", "1", "--filter=blob:none") if clone is None else ("--shared",)
        shutil.rmtree(part, ignore_errors=True)
        _git(CACHE, "clone", *few, "--no-checkout", "--quiet", clone or REPOSITORY.url, part)
        os.rename(part, MODELS)
    for path in glob.glob(os.path.join(MODELS, ".git", "**", "*.lock"), recursive=True):
        os.remove(path)
    _git(MODELS, "sparse-checkout", "init", "--cone")
    there = [name for name in os.listdir(MODELS) if name[0] != "." and os.path.isdir(_path(name))]
    _git(MODELS, "sparse-checkout", "set", *sorted({*there, *names}))
    _git(MODELS, "checkout", "--quiet", "--force")
    missing = [name for name in names if not os.path.isdir(_path(name))]
    if missing:
        raise CommandError(f"{', '.join(missing)}: not in {REPOSITORY.url}")


def _git(folder, *words):
    done = git(folder, *words)
    if done.returncode != 0:
        lines = [line for line in done.stderr.splitlines() if line.strip()]
        raise CommandError(f"{REPOSITORY.url} cannot be brought", *lines[-3:])


def _size(folder):
    """Bytes of a folder's files."""
    return sum(
        os.path.getsize(os.path.join(directory, name))
        for directory, _, names in os.walk(folder)
        for name in names
    )
