"""XML texts -> elements that know file and line; what TinyXML, Gazebo's reader, takes is taken."""

import codecs
import os
import re
import xml.etree.ElementTree as ElementTree
from xml.parsers import expat

from bullet_sim.description.read_warning import add_warning
from bullet_sim.errors import ModelError

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
_ENDS = (("comment", "<!--", "-->"), ("data", "<![CDATA[", "]]>"), ("other", "<?", ">"))
_ENDS += (("other", "<!", ">"),)
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
        warnings: list that takes ReadWarnings.
        root: its root element.
    """

    def __init__(self, name, warnings=None):
        self.name = name
        self.root = None
        self.warnings = [] if warnings is None else warnings

    def beside(self, uri):
        """A path without a scheme from the folder of the document's file, if it is there."""
        path = os.path.join(os.path.dirname(self.name), uri)
        relative = uri and "://" not in uri and os.path.isabs(path)
        return os.path.normpath(path) if relative and os.path.exists(path) else uri


class Node(ElementTree.Element):
    """An element with the line that it starts in; tags keep their prefix as it is written."""

    document, line = None, 0

    def warn(self, text, cause="", item=""):
        """Note what is ignored or mended here, with file and line."""
        name, line = self.document.name, self.line
        item = f"{item} ({os.path.basename(name)}:{line})"
        add_warning(self.document.warnings, f"{name}, line {line}: {text}", cause, item)


def parse(text, name, warnings=None):
    """Root element (a Node) of an XML text.

    Args:
        text: str or bytes, or a root from this function, which gets the name and the warnings.
        name: of the document, for messages.
        warnings: list that takes the warnings of this document; None: a new one.

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


def _adopted(root, name, warnings):
    document = root.document
    document.name = name
    if warnings is not None:
        warnings += [found for found in document.warnings if found not in warnings]
        document.warnings = warnings
    return root


def decoded(text, document):
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


def _built(text, document):
    """Root of a well-formed text; comments and processing instructions are left out."""
    start = len(text) - len(text.lstrip())
    above = text.count("\n", 0, start)
    builder = ElementTree.TreeBuilder(element_factory=Node)
    parser = expat.ParserCreate("utf-8")  # whatever its declaration says
    parser.buffer_text = True

    depth = 0

    def begin(tag, attributes):
        nonlocal depth
        depth += 1
        line = above + parser.CurrentLineNumber
        if depth > DEEPEST:
            raise ModelError(
                f"{document.name} has more than {DEEPEST} elements within each other at line {line}"
            )
        node = builder.start(tag, attributes)
        node.document, node.line = document, line

    def end(tag):
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
    document.root = builder.close()
    return document.root


def mended(text):
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


def _parts(text):
    """Parts of a text: kind, what it is, where it ends. Takes time in proportion to its length."""
    place, unclosed = 0, {}  # kind -> how many of them had no end
    while place < len(text):
        kind, end = "text", text.find("<", place)
        if end == place:
            kind, end = _part_at(text, place, unclosed)
        end = len(text) if end < 0 else end
        yield kind, text[place:end], end
        place = end


def _part_at(text, place, unclosed):
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


def _mended_tag(tag, empty):
    name = re.match(r"<[^\s/>]+", tag).group()
    attributes = {}
    for key, value in _ATTRIBUTE.findall(tag[len(name) :]):
        value = value[1:-1] if value[0] in "\"'" else value
        value = _BARE.sub("&amp;", value).replace("<", "&lt;").replace('"', "&quot;")
        attributes.setdefault(key, value)
    lines = "\n" * (tag.count("\n") - sum(value.count("\n") for value in attributes.values()))
    inside = "".join(f' {key}="{value}"' for key, value in attributes.items())
    return f"{name}{inside}{lines}{'/' if empty else ''}>"
