"""Where sources of ROS packages are: Noetic's index, and what it lacks or has wrong.

Both are files of lines: REPOSITORY TYPE URL VERSION PACKAGE ...; of a repository with a branch a
package VERSION has {package} in it. A line without packages is a repository's release.
"""

import difflib
import functools
import os
import re
from dataclasses import dataclass

from commands.errors import UsageError
from commands.paths import ROOT, read

INDEX = os.path.join(ROOT, "config", "sources", "noetic.txt")  # of commands/noetic_index.py
MORE = os.path.join(ROOT, "config", "sources", "more.txt")
INDEX_URL = "https://raw.githubusercontent.com/ros/rosdistro/master/index-v4.yaml"
DEBIANS_LIST = "/usr/share/python3-rosdep2/debian.yaml"  # of rosdep: ROS packages of Debian
PACKAGE = "{package}"
DATABASE = os.path.join(ROOT, "config", "gazebo_models.txt")
URL = re.compile(r"(?:[a-z+]+://|[\w.-]+@[\w.-]+:).+")


@dataclass(frozen=True)
class Repository:
    """A repository of sources.

    Attributes:
        name: Its folder in src/.
        kind: As vcstool names it: git, tar, zip.
        url: Where it is.
        version: Branch, tag or commit; of an archive the folder in it. Empty: the default branch.
        only: Packages of which alone, with what they need of it, it is built; empty: all.
        released: The same packages as repositories of their own, where it cannot be had.
    """

    name: str
    kind: str
    url: str
    version: str = ""
    only: tuple = ()
    released: tuple = ()


@functools.lru_cache(maxsize=None)
def index():
    """Reads both files.

    Returns:
        (dict from a repository to (kind, url, version, packages), dict from a package to its
        repository, dict from a repository to the same of its release).
    """
    repositories, packages, releases = {}, {}, {}
    for line in [*read(INDEX).splitlines(), *read(MORE).splitlines()]:
        if line and not line.startswith("#"):
            name, kind, url, version, *of_it = line.split()
            (repositories if of_it else releases)[name] = (kind, url, version, tuple(of_it))
            packages.update(dict.fromkeys(of_it, name))
    return repositories, packages, releases


def names():
    """Lists the repositories and packages that have sources."""
    repositories, packages, _ = index()
    return sorted({*repositories, *packages})


def folders():
    """Names of the folders in src/ into which repositories of the index come."""
    return {folder_of(url) for _, url, *_ in index()[0].values()}


def repositories_of(name):
    """Returns the repositories for a name: of a repository, else of a package; or a URL.

    Raises:
        UsageError: It is nothing of these.
    """
    if URL.fullmatch(name):
        url, _, version = name.partition("#")
        folder = folder_of(url)
        if not re.fullmatch(r"[\w.-]+", folder):
            raise UsageError(f"URL is {name!r}; its last part must name the repository")
        return [Repository(folder, "git", url, version)]
    repositories = index()[0]
    found = _of_index(name, repositories[name][3]) if name in repositories else of_package(name)
    if not found:
        near = difflib.get_close_matches(name, names(), 3)
        raise UsageError(
            f"name is {name!r}; valid: a repository or a package of Noetic's index"
            f"{' (' + ', '.join(near) + ')' if near else ''}, a name of ./run add --list, a URL"
        )
    return found


def of_package(name):
    """Returns the repository that has a package, in a list; empty: none is known."""
    repository = index()[1].get(name)
    return _of_index(repository, (name,)) if repository else []


def _of_index(name, packages):
    repositories, _, releases = index()
    kind, url, version, _ = repositories[name]
    if PACKAGE in version:
        return _a_package(packages, kind, url, version)
    released = _a_package(packages, *releases[name][:3], "-release") if name in releases else ()
    return [Repository(folder_of(url), kind, url, version, packages, tuple(released))]


def _a_package(packages, kind, url, version, end=""):
    return [
        Repository(f"{package}{end}", kind, url, version.replace(PACKAGE, package))
        for package in packages
    ]


def database():
    """Names of the models of Gazebo's database, which Gazebo downloads where a file names them."""
    return frozenset(read(DATABASE).split())


def folder_of(url):
    """Returns the name of the folder into which git clones a URL."""
    return re.sub(r"\.git$", "", url.rstrip("/").rpartition("/")[2].rpartition(":")[2])


def adding(package):
    """Returns the command that brings the sources of a ROS package; empty: Debian has it, or none
    are known."""
    known = package in index()[1] and package not in _of_debian()
    return f"./run add {package}" if known else ""


@functools.lru_cache(maxsize=None)
def _of_debian():
    return frozenset(re.findall(r"^([\w-]+):", read(DEBIANS_LIST), re.MULTILINE))
