"""What becomes of each dependency: it is in the folder, in Paddock, in Debian, or nowhere."""

import glob
from dataclasses import dataclass, field

from commands.bootstrap.inputs import installed_elsewhere
from commands.dependencies import debian, manifests
from commands.paths import SOURCES

WIDTH = 96


@dataclass
class Answer:
    """The lists; their entries are names of dependencies.

    Attributes:
        packages: Packages of the folder.
        here: Of them, those that another one asks for.
        paddock: In Paddock's workspace, with those of its stand-ins.
        installed: Dependency -> Debian packages, all installed.
        missing: Dependency -> Debian packages that are there to be installed.
        nowhere: Dependency -> packages that ask for it.
    """

    packages: list = field(default_factory=list)
    here: list = field(default_factory=list)
    paddock: list = field(default_factory=list)
    installed: dict = field(default_factory=dict)
    missing: dict = field(default_factory=dict)
    nowhere: dict = field(default_factory=dict)


def ours():
    """Lists the packages of Paddock's workspace."""
    files = glob.glob(f"{SOURCES}/**/package.xml", recursive=True)
    return {manifests.read(path)[0] for path in files} - set(installed_elsewhere())


def find(folder, existing=debian.existing, installed=debian.installed, paddock=None):
    """Looks up everything that the packages of a folder ask for.

    Args:
        folder: Path.
        existing, installed: From names of Debian packages to those of which it is true.
        paddock: Names of Paddock's packages; None to look.

    Returns:
        Answer.
    """
    read = [manifests.read(path) for path in manifests.find(folder)]
    paddock = ours() if paddock is None else paddock
    answer = Answer(packages=[name for name, _ in read])
    asking, built = {}, set()
    for name, wanted in read:
        for dependency, tags in wanted.items():
            asking.setdefault(dependency, []).append(name)
            built |= set() if set(tags) <= set(manifests.RUN_ONLY) else {dependency}
    possible = {name: debian.candidates(name, name in built) for name in asking}
    known = existing([choice for choices in possible.values() for choice in choices])
    there = installed(known)
    for name, askers in sorted(asking.items()):
        choices = [choice for choice in possible[name] if choice in known]
        if name in answer.packages:
            answer.here.append(name)
        elif name in paddock:
            answer.paddock.append(name)
        elif not choices:
            answer.nowhere[name] = askers
        elif set(choices) <= there:
            answer.installed[name] = choices
        else:
            answer.missing[name] = [choice for choice in choices if choice not in there]
    return answer


def page(answer):
    """Gives the lines that are printed."""
    lines = [f"packages: {', '.join(answer.packages)}"]
    for title, names in (
        ("asked for and here", answer.here),
        ("in Paddock", answer.paddock),
        ("installed from Debian", list(answer.installed)),
    ):
        if names:
            lines += _wrapped(f"{title}: {', '.join(names)}")
    if answer.missing:
        lines.append("in Debian, not installed:")
        lines += [f"  {name}: {' '.join(found)}" for name, found in answer.missing.items()]
        names = " ".join(to_install(answer))
        lines.append(f"  apt-get install --no-install-recommends {names}")
    if answer.nowhere:
        lines.append("neither in Debian nor in Paddock:")
        lines += [f"  {name}, for {', '.join(asker)}" for name, asker in answer.nowhere.items()]
    return lines


def to_install(answer):
    """Lists the Debian packages to install."""
    return sorted({package for found in answer.missing.values() for package in found})


def _wrapped(text):
    import textwrap

    return textwrap.wrap(text, WIDTH, subsequent_indent="  ", break_on_hyphens=False)
