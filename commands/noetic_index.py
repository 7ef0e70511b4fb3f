"""Prints what ROS's index knows of Noetic: a line a repository, for config/sources/noetic.txt.

Run by the system's Python, as rosdistro is Debian's, with the address of the index (REP 153):
  REPOSITORY TYPE URL VERSION PACKAGE ...
Of a repository whose sources have no branch in the index, URL and VERSION are those of its release,
a branch a package: VERSION has {package} in it.
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
        if source:
            place = (source.type, source.url, source.version)
        elif release and release.version:
            version = release.tags["release"].replace("{version}", release.version)
            place = (release.type, release.url, version)
        else:
            continue
        yield " ".join((name, *place, *packages))


def main():
    index = get_index(sys.argv[1])
    for line in lines(get_distribution_file(index, DISTRIBUTION).repositories):
        if re.fullmatch(r"[\w.-]+ (git|hg|svn) \S+ \S+( [\w-]+)+", line):
            print(line)


if __name__ == "__main__":
    main()
