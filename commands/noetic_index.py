"""Prints what ROS's index knows of Noetic: a line a repository, for config/sources/noetic.txt.

Run by the system's Python, as rosdistro is Debian's, with the address of the index (REP 153):
  REPOSITORY TYPE URL VERSION PACKAGE ...
A release has a branch a package: VERSION has {package} in it. It stands in place of sources that
have no branch in the index; for others a second line, without packages, tells where it is.
"""

import re
import sys

from rosdistro import get_distribution_file, get_index

DISTRIBUTION = "noetic"


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


def main():
    index = get_index(sys.argv[1])
    for line in lines(get_distribution_file(index, DISTRIBUTION).repositories):
        if re.fullmatch(r"[\w.-]+ (git|hg|svn) \S+ \S+( [\w-]+)*", line):
            print(line)


if __name__ == "__main__":
    main()
