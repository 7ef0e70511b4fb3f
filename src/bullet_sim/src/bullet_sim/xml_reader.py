"""XML documents whose elements know file and line; values are read as TinyXML reads them.

Numbers, flags and poses of elements; a bad value causes a warning and is replaced by a default.
Texts are read as Gazebo's reader does: of a single number the start counts ('1.5m' is 1.5, '1,5'
is 1), of a vector all its numbers or none.
"""

from __future__ import annotations

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

from bullet_sim.description.warnings import Warnings
from bullet_sim.errors import ModelError
from bullet_sim.pose import Pose

T = TypeVar("T")

_BYTE_ORDER_MARKS = (
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
MAX_DEPTH = 100  # of nested elements, as in TinyXML
# The parts of an XML text as TinyXML reads them: type, start, end. Quotes in a tag may contain <
# and >, values may lack quotes.
_DELIMITERS = (
    ("comment", "<!--", "-->"),
    ("data", "<![CDATA[", "]]>"),
    ("other", "<?", ">"),
    ("other", "<!", ">"),
)
_TAG = re.compile(r"</?[^\W\d][^\s/>]*(?:\"[^\"]*\"|'[^']*'|[^\"'>])*>")
_MAX_UNCLOSED = 50  # tags without an end; later ones are not searched for it
_ATTRIBUTE = re.compile(r"(?<![^\s=/\"'<>])([^\s=/\"'<>]+)\s*=\s*(\"[^\"]*\"|'[^']*'|[^\s\"'/>]+)")
_UNESCAPED = re.compile(r"&(?!(?:amp|lt|gt|quot|apos|#[1-9]\d*|#x[1-9a-fA-F][\da-fA-F]*);)")


class Document:
    """A text that elements were read from.

    Attributes:
        name: for messages, e.g. the path of its file.
        root: its root element, set when it has been read.
    """

    root: Node

    def __init__(self, name: str, warnings: Warnings | None = None) -> None:
        self.name = name
        self.warnings = Warnings() if warnings is None else warnings

    def resolve_relative(self, uri: str) -> str:
        """A path relative to the document's file if that file exists, else the URI as it is."""
        path = os.path.join(os.path.dirname(self.name), uri)
        is_relative = uri and "://" not in uri and os.path.isabs(path)
        return os.path.normpath(path) if is_relative and os.path.exists(path) else uri


class Node(ElementTree.Element):
    """An element with its document and first line; tags keep their prefix as written."""

    document: Document
    line: int
    if TYPE_CHECKING:  # the children of a Node are Nodes

        def find(self, path: str, namespaces: dict[str, str] | None = None) -> Node | None: ...
        def findall(  # type: ignore[override]
            self, path: str, namespaces: dict[str, str] | None = None
        ) -> list[Node]: ...

        def iter(self, tag: str | None = None) -> Iterator[Node]: ...  # type: ignore[override]
        def __iter__(self) -> Iterator[Node]: ...
        def __getitem__(self, index: int) -> Node: ...  # type: ignore[override]

    def warn(self, text: str, cause: str = "", item: str = "") -> None:
        """Add a warning about what is ignored or repaired, with file and line."""
        name, line = self.document.name, self.line
        item = f"{item} ({os.path.basename(name)}:{line})"
        self.document.warnings.add(f"{name}, line {line}: {text}", cause, item)


def parse(text: str | bytes | Node, name: str, warnings: Warnings | None = None) -> Node:
    """Root element (a Node) of an XML text.

    Args:
        text: of the document; or a root from this function, which gets the name and the warnings.
        warnings: list for those of this document; None: a new one.

    Raises:
        ModelError: TinyXML would refuse the text, too; names the document, line and column.
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
        root = _built(repaired(text), document)
    except expat.ExpatError as error:
        raise ModelError(f"{name} is not well-formed XML: {error}") from error
    document.warnings.add(
        f"{name} is not well-formed XML: {problem}; it is read as Gazebo's reader does",
        "files are not well-formed XML and are read as Gazebo's reader does",
        name,
    )
    return root


def document_root(element: Element) -> Node:
    """Root element of the document that a Node belongs to."""
    return cast(Node, element).document.root


def add_child(parent: Node, tag: str, text: str) -> Node:
    """Append an element with a text to a Node; it counts as on the Node's line."""
    child = Node(tag)
    child.document, child.line, child.text = parent.document, parent.line, text
    parent.append(child)
    return child


def copied(node: Node) -> Node:
    """A copy of an element and all below it, with the same document and lines."""
    copy = Node(node.tag, dict(node.attrib))
    copy.document, copy.line = node.document, node.line
    copy.text, copy.tail = node.text, node.tail
    copy.extend(copied(child) for child in node)
    return copy


def _adopted(root: Node, name: str, warnings: Warnings | None) -> Node:
    document = root.document
    document.name = name
    if warnings is not None:
        for warning in document.warnings:
            warnings.add(warning, warning.cause, warning.item)
        document.warnings = warnings
    return root


def decoded(text: str | bytes, document: Document) -> str:
    """The text as str, whatever its encoding; a byte order mark is removed.

    A declared encoding is used if it fits, else UTF-8, else Latin-1.
    """
    if isinstance(text, str):
        return text.lstrip("\ufeff")
    declared = _DECLARED.search(text[:300])
    names = [name for mark, name in _BYTE_ORDER_MARKS if text.startswith(mark)][:1]
    names += [declared.group(1).decode()] if declared else []
    for name in (*names, "utf-8"):
        try:
            return text.decode(name)  # takes encodings of texts alone
        except (LookupError, ValueError):
            continue
    document.warnings.add(
        f"{document.name} has bytes that are not UTF-8; they are read as Latin-1",
        "files have bytes that are not UTF-8; these are read as Latin-1",
        document.name,
    )
    return codecs.decode(text, "latin-1")


def _built(text: str, document: Document) -> Node:
    """Root of a well-formed text; comments and processing instructions are skipped."""
    start = len(text) - len(text.lstrip())
    above = text.count("\n", 0, start)
    builder = ElementTree.TreeBuilder(element_factory=Node)
    parser = expat.ParserCreate("utf-8")  # whatever its declaration says
    parser.buffer_text = True

    depth = 0

    def start_element(tag: str, attributes: dict[str, str]) -> None:
        nonlocal depth
        depth += 1
        line = above + parser.CurrentLineNumber
        if depth > MAX_DEPTH:
            raise ModelError(
                f"{document.name} has more than {MAX_DEPTH} nested elements at line {line}"
            )
        node = cast(Node, builder.start(tag, attributes))
        node.document, node.line = document, line

    def end_element(tag: str) -> None:
        nonlocal depth
        depth -= 1
        builder.end(tag)

    parser.StartElementHandler = start_element
    parser.EndElementHandler = end_element
    parser.CharacterDataHandler = builder.data
    try:
        parser.Parse(text[start:].encode("utf-8", "replace"), True)
    except expat.ExpatError as error:
        where = f"line {above + error.lineno}, column {error.offset}"
        raise expat.ExpatError(f"{expat.ErrorString(error.code)}: {where}") from error
    document.root = cast(Node, builder.close())
    return document.root


def repaired(text: str) -> str:
    """A text that TinyXML accepts as well-formed XML, line by line.

    Comments and declarations are removed; unescaped &, < and > in texts and in quotes are
    escaped, values get quotes, of two attributes with one name the first counts, and text after
    the root element is dropped. Tags that do not match stay: TinyXML refuses them, too.
    """
    out, depth, started = [], 0, False
    text = _CONTROL.sub("", text)
    for part_type, part, end in _parts(text):
        if part_type == "tag":
            closes, empty = part.startswith("</"), part.endswith("/>")
            depth += -1 if closes else 0 if empty else 1
            started = True
            out.append(part if closes else _repaired_tag(part, empty))
        elif part_type == "data" and depth:
            out.append(part)
        elif part == "<":
            out.append("<" if text[end : end + 1] in "!?" else "")
        elif part_type == "text" and depth:
            out.append(_UNESCAPED.sub("&amp;", part).replace(">", "&gt;"))
        else:
            out.append("\n" * part.count("\n"))
        if started and depth <= 0:
            break
    return "".join(out)


def _parts(text: str) -> Iterator[tuple[str, str, int]]:
    """Parts of a text: (type, text, end position), in time proportional to its length."""
    position = 0
    unclosed: dict[str, int] = {}  # type -> how many of them had no end
    while position < len(text):
        part_type, end = "text", text.find("<", position)
        if end == position:
            part_type, end = _part_at(text, position, unclosed)
        end = len(text) if end < 0 else end
        yield part_type, text[position:end], end
        position = end


def _part_at(text: str, position: int, unclosed: dict[str, int]) -> tuple[str, int]:
    """Type and end of the part at a position with a <; one that nothing closes is a text."""
    for part_type, start, stop in _DELIMITERS:
        if text.startswith(start, position):
            end = -1 if start in unclosed else text.find(stop, position + len(start))
            if end >= 0:
                return part_type, end + len(stop)
            unclosed[start] = 1
            return "text", position + 1
    if unclosed.get("tag", 0) < _MAX_UNCLOSED:
        match = _TAG.match(text, position)
        if match is not None:
            return "tag", match.end()
        if text[position + 1 : position + 2].isalpha():
            unclosed["tag"] = unclosed.get("tag", 0) + 1
    return "text", position + 1


def _repaired_tag(tag: str, empty: bool) -> str:
    name = re.split(r"[\s/>]", tag, maxsplit=1)[0]
    attributes: dict[str, str] = {}
    for key, value in _ATTRIBUTE.findall(tag[len(name) :]):
        value = value[1:-1] if value[0] in "\"'" else value
        value = _UNESCAPED.sub("&amp;", value).replace("<", "&lt;").replace('"', "&quot;")
        attributes.setdefault(key, value)
    lines = "\n" * (tag.count("\n") - sum(value.count("\n") for value in attributes.values()))
    inside = "".join(f' {key}="{value}"' for key, value in attributes.items())
    return f"{name}{inside}{lines}{'/' if empty else ''}>"


NO_LIMIT = 1e16  # [rad, m] joint limits of at least this mean none
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
        raise ModelError(_message(text, label, count))
    return values


def number(text: str, label: str) -> float:
    """One finite number; raises as `floats` does."""
    return floats(text, 1, label)[0]


def leading_numbers(
    text: str | None, max_count: int | None = None
) -> tuple[tuple[float, ...], str]:
    """(the numbers at the start of a text, at most max_count; the text after them)."""
    values: list[float] = []
    position = 0
    text = text or ""
    while max_count is None or len(values) < max_count:
        match = _NUMBER.match(text, position)
        if match is None:
            break
        values.append(float(match.group(1)))
        position = match.end()
    return tuple(values), text[position:].strip()


def _is_usable(values: tuple[float, ...], count: int | None) -> bool:
    return (count is None or len(values) == count) and all(map(math.isfinite, values))


def _message(text: str | None, label: str, count: int | None) -> str:
    text = (text or "").strip()
    expected = "finite numbers" if count is None else f"{count} finite number(s)"
    return f"{label} is '{text}', must be {expected}{_XACRO if '$' in text else ''}"


def repaired_floats(
    node: Element | None, text: str | None, count: int, label: str, default: T
) -> tuple[float, ...] | T:
    """`count` finite numbers; with a warning the first of more, or the default.

    Args:
        node: takes the warning.
        default: any value; used where there are too few.
    """
    values, rest = leading_numbers(text, count)
    if not _is_usable(values, count):
        warn_replaced(node, label, text, _message(text, label, count), default)
        return default
    if rest:
        warn_replaced(node, label, text, _message(text, label, count), values)
    return values


def warn_replaced(
    node: Element | None, label: str, text: str | None, message: str, used: object
) -> None:
    """Warn that a value is not usable, and what is used instead.

    Args:
        message: what is wrong and what would be valid.
        used: number, tuple, text or None for nothing (and a tuple of it).

    Raises:
        ModelError: the element belongs to no document that could take the warning.
    """
    if not isinstance(node, Node):
        raise ModelError(message)
    used = None if used == (None,) else used
    if isinstance(used, (tuple, float, int)) and not isinstance(used, bool):
        used = " ".join(f"{value:g}" for value in np.atleast_1d(used))
    node.warn(
        f"{message}; {'nothing' if used is None else used} is used",
        "values are not usable as they are written and are replaced",
        f"{label} '{(text or '').strip()}'",
    )


def first_child(element: Element, path: str) -> Element | None:
    """The first element of each name on a path, as sdformat's GetElement; None: there is none."""
    found: Element | None = element
    for tag in path.split("/"):
        found = None if found is None else found.find(tag)
    return found


@overload
def child_text(element: Element, path: str) -> str | None: ...
@overload
def child_text(element: Element, path: str, default: T) -> str | T: ...
def child_text(element: Element, path: str, default: object = None) -> object:
    """Stripped text of a sub-element, or the default where it is missing or empty."""
    child = first_child(element, path)
    text = child.text.strip() if child is not None and child.text else ""
    return text or default


def _value(element: Element, path: str, label: str) -> tuple[Element | None, str | None, str]:
    """What has a value and takes its warning, its text and its name in messages.

    Args:
        path: of a sub-element, whose text it is, or @ and the name of an attribute.
    """
    if path.startswith("@"):
        return element, element.get(path[1:]), f"{label} {path[1:]}"
    return first_child(element, path), child_text(element, path), f"{label} <{path}>"


def child_number(element: Element, path: str, label: str, default: T) -> float | T:
    """Number in a sub-element or an attribute, see _value(), or the default where it is missing or,
    with a warning, no number."""
    node, text, label = _value(element, path, label)
    if text is None:
        return default
    values = repaired_floats(node, text, 1, label, default)
    return values[0] if isinstance(values, tuple) else values


def child_floats(element: Element, path: str, count: int, label: str, default: T) -> T:
    """As child_number: a tuple of `count` numbers."""
    node, text, label = _value(element, path, label)
    return default if text is None else cast(T, repaired_floats(node, text, count, label, default))


def child_whole(element: Element, path: str, label: str, default: int) -> int:
    """As child_number: an int of at least 1; a fraction is truncated."""
    value = child_number(element, path, label, default)
    if value >= 1:
        return int(value)
    message = f"{label} <{path}> is {value:g}, must be at least 1"
    warn_replaced(element.find(path), f"{label} <{path}>", f"{value:g}", message, default)
    return default


def child_bound(
    element: Element, path: str, label: str, default: float | None = None
) -> float | None:
    """As child_number, of a limit: None for one that is infinite or no number."""
    node, text, label = _value(element, path, label)
    if text is None:
        return default
    values, rest = leading_numbers(text, 1)
    if values and not rest and abs(values[0]) >= NO_LIMIT:
        return None
    usable = repaired_floats(node, text, 1, label, None)
    return None if usable is None or abs(usable[0]) >= NO_LIMIT else usable[0]


def child_flag(element: Element, path: str, label: str, default: bool) -> bool:
    """Boolean in a sub-element, or the default where it is missing or, with a warning, none."""
    text = child_text(element, path)
    if text is None:
        return default
    if is_true(text) or text.lower() in ("false", "0", "no", "off"):
        return is_true(text)
    message = f"{label} <{path}> is '{text}', must be true or false"
    warn_replaced(element.find(path), f"{label} <{path}>", text, message, str(default).lower())
    return default


def is_true(text: object) -> bool:
    """Whether a text means true (true, 1, yes, on)."""
    return str(text).strip().lower() in ("true", "1", "yes", "on")


def urdf_origin(element: Element, label: str) -> Pose:
    """Pose of an <origin xyz rpy> child; identity where there is none."""
    origin = element.find("origin")
    if origin is None:
        return Pose()
    zero = (0.0, 0.0, 0.0)
    return Pose.from_xyz_rpy(
        child_floats(origin, "@xyz", 3, f"{label} origin", zero),
        child_floats(origin, "@rpy", 3, f"{label} origin", zero),
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
        warn_replaced(element.find("pose"), label, text, _message(text, label, 6), values)
    return Pose.from_xyz_rpy(values[:3], values[3:])
