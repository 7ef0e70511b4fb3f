"""XML documents whose elements know file and line; values are read as TinyXML reads them.

Numbers, flags and poses of elements; a bad value is a warning, and a default takes its place. What
is used is what Gazebo's reader makes of a text: of a single number the beginning ('1.5m' is 1.5,
'1,5' is 1), of a vector all its numbers or none.
"""

import codecs
import math
import os
import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from typing import TYPE_CHECKING, TypeVar, cast, overload
from xml.etree.ElementTree import Element
from xml.parsers import expat

import numpy as np

from bullet_sim.description.warnings import ReadWarning, add_warning
from bullet_sim.errors import ModelError
from bullet_sim.pose import Pose

T = TypeVar("T")

_MARKS = (
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
    (b"<\0", "utf-16-le"),
    (b"\0<", "utf-16-be"),
)
_DECLARED = re.compile(rb"<\?xml[^>]*?encoding\s*=\s*[\"']([\w.:-]+)[\"']")
_CONTROL = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ufffe\uffff]")
DEEPEST = 100  # elements within each other, as in TinyXML
# The parts of an XML text as TinyXML sees them, by what they begin and end with; quotes of a tag
# may hold < and >, values may lack quotes.
_ENDS = (
    ("comment", "<!--", "-->"),
    ("data", "<![CDATA[", "]]>"),
    ("other", "<?", ">"),
    ("other", "<!", ">"),
)
_TAG = re.compile(r"</?[^\W\d][^\s/>]*(?:\"[^\"]*\"|'[^']*'|[^\"'>])*+>")
_UNCLOSED = 50  # tags that nothing closes; later ones are not looked at
_ATTRIBUTE = re.compile(
    r"(?<![^\s=/\"'<>])([^\s=/\"'<>]++)\s*+=\s*+(\"[^\"]*\"|'[^']*'|[^\s\"'/>]+)"
)
_BARE = re.compile(r"&(?!(?:amp|lt|gt|quot|apos|#[1-9]\d*|#x[1-9a-fA-F][\da-fA-F]*);)")


class Document:
    """A text that elements came from.

    Attributes:
        name: for messages, e.g. the path of its file.
        warnings: gets the file's warnings.
        root: its root element, when it is read.
    """

    root: "Node"

    def __init__(self, name: str, warnings: list[ReadWarning] | None = None) -> None:
        self.name = name
        self.warnings = [] if warnings is None else warnings

    def beside(self, uri: str) -> str:
        """A path without a scheme from the folder of the document's file, if it is there."""
        path = os.path.join(os.path.dirname(self.name), uri)
        relative = uri and "://" not in uri and os.path.isabs(path)
        return os.path.normpath(path) if relative and os.path.exists(path) else uri


class Node(ElementTree.Element):
    """An element with the line that it starts in; tags keep their prefix as it is written."""

    document: Document
    line: int
    if TYPE_CHECKING:  # what is in a Node are Nodes

        def find(self, path: str, namespaces: dict[str, str] | None = None) -> "Node | None": ...
        def findall(  # type: ignore[override]
            self, path: str, namespaces: dict[str, str] | None = None
        ) -> list["Node"]: ...

        def iter(self, tag: str | None = None) -> Iterator["Node"]: ...  # type: ignore[override]
        def __iter__(self) -> Iterator["Node"]: ...
        def __getitem__(self, index: int) -> "Node": ...  # type: ignore[override]

    def warn(self, text: str, cause: str = "", item: str = "") -> None:
        """Note what is ignored or mended here, with file and line."""
        name, line = self.document.name, self.line
        item = f"{item} ({os.path.basename(name)}:{line})"
        add_warning(self.document.warnings, f"{name}, line {line}: {text}", cause, item)


def parse(text: str | bytes | Node, name: str, warnings: list[ReadWarning] | None = None) -> Node:
    """Root element (a Node) of an XML text.

    Args:
        text: or a root from this function, which gets the name and the warnings.
        name: of the document, for messages.
        warnings: gets those of this document; None: a new list.

    Raises:
        ModelError: TinyXML would refuse it, too; names the document, line and column.
    """
    if isinstance(text, Node):
        return _adopted(text, name, warnings)
    document = Document(name, warnings)
    text = decoded(text, document)
    try:
        return _built(text, document)
    except expat.ExpatError as error:
        problem = error
    try:
        root = _built(mended(text), document)
    except expat.ExpatError as error:
        raise ModelError(f"{name} is not well-formed XML: {error}") from error
    add_warning(
        document.warnings,
        f"{name} is not well-formed XML: {problem}; it is read as Gazebo's reader takes it",
        "files are not well-formed XML and are read as Gazebo's reader takes them",
        name,
    )
    return root


