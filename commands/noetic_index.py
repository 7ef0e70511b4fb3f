"""Prints what ROS's index knows of Noetic and of Debian's packages, for ./run add --refresh.

Run by the system's Python, as rosdistro is Debian's, with the address of the index (REP 153) and
`noetic`, for a line a repository:
  REPOSITORY TYPE URL VERSION PACKAGE ...
or `rosdep`, for a line a name, in rosdep's format, without systems before Debian 12.
A release has a branch a package: VERSION has {package} in it. It stands in place of sources that
have no branch in the index; for others a second line, without packages, tells where it is.
"""

import json
import os
import re
import sys
import urllib.request

import yaml
from rosdistro import get_distribution_file, get_index

DISTRIBUTION = "noetic"
OLD = ("woody", "lenny", "squeeze", "wheezy", "jessie", "stretch", "buster", "bullseye")


def lines(repositories):
    """Yields the lines.

    Args:
        repositories: Dict from names to rosdistro's Repository.
    """
    for name, repository in sorted(repositories.items()):
        source, release = repository.source_repository, repository.release_repository
        packages = sorted(release.package_names) if release else [name]
        places = [(source.type, source.url, source.version)] if source else []
        if release and release.version:
            version = release.tags["release"].replace("{version}", release.version)
            places.append((release.type, release.url, version))
        for place in places:
            yield " ".join((name, *place, *packages))
            packages = []


def noetic(url):
    """Yields the lines of the index."""
    for line in lines(get_distribution_file(get_index(url), DISTRIBUTION).repositories):
        if re.fullmatch(r"[\w.-]+ (git|hg|svn) \S+ \S+( [\w-]+)*", line):
            yield line


def rosdep(url):
    """Yields the lines of rosdep's names that apt can install; those of Python 2 are left out."""
    known = {}
    for name in ("python", "base"):
        with urllib.request.urlopen(f"{os.path.dirname(url)}/rosdep/{name}.yaml") as stream:
            known.update(yaml.safe_load(stream))
    for name, systems in sorted(known.items()):
        rule = systems.get("debian")
        if isinstance(rule, dict):
            rule = {
                release: packages
                for release, packages in rule.items()
                if release not in OLD and isinstance(packages, list)
            }
        if rule and not name.startswith("python-"):
            yield f"{name}: {json.dumps({'debian': rule})}"


if __name__ == "__main__":
    print("\n".join({"noetic": noetic, "rosdep": rosdep}[sys.argv[2]](sys.argv[1])))
