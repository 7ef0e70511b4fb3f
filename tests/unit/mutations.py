"""Shipped files changed at random: elements and keys moved, values that nobody means, bytes."""

import copy
import random
import re
import xml.etree.ElementTree as ElementTree

import yaml

NUMBERS = ("nan", "inf", "-inf", "1e308", "-1e308", "1e-320", "1e9", "-1", "0", "99999999999999999")
TEXTS = ("", " ", "text", "1.5m", "90deg", "1,5", "0x10", "../../etc/passwd", "\u00fc\U0001f697")
TEXTS += ("a" * 3000, "9" * 400, "/", "a/b c", "${x}", "$(find x)", "%s%n{}", "1 2 3 4 5 6 7 8 9")
FILES = ("package://none/x", "file:///dev/zero", "/proc/self/mem", "model://", "http://localhost/")
PLAIN = (None, True, "", 0, -1, 2**70, -(2**70), 1e308, float("nan"), float("inf"), "1e6", "nan")
ODD = (
    [],
    {},
    [[]],
    {"a": 1},
    [None],
    {1: 2},
    [1, "a", None],
    {None: None},
    {True: [{}]},
    "a" * 999,
)
NOT_READ = (ElementTree.ParseError, IndexError, ValueError, yaml.YAMLError)
BYTES = (b"\0", b"\t", b"\xff", b"\xef\xbb\xbf", b"\xff\xfe", b"<", b">", b"&", b'"', b"-->", b"\r")
BYTES += (
    b"<![CDATA[",
    b"&#0;",
    b"&x;",
    b"<!--",
    b"\xc3",
    b"\xed\xa0\x80",
    b"{",
    b"[",
    b": ",
    b"- ",
)
BYTES += (b"*a", b"&a ", b"!!python/object/apply:os.system ['true']\n", b"!!binary ", b"%", b"? ")
BYTES += (b"\n---\n", b"'", b"!!set ", b"<<: *a\n", b"!degrees ", b"\x0b", b"\xc2\x85")


def bytes_changed(data, rng):
    """Bytes cut off, taken out, put in, doubled, or in another encoding."""
    kind, place = rng.randrange(6), rng.randrange(len(data) + 1)
    if kind == 0:
        return data[:place]
    if kind == 1:
        return data[:place] + data[place + rng.choice((1, 2, 10, 100)) :]
    if kind == 2:
        return data[:place] + rng.choice(BYTES) + data[place:]
    if kind == 3:
        end = place + rng.randrange(200)
        return data[:end] + data[place:]
    if kind == 4:
        return data[:place] + bytes([rng.randrange(256)]) + data[place + 1 :]
    text = data.decode("utf-8", "replace")
    return text.encode(rng.choice(("utf-16", "utf-16-le", "utf-32", "utf-8-sig", "cp500")))


def _value(text, rng):
    """Another text in place of a value: one of its words, or all of it."""
    word = rng.choice(rng.choice((NUMBERS, NUMBERS, TEXTS, FILES)))
    words = re.findall(r"\S+", text)
    if len(words) < 2 or rng.random() < 0.3:
        return rng.choice((word, text + word, "-" + text, text * 2, text + "e9"))
    words[rng.randrange(len(words))] = word
    return " ".join(words)


def xml_changed(data, rng):
    """One change of an XML file: of an element, an attribute, a text."""
    root = ElementTree.fromstring(data)
    parents = {child: parent for parent in root.iter() for child in parent}
    nodes = list(parents)
    node, other = rng.choice(nodes), rng.choice(nodes)
    parent, kind = parents[node], rng.randrange(10)
    if kind == 0:
        parent.remove(node)
    elif kind == 1:
        parent.insert(rng.randrange(len(parent) + 1), copy.deepcopy(node))
    elif kind == 2:
        parent[list(parent).index(node)] = copy.deepcopy(other)
    elif kind == 3:
        other.append(copy.deepcopy(node))
    elif kind == 4:
        node.tag = rng.choice((other.tag, "none", node.tag + "x"))
    else:
        owners = [item for item in nodes if item.attrib or (item.text or "").strip()]
        node = rng.choice(owners)
        keys = [*node.attrib, *([None] if (node.text or "").strip() else [])]
        key = rng.choice(keys)
        if key is None:
            node.text = _value(node.text, rng)
        elif kind == 5:
            del node.attrib[key]
        else:
            same = [item.get(key) for item in nodes if key in item.attrib]
            old = node.get(key)
            node.set(key, rng.choice(same) if kind == 6 else _value(old, rng))
    return ElementTree.tostring(root, "utf-8")


def _holders(value):
    """All lists and dicts within a value, itself too, as (holder, key) pairs of their items."""
    pairs = []
    items = value.items() if isinstance(value, dict) else enumerate(value)
    for key, item in items:
        pairs.append((value, key))
        if isinstance(item, (dict, list)):
            pairs += _holders(item)
    return pairs


def yaml_value_changed(value, rng):
    """One change of what a YAML file holds: an item dropped, renamed, swapped, or of another kind.

    Returns:
        A changed copy.
    """
    value = copy.deepcopy(value)
    if not isinstance(value, (dict, list)) or not value:
        return rng.choice(PLAIN + ODD)
    pairs = _holders(value)
    (holder, key), (other, there) = rng.choice(pairs), rng.choice(pairs)
    kind = rng.randrange(8)
    if kind == 0:
        del holder[key]
    elif kind == 1:
        holder[key] = copy.deepcopy(other[there])
    elif kind == 2 and isinstance(holder, dict):
        holder[rng.choice(("", "x", 1, None, True, key))] = holder.pop(key)
    elif kind == 3:
        holder[key] = [holder[key]] if rng.random() < 0.5 else {"x": holder[key]}
    elif kind == 4:
        holder[key] = copy.deepcopy(rng.choice(ODD))
    elif kind == 5 and isinstance(holder, list):
        holder.append(copy.deepcopy(holder[key]))
    elif kind == 6 and isinstance(holder[key], (int, float)):
        holder[key] = rng.choice(
            (-holder[key], holder[key] * 10**6, str(holder[key]), f"{holder[key]}m")
        )
    else:
        holder[key] = copy.deepcopy(rng.choice(PLAIN))
    return value


def yaml_changed(data, rng):
    """One change of a YAML file."""
    value = yaml_value_changed(yaml.safe_load(data), rng)
    return yaml.dump(value, allow_unicode=True).encode()


def mutations(data, change, count, seed):
    """Changed copies of a file's bytes: three of four by `change`, once or twice, else as bytes.

    Yields:
        (number, bytes).
    """
    for number in range(count):
        rng = random.Random(f"{seed}/{number}")
        if rng.random() < 0.25:
            yield number, bytes_changed(data, rng)
            continue
        try:
            changed = change(data, rng)
            if rng.random() < 0.3:
                changed = change(changed, rng)
        except NOT_READ:  # nothing is left of it, or it was not well-formed before
            changed = bytes_changed(data, rng)
        yield number, changed