def document_root(element: Element) -> Node:
    """Root element of the document that a Node belongs to."""
    return cast(Node, element).document.root


def _adopted(root: Node, name: str, warnings: list[ReadWarning] | None) -> Node:
    document = root.document
    document.name = name
    if warnings is not None:
        warnings += [found for found in document.warnings if found not in warnings]
        document.warnings = warnings
    return root


def decoded(text: str | bytes, document: Document) -> str:
    """The text as str, whatever its encoding; a byte order mark is taken off.

    A declared encoding counts if it fits; what is neither that nor UTF-8 is Latin-1.
    """
    if isinstance(text, str):
        return text.lstrip("\ufeff")
    declared = _DECLARED.search(text[:300])
    names = [name for mark, name in _MARKS if text.startswith(mark)][:1]
    names += [declared.group(1).decode()] if declared else []
    for name in (*names, "utf-8"):
        try:
            return codecs.decode(text, name)
        except (LookupError, ValueError):
            continue
    add_warning(
        document.warnings,
        f"{document.name} has bytes that are not UTF-8; they are read as Latin-1",
        "files have bytes that are not UTF-8; these are read as Latin-1",
        document.name,
    )
    return codecs.decode(text, "latin-1")


def _built(text: str, document: Document) -> Node:
    """Root of a well-formed text; comments and processing instructions are left out."""
    start = len(text) - len(text.lstrip())
    above = text.count("\n", 0, start)
    builder = ElementTree.TreeBuilder(element_factory=Node)
    parser = expat.ParserCreate("utf-8")  # whatever its declaration says
    parser.buffer_text = True

    depth = 0

    def begin(tag: str, attributes: dict[str, str]) -> None:
        nonlocal depth
        depth += 1
        line = above + parser.CurrentLineNumber
        if depth > DEEPEST:
            raise ModelError(
                f"{document.name} has more than {DEEPEST} elements within each other at line {line}"
            )
        node = cast(Node, builder.start(tag, attributes))
        node.document, node.line = document, line

    def end(tag: str) -> None:
        nonlocal depth
        depth -= 1
        builder.end(tag)

    parser.StartElementHandler = begin
    parser.EndElementHandler = end
    parser.CharacterDataHandler = builder.data
    try:
        parser.Parse(text[start:].encode("utf-8", "replace"), True)
    except expat.ExpatError as error:
        where = f"line {above + error.lineno}, column {error.offset}"
        raise expat.ExpatError(f"{expat.ErrorString(error.code)}: {where}") from error
    document.root = cast(Node, builder.close())
    return document.root


def mended(text: str) -> str:
    """A text that TinyXML takes as well-formed XML, line by line.

    Comments and declarations go wherever they are; bare &, < and > in texts and in quotes are
    escaped, values get quotes, of two attributes of one name the first counts, and what follows
    the root element is dropped. Tags that do not match stay: TinyXML refuses them, too.
    """
    out, depth, begun = [], 0, False
    text = _CONTROL.sub("", text)
    for kind, found, place in _parts(text):
        if kind == "tag":
            closes, empty = found.startswith("</"), found.endswith("/>")
            depth += -1 if closes else 0 if empty else 1
            begun = True
            out.append(found if closes else _mended_tag(found, empty))
        elif kind == "data" and depth:
            out.append(found)
        elif found == "<":
            out.append("<" if text[place : place + 1] in "!?" else "")
        elif kind == "text" and depth:
            out.append(_BARE.sub("&amp;", found).replace(">", "&gt;"))
        else:
            out.append("\n" * found.count("\n"))
        if begun and depth <= 0:
            break
    return "".join(out)


def _parts(text: str) -> Iterator[tuple[str, str, int]]:
    """Parts of a text: kind, what it is, where it ends. Takes time in proportion to its length."""
    place = 0
    unclosed: dict[str, int] = {}  # kind -> how many of them had no end
    while place < len(text):
        kind, end = "text", text.find("<", place)
        if end == place:
            kind, end = _part_at(text, place, unclosed)
        end = len(text) if end < 0 else end
        yield kind, text[place:end], end
        place = end


