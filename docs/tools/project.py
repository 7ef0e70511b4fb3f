"""Writes the project's address, docs/project.yml, into the files that name it.

    python docs/tools/project.py            writes them
    python docs/tools/project.py --check    names those that differ, and fails

README.md and the pages with a line to clone, CITATION.cff, each package.xml, SECURITY.md, the forms
for reports and the workflow for users' packages. The site's hook reads docs/project.yml itself.
"""

from __future__ import annotations

import argparse
import pathlib
import re
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import yaml

ROOT = pathlib.Path(__file__).resolve().parents[2]
FILE = "docs/project.yml"
UNKNOWN = "<this repository>"  # in lines to clone, while there is no address
NOBODY = "paddock@paddock.invalid"  # a package.xml needs an address; RFC 2606: this is none
HOST = re.compile(r"https://[\w.-]+(/[\w.-]+){2,}")
MAIL = re.compile(r"[\w.+-]+@[\w-]+(\.[\w-]+)+")
CLONED = re.compile(rf"(\bgit clone (?:--quiet )?)(?:{UNKNOWN}|https://\S+)( (?:/opt/)?paddock\b)")


@dataclass(frozen=True)
class Project:
    """Where the project is.

    Attributes:
        repository: Address for git clone; empty: not published.
        contact: Mail address of the maintainers; empty: there is none.
    """

    repository: str = ""
    contact: str = ""


def read(root: pathlib.Path = ROOT) -> Project:
    """Reads docs/project.yml.

    Raises:
        ValueError: A value is no address.
    """
    values = yaml.safe_load((root / FILE).read_text(encoding="utf-8"))
    for name, valid in (("repository", HOST), ("contact", MAIL)):
        if values[name] and not valid.fullmatch(values[name]):
            raise ValueError(f"{name} is {values[name]!r}; it must be like {valid.pattern}")
    return Project(**values)


def _cloned(text: str, project: Project) -> str:
    return CLONED.sub(rf"\1{project.repository or UNKNOWN}\2", text)


def _workflow(text: str, project: Project) -> str:
    return re.sub(r'(PADDOCK_URL: )"[^"]*"', rf'\1"{project.repository}"', text)


def _citation(text: str, project: Project) -> str:
    text = re.sub(r"^repository-code: .*\n", "", text, flags=re.M)
    line = f'repository-code: "{project.repository}"\n' if project.repository else ""
    return re.sub(r"^(license: .*\n)", rf"\1{line}", text, flags=re.M)


def _manifest(text: str, project: Project) -> str:
    if ">Paddock founders</maintainer>" not in text:  # a package that a user has put there
        return text
    text = re.sub(r'(<maintainer email=)"[^"]*"', rf'\1"{project.contact or NOBODY}"', text)
    text = re.sub(r'^ *<url type="repository">.*\n', "", text, flags=re.M)
    line = f'  <url type="repository">{project.repository}</url>\n' if project.repository else ""
    return re.sub(r"^( *<license>.*\n)", rf"\1{line}", text, flags=re.M)


def _forms(text: str, project: Project) -> str:
    text = text.partition("contact_links:")[0]
    if not project.repository:
        return text
    about = "Not in an issue that everybody reads"
    url = f"{project.repository}/security"
    return text + (
        f"contact_links:\n  - name: A security problem\n    url: {url}\n    about: {about}\n"
    )


def _security(text: str, project: Project) -> str:
    ways = ['in private by "Report a vulnerability" on the repository\'s page, under Security']
    if project.contact:
        ways.append(f"by mail to {project.contact}")
    if not project.repository:
        ways.append("to whoever gave you this repository")
    return re.sub(r"^Report it .*$", f"Report it {', or '.join(ways)}.", text, flags=re.M)


KINDS: tuple[tuple[str, Callable[[str, Project], str]], ...] = (
    ("README.md", _cloned),
    ("docs/*.md", _cloned),
    ("docs/ci/*.yml", _workflow),
    ("CITATION.cff", _citation),
    ("src/*/package.xml", _manifest),
    ("src/standins/*/package.xml", _manifest),
    (".github/ISSUE_TEMPLATE/config.yml", _forms),
    ("SECURITY.md", _security),
)


def changed(root: pathlib.Path = ROOT) -> Iterator[tuple[pathlib.Path, str]]:
    """Yields the files that differ from what the address makes of them, and that text."""
    project = read(root)
    for pattern, make in KINDS:
        for path in sorted(root.glob(pattern)):
            text = path.read_text(encoding="utf-8")
            wanted = make(text, project)
            if wanted != text:
                yield path, wanted


def main(arguments: list[str] | None = None) -> int:
    """Writes, or checks; returns the exit status."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--check", action="store_true", help="write nothing")
    given, found = parser.parse_args(arguments), 0
    for path, text in changed():
        print(path.relative_to(ROOT))
        found += 1
        if not given.check:
            path.write_text(text, encoding="utf-8")
    return int(bool(found and given.check))


if __name__ == "__main__":
    sys.exit(main())
