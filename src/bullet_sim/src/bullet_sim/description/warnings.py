"""Warnings of the readers: messages with their cause, logged in one line per cause."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any, List

LONGEST = 600  # characters of a message
LISTED = 3  # items that a line names; with more it names the first and counts the others
_LOSS = re.compile(
    r"(world plugins|plugins|plugins of sensors) .*(ignored|left out)"
    r"|links have no mass and are left out, as in Gazebo"
    r"|sensors (have a type that is not known here and )?are left out"
    r"|world files cannot be had"
)
_MISSING = re.compile(r"included models cannot be used|(meshes|heightmaps) .*left out")
_QUOTED = re.compile(r"'[^']*'|\"[^\"]*\"")


class ReadWarning(str):
    """Message about one thing that was ignored or repaired.

    Attributes:
        cause: what many such messages have in common, in the plural: 'meshes are missing';
            empty: messages that differ only in quoted names are grouped.
        item: the thing, in a few words.
    """

    cause = ""
    item = ""

    def __new__(cls, text: str, cause: str = "", item: str = "") -> ReadWarning:
        warning = super().__new__(cls, shortened(text))
        warning.cause, warning.item = shortened(cause), shortened(item)
        return warning


class Warnings(List[ReadWarning]):
    """List of warnings, each text once."""

    def __init__(self) -> None:
        super().__init__()
        self._texts: set[str] = set()

    def add(self, text: str, cause: str = "", item: str = "") -> None:
        """Append a ReadWarning whose text is not in the list yet."""
        warning = ReadWarning(text, cause, item)
        if warning not in self._texts:
            self._texts.add(warning)
            self.append(warning)


def shortened(text: str, length: int = LONGEST) -> str:
    """A text of at most this length: a longer one without its middle."""
    if len(text) <= length:
        return text
    end = length // 4
    return f"{text[: length - end - 5]} ... {text[-end:]}"


def is_loss(warning: str) -> bool:
    """Whether a warning reports that a plugin or sensor of the file is missing, with its topics,
    links without mass, or the world."""
    is_plugin = warning.startswith("plugin '") and warning.endswith("; it is left out")
    return is_plugin or _LOSS.fullmatch(getattr(warning, "cause", "")) is not None


def missing(warnings: Iterable[str]) -> dict[str, list[str]]:
    """Cause -> items of those of some warnings that report missing models, meshes, heightmaps."""
    found: dict[str, list[str]] = {}
    for warning in warnings:
        cause = getattr(warning, "cause", "")
        if _MISSING.fullmatch(cause):
            found.setdefault(cause, []).append(getattr(warning, "item", ""))
    return found


def grouped(warnings: Iterable[str]) -> list[str]:
    """Lines for the log, one per cause, in the order in which the causes occurred.

    Returns:
        The message of a cause that occurred once; of other causes a line with a count.
    """
    groups: dict[str, list[Any]] = {}
    for warning in dict.fromkeys(warnings):
        cause = getattr(warning, "cause", "")
        groups.setdefault(cause or _QUOTED.sub("''", warning), []).append(warning)
    return [_line(group) for group in groups.values()]


def _line(group: list[Any]) -> str:
    first = group[0]
    if len(group) == 1:
        return str(first)
    if not getattr(first, "cause", ""):
        return f"{first} (and {len(group) - 1} more of this kind)"
    items = list(dict.fromkeys(warning.item for warning in group))
    if len(items) == 1:
        return f"{first} (and {len(group) - 1} more of this kind)"
    if len(items) <= LISTED:
        return f"{len(items)} {first.cause}: {', '.join(items)}"
    return f"{len(items)} {first.cause}: {items[0]} and {len(items) - 1} more"