def _part_at(text: str, place: int, unclosed: dict[str, int]) -> tuple[str, int]:
    """Kind and end of what begins with the < at a place; one that nothing closes is a text."""
    for kind, start, stop in _ENDS:
        if text.startswith(start, place):
            end = -1 if start in unclosed else text.find(stop, place + len(start))
            if end >= 0:
                return kind, end + len(stop)
            unclosed[start] = 1
            return "text", place + 1
    if unclosed.get("tag", 0) < _UNCLOSED:
        found = _TAG.match(text, place)
        if found is not None:
            return "tag", found.end()
        if text[place + 1 : place + 2].isalpha():
            unclosed["tag"] = unclosed.get("tag", 0) + 1
    return "text", place + 1


def _mended_tag(tag: str, empty: bool) -> str:
    name = re.split(r"[\s/>]", tag, maxsplit=1)[0]
    attributes: dict[str, str] = {}
    for key, value in _ATTRIBUTE.findall(tag[len(name) :]):
        value = value[1:-1] if value[0] in "\"'" else value
        value = _BARE.sub("&amp;", value).replace("<", "&lt;").replace('"', "&quot;")
        attributes.setdefault(key, value)
    lines = "\n" * (tag.count("\n") - sum(value.count("\n") for value in attributes.values()))
    inside = "".join(f' {key}="{value}"' for key, value in attributes.items())
    return f"{name}{inside}{lines}{'/' if empty else ''}>"


NO_LIMIT = 1e16  # of joints: so much or more means none
_NUMBER = re.compile(
    r"\s*([-+]?(?:inf(?:inity)?|nan|(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?))", re.IGNORECASE
)
_XACRO = "; it looks like xacro: process the file with xacro first"


def floats(text: str, count: int | None, label: str) -> tuple[float, ...]:
    """`count` finite numbers from a text such as '0 0 1.5' (count None: any number).

    Raises:
        ModelError: names `label` and the text.
    """
    values, rest = leading_numbers(text)
    if rest or not _is_usable(values, count):
        raise ModelError(_sentence(text, label, count))
    return values


def number(text: str, label: str) -> float:
    """One finite number; raises as `floats` does."""
    return floats(text, 1, label)[0]


def leading_numbers(text: str | None, most: int | None = None) -> tuple[tuple[float, ...], str]:
    """(the numbers that a text begins with, at most so many; what follows them)."""
    values: list[float] = []
    place = 0
    text = text or ""
    while most is None or len(values) < most:
        found = _NUMBER.match(text, place)
        if found is None:
            break
        values.append(float(found.group(1)))
        place = found.end()
    return tuple(values), text[place:].strip()


def _is_usable(values: tuple[float, ...], count: int | None) -> bool:
    return (count is None or len(values) == count) and all(map(math.isfinite, values))


def _sentence(text: str | None, label: str, count: int | None) -> str:
    text = (text or "").strip()
    wanted = "finite numbers" if count is None else f"{count} finite number(s)"
    return f"{label} is '{text}', must be {wanted}{_XACRO if '$' in text else ''}"


def mended_floats(
    node: Element | None, text: str | None, count: int, label: str, default: T
) -> tuple[float, ...] | T:
    """`count` finite numbers, or with a warning the first of more, or the default.

    Args:
        node: takes the warning.
        text: as in the file.
        count: how many.
        label: for the message.
        default: what is used where there are too few; any value.
    """
    values, rest = leading_numbers(text, count)
    if not _is_usable(values, count):
        warn_replaced(node, label, text, _sentence(text, label, count), default)
        return default
    if rest:
        warn_replaced(node, label, text, _sentence(text, label, count), values)
    return values


def warn_replaced(
    node: Element | None, label: str, text: str | None, sentence: str, used: object
) -> None:
    """Say that a value is not usable and what is used instead.

    Args:
        node: takes the warning.
        label: the value's name.
        text: the value as it is written.
        sentence: what is wrong and what would be valid.
        used: number, tuple, text or None for nothing (and a tuple of it).

    Raises:
        ModelError: the element belongs to no document that could note it.
    """
    if not isinstance(node, Node):
        raise ModelError(sentence)
    used = None if used == (None,) else used
    if isinstance(used, (tuple, float, int)) and not isinstance(used, bool):
        used = " ".join(f"{value:g}" for value in np.atleast_1d(used))
    node.warn(
        f"{sentence}; {'nothing' if used is None else used} is used",
        "values are not usable as they are written and are replaced",
        f"{label} '{(text or '').strip()}'",
    )


