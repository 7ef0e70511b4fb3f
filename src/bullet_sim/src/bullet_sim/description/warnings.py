"""Warnings about what was read: sentences that know their cause, told one line a cause."""

import re
from collections.abc import Iterable
from typing import Any

LISTED = 3  # items that a line names; of more it names the first and counts the others
_LOSS = re.compile(
    r"(world plugins|plugins|plugins of sensors) .*(ignored|left out)"
    r"|sensors (have a type that is not known here and )?are left out"
)
_QUOTED = re.compile(r"'[^']*'|\"[^\"]*\"")


class ReadWarning(str):
    """One sentence about one thing that was ignored or mended.

    Attributes:
        cause: what many such sentences have in common, in the plural: 'meshes are missing';
            empty: sentences count as alike that differ in quoted names alone.
        item: the thing, in few words.
    """

    cause = ""
    item = ""

    def __new__(cls, text: str, cause: str = "", item: str = "") -> "ReadWarning":
        warning = super().__new__(cls, text)
        warning.cause, warning.item = cause, item
        return warning


def add_warning(warnings: list["ReadWarning"], text: str, cause: str = "", item: str = "") -> None:
    """Append a ReadWarning to a list that does not have this sentence yet."""
    if text not in warnings:
        warnings.append(ReadWarning(text, cause, item))


def is_loss(warning: str) -> bool:
    """Whether a warning says that a plugin or sensor of the file is not there, with its topics."""
    return _LOSS.fullmatch(getattr(warning, "cause", "")) is not None


def grouped(warnings: Iterable[str]) -> list[str]:
    """Lines for the log, one a cause, in the order in which the causes came up.

    Args:
        warnings: ReadWarnings or plain texts.

    Returns:
        List of sentences: a cause that came up once has its own, others are counted.
    """
    groups: dict[str, list[Any]] = {}
    for warning in dict.fromkeys(warnings):
        cause = getattr(warning, "cause", "")
        groups.setdefault(cause or _QUOTED.sub("''", warning), []).append(warning)
    return [_line(alike) for alike in groups.values()]


def _line(alike: list[Any]) -> str:
    first = alike[0]
    if len(alike) == 1:
        return str(first)
    if not getattr(first, "cause", ""):
        return f"{first} (and {len(alike) - 1} more of this kind)"
    items = list(dict.fromkeys(warning.item for warning in alike))
    if len(items) == 1:
        return f"{first} (and {len(alike) - 1} more of this kind)"
    if len(items) <= LISTED:
        return f"{len(items)} {first.cause}: {', '.join(items)}"
    return f"{len(items)} {first.cause}: {items[0]} and {len(items) - 1} more"
