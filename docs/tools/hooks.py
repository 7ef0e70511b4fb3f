"""What mkdocs.yml needs besides docs/: the pages beside the code, and links that leave the site.

README.md becomes the first page; the packages' README.md, CHANGELOG.md, CONTRIBUTING.md and
SECURITY.md are pages, too. A link to any other file of the repository goes to its web page where
docs/project.yml has the address; else its path is written. A link to a film that is alone in its
line shows the film.
"""

from __future__ import annotations

import pathlib
import posixpath
import re

import yaml
from mkdocs.structure.files import File

ROOT = pathlib.Path(__file__).resolve().parents[2]
REPOSITORY = yaml.safe_load((ROOT / "docs" / "project.yml").read_text())["repository"]
LINK = re.compile(r"(!?)\[((?:[^][]|!?\[[^][]*\]\([^)]*\))*)\]\(([^)\s]+)\)")
FENCE = re.compile(r"^```(\w+) (terminal|expect|file=(\S+))$", re.MULTILINE)
FILM = re.compile(r"^\[([^]\n]*)\]\((\S+\.mp4)\)$", re.MULTILINE)
TITLES = {"terminal": "in a terminal of its own", "expect": "what it prints, in part"}
CODE = re.compile(r"^```[\s\S]*?^```|(?<=\n\n)(?:    [^\n]*\n)+|`[^`\n]*`", re.MULTILINE)
LEFT_OUT = ("docs/tools/", "docs/ci/", "docs/support/", "docs/tutorials/class/")  # as in mkdocs.yml
SKIPPED = ("http://", "https://", "mailto:", "#")


def beside_code() -> dict[str, str]:
    """Path in the repository -> path in the site of the pages and images that are not in docs/."""
    pages = {
        "README.md": "index.md",
        "CHANGELOG.md": "changelog.md",
        "CONTRIBUTING.md": "contributing.md",
        "SECURITY.md": "security.md",
        "src/bullet_bridge/docs/sending.md": "packages/sending.md",
        "src/cybertruck/docs/trailer.md": "packages/trailer.md",
    }
    for path in sorted((ROOT / "src").glob("*/README.md")):
        pages[path.relative_to(ROOT).as_posix()] = f"packages/{path.parent.name}.md"
    for path in sorted((ROOT / "src").glob("*/docs/images/*")):
        pages[path.relative_to(ROOT).as_posix()] = f"packages/images/{path.name}"
    return pages


PAGES = beside_code()
SOURCES = {site: source for source, site in PAGES.items()}


def on_config(config):
    """Links the repository in the head of each page, where there is an address."""
    config.repo_url = REPOSITORY or None
    return config


def on_files(files, config):
    """Adds the pages beside the code."""
    for source, site in PAGES.items():
        files.append(File.generated(config, site, abs_src_path=str(ROOT / source)))
    return files


def on_page_markdown(markdown, page, config, files):
    """Makes links those of the site and fences those of mkdocs."""
    site = page.file.src_uri
    source = SOURCES.get(site, f"docs/{site}")
    kept = []

    def keep(match):
        kept.append(match.group())
        return f"\x00{len(kept) - 1}\x00"

    text = CODE.sub(keep, markdown)
    text = LINK.sub(lambda match: link(match, source, site), text)
    text = FILM.sub(r'<video src="\2" controls preload="metadata" muted></video>\n\n*\1*', text)
    text = re.sub("\x00(\\d+)\x00", lambda match: code(kept[int(match[1])]), text)
    if site == "index.md":
        page.meta["hide"] = ["navigation"]  # it has no pages beside it
    return FENCE.sub(fence, text)


def code(text: str) -> str:
    """Code as it has to be: in a table's cell mkdocs would show the backslash before a bar."""
    if text.startswith("```") or r"\|" not in text:
        return text
    plain = text.strip("`").replace(r"\|", "|")
    return "<code>" + re.sub(r"[^\w ]", lambda sign: f"&#{ord(sign[0])};", plain) + "</code>"


def fence(match) -> str:
    """The first line of a box of the tutorials."""
    language, kind, path = match.groups()
    return f'```{language} title="{path or TITLES[kind]}"'


def link(match, source: str, site: str) -> str:
    """A link as it has to be on a page of the site.

    Args:
        source: The page's path in the repository.
        site: Its path in the site.
    """
    mark, label, target = match.groups()
    label = LINK.sub(lambda inner: link(inner, source, site), label)
    if target.startswith(SKIPPED):
        return f"{mark}[{label}]({target})"
    path, _, anchor = target.partition("#")
    found = posixpath.normpath(posixpath.join(posixpath.dirname(source), path))
    anchor = f"#{anchor}" if anchor else ""
    inside = PAGES.get(found)
    left_out = f"{found}/".startswith(LEFT_OUT)
    if inside is None and found.startswith("docs/") and not left_out:
        inside = found.partition("/")[2]
    if inside is not None:
        relative = posixpath.relpath(inside, posixpath.dirname(site) or ".")
        return f"{mark}[{label}]({relative}{anchor})"
    if REPOSITORY:
        return f"{mark}[{label}]({REPOSITORY}/blob/main/{found}{anchor})"
    return f"{label} (`{found}`)" if found not in label else label