@overload
def child_text(element: Element, path: str) -> str | None: ...
@overload
def child_text(element: Element, path: str, default: T) -> str | T: ...
def child_text(element: Element, path: str, default: object = None) -> object:
    """Stripped text of a sub-element, or the default where it is missing or empty."""
    found = element.find(path)
    text = found.text.strip() if found is not None and found.text else ""
    return text or default


def child_number(element: Element, path: str, label: str, default: T) -> float | T:
    """Number in a sub-element, or the default where it is missing or, with a warning, none."""
    text = child_text(element, path)
    if text is None:
        return default
    values = mended_floats(element.find(path), text, 1, f"{label} <{path}>", default)
    return values[0] if isinstance(values, tuple) else values


def child_floats(element: Element, path: str, count: int, label: str, default: T) -> T:
    """As child_number: a tuple of `count` numbers."""
    text = child_text(element, path)
    if text is None:
        return default
    values = mended_floats(element.find(path), text, count, f"{label} <{path}>", default)
    return cast(T, values)


def child_whole(element: Element, path: str, label: str, default: int, least: int = 1) -> int:
    """As child_number: an int of at least `least`; a fraction is cut off."""
    value = child_number(element, path, label, default)
    if value >= least:
        return int(value)
    sentence = f"{label} <{path}> is {value:g}, must be at least {least}"
    warn_replaced(element.find(path), f"{label} <{path}>", f"{value:g}", sentence, default)
    return default


def child_bound(element: Element, path: str, label: str) -> float | None:
    """Limit in a sub-element: a number, or None for one that is missing or infinite."""
    return _bound(element.find(path), child_text(element, path), f"{label} <{path}>")


def child_flag(element: Element, path: str, label: str, default: bool) -> bool:
    """Truth in a sub-element, or the default where it is missing or, with a warning, no word."""
    text = child_text(element, path)
    if text is None:
        return default
    if is_true(text) or text.lower() in ("false", "0", "no", "off"):
        return is_true(text)
    sentence = f"{label} <{path}> is '{text}', must be true or false"
    warn_replaced(element.find(path), f"{label} <{path}>", text, sentence, str(default).lower())
    return default


def number_of(element: Element, name: str, label: str, default: T) -> float | T:
    """Number in an attribute, or the default where it is missing or, with a warning, none."""
    text = element.get(name)
    if text is None:
        return default
    values = mended_floats(element, text, 1, f"{label} {name}", default)
    return values[0] if isinstance(values, tuple) else values


def floats_of(element: Element, name: str, count: int, label: str, default: T) -> T:
    """As number_of: a tuple of `count` numbers."""
    text = element.get(name)
    if text is None:
        return default
    return cast(T, mended_floats(element, text, count, f"{label} {name}", default))


def bound_of(element: Element, name: str, label: str, default: float | None = None) -> float | None:
    """Limit in an attribute: a number, the default where it is missing, None if infinite."""
    text = element.get(name)
    return default if text is None else _bound(element, text, f"{label} {name}")


def _bound(node: Element | None, text: str | None, label: str) -> float | None:
    values, rest = leading_numbers(text, 1)
    if text is None or (values and not rest and abs(values[0]) >= NO_LIMIT):
        return None
    usable = mended_floats(node, text, 1, label, None)
    return None if usable is None or abs(usable[0]) >= NO_LIMIT else usable[0]


def is_true(text: object) -> bool:
    """Whether a text means true (true, 1, yes)."""
    return str(text).strip().lower() in ("true", "1", "yes", "on")


def urdf_origin(element: Element, label: str) -> Pose:
    """Pose of an <origin xyz rpy> child; identity where there is none."""
    origin = element.find("origin")
    if origin is None:
        return Pose()
    zero = (0.0, 0.0, 0.0)
    return Pose.from_xyz_rpy(
        floats_of(origin, "xyz", 3, f"{label} origin", zero),
        floats_of(origin, "rpy", 3, f"{label} origin", zero),
    )


def sdf_pose(element: Element, label: str) -> Pose:
    """Pose of a <pose> child (x y z roll pitch yaw); identity where there is none.

    As Gazebo does, of fewer than six numbers only the first three count, as a position.
    """
    text = child_text(element, "pose")
    if text is None:
        return Pose()
    values, rest = leading_numbers(text, 6)
    label = f"{label} <pose>"
    if not _is_usable(values, 6) or rest:
        if not _is_usable(values, 6):
            values = (values[:3] if _is_usable(values[:3], 3) else (0.0,) * 3) + (0.0,) * 3
        warn_replaced(element.find("pose"), label, text, _sentence(text, label, 6), values)
    return Pose.from_xyz_rpy(values[:3], values[3:])
