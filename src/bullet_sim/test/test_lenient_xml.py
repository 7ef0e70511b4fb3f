"""XML texts as TinyXML takes them: encodings, declarations, odd signs; and what it refuses."""

import pytest
from bullet_sim.description.warnings import Warnings
from bullet_sim.errors import ModelError
from bullet_sim.xml_reader import Document, Node, parse, repaired

GOOD = '<a x="1"><b>text</b></a>'

# name, text, what the root's <b> says, whether it is said
TAKEN = [
    ("plain", GOOD, "text", False),
    ("bytes", GOOD.encode(), "text", False),
    ("declaration", '<?xml version="1.0" encoding="UTF-8"?>\n' + GOOD, "text", False),
    (
        "unknown encoding",
        b'<?xml version="1.0" encoding="x-mine"?><a><b>gr\xc3\xbcn</b></a>',
        "grün",
        0,
    ),
    (
        "utf8 without dash",
        b'<?xml version="1.0" encoding="utf8"?><a><b>gr\xc3\xbcn</b></a>',
        "grün",
        0,
    ),
    (
        "wrongly ascii",
        b'<?xml version="1.0" encoding="ascii"?><a><b>gr\xc3\xbcn</b></a>',
        "grün",
        0,
    ),
    (
        "Latin-1",
        '<?xml version="1.0" encoding="latin-1"?><a><b>grün</b></a>'.encode("latin-1"),
        "grün",
        0,
    ),
    (
        "Latin-1 said to be UTF-8",
        '<?xml version="1.0" encoding="utf-8"?><a><b>grün</b></a>'.encode("latin-1"),
        "grün",
        True,
    ),
    ("Latin-1 unsaid", "<a><b>grün</b></a>".encode("latin-1"), "grün", True),
    ("UTF-8 with a mark", b"\xef\xbb\xbf" + GOOD.encode(), "text", False),
    ("str with a mark", "\ufeff" + GOOD, "text", False),
    ("mark and declaration", "\ufeff<?xml version='1.0'?>" + GOOD, "text", False),
    ("UTF-16 with a mark", "<a><b>grün</b></a>".encode("utf-16"), "grün", False),
    (
        "UTF-16 that says so",
        '<?xml version="1.0" encoding="utf-16"?><a><b>grün</b></a>'.encode("utf-16"),
        "grün",
        0,
    ),
    ("UTF-16 without a mark", "<a><b>grün</b></a>".encode("utf-16-le"), "grün", False),
    ("UTF-16 big endian", "<a><b>grün</b></a>".encode("utf-16-be"), "grün", False),
    ("Windows line ends", GOOD.replace("><", ">\r\n<"), "text", False),
    ("space before the declaration", '\n \t<?xml version="1.0"?>' + GOOD, "text", False),
    ("comment before the declaration", '<!-- mine --><?xml version="1.0"?>' + GOOD, "text", True),
    ("two declarations", '<?xml version="1.0"?>\n<?xml version="1.0"?>' + GOOD, "text", True),
    ("dashes in a comment", "<a><!-- a -- b --- --><b>text</b></a>", "text", True),
    ("tags in a comment", "<a><!-- a -- <b>no</b> --><b>text</b></a>", "text", True),
    ("bare ampersand", "<a><b>salt & pepper</b></a>", "salt & pepper", True),
    ("entities beside a bare one", "<a><b>&lt;a&gt; &amp; b & c</b></a>", "<a> & b & c", True),
    ("unknown entity", "<a><b>a&nbsp;b</b></a>", "a&nbsp;b", True),
    ("control characters", "<a><b>te\x01xt</b>\x00</a>", "text", True),
    ("prefix without a namespace", "<a><sensor:camera/><b>text</b></a>", "text", False),
    (
        "namespace declared",
        '<a xmlns:xacro="http://www.ros.org/wiki/xacro"><b>text</b></a>',
        "text",
        0,
    ),
    ("values without quotes", "<a x=1><b y=2>text</b></a>", "text", True),
    ("no space between values", '<a x="1"y="2"><b>text</b></a>', "text", True),
    ("one value twice", '<a x="1" x="2"><b>text</b></a>', "text", True),
    ("angles in a value", '<a x="1<2>3"><b>text</b></a>', "text", True),
    ("junk behind the root", GOOD + "junk & more", "text", True),
    ("tags behind the root", GOOD + "<c></d>", "text", True),
    ("junk before the root", "junk" + GOOD, "text", True),
    ("data section", "<a x=1><b><![CDATA[1 < 2 & 3]]></b></a>", "1 < 2 & 3", True),
    ("end of a data section", "<a><b>x]]>y</b></a>", "x]]>y", True),
    ("document type", '<!DOCTYPE a SYSTEM "a.dtd"><a x=1><b>text</b></a>', "text", True),
]


@pytest.mark.parametrize(
    "text, expected, said", [row[1:] for row in TAKEN], ids=[r[0] for r in TAKEN]
)
def test_taken(text, expected, said):
    warnings = Warnings()
    root = parse(text, "my.world", warnings)
    assert root.tag == "a" and root.find("b").text == expected
    assert len(warnings) == bool(said)
    assert all("my.world" in warning for warning in warnings)


def test_values_are_kept():
    root = parse('<a x=1 y = \'it"s\' z="<&amp;& >"><b c=d/></a>', "x")
    assert root.attrib == {"x": "1", "y": 'it"s', "z": "<&& >"}
    assert root.find("b").get("c") == "d"
    assert parse('<a x="1" x="2"/>', "x").get("x") == "1"


REFUSED = {
    "nothing": ("", "no element found: line 1"),
    "no tag": ("just text", "line 1"),
    "tags that do not match": ("<a>\n<b>\n</a>", "mismatched tag: line 3"),
    "no end": ("<a>\n<b/>\n", "no element found: line 3"),
    "a tag without an end": ("<a>\n<b </a>", "line 2"),
    "a comment without an end": ("<a>\n<!-- <b/></a>", "line 2"),
}


@pytest.mark.parametrize("text, words", REFUSED.values(), ids=REFUSED)
def test_refused_with_name_and_line(text, words):
    with pytest.raises(ModelError) as error:
        parse(text, "my.world")
    assert "my.world is not well-formed XML" in str(error.value) and words in str(error.value)


@pytest.mark.parametrize("broken", ["", "<a x=1>"], ids=["as it is", "repaired"])
def test_lines(broken):
    text = '\n\n<?xml version="1.0"?>\n<!-- two\nlines -->\n' + (broken or "<a>")
    text += '\n<b\n  c="1"\n  d="x\ny"/>\n<e/></a>'
    root = parse(text, "x")
    assert (root.line, root.find("b").line, root.find("e").line) == (6, 7, 11)


def test_a_warning_names_file_line_and_cause():
    warnings = Warnings()
    root = parse("<a>\n<b/></a>", "/tmp/x/my.world", warnings)
    root.find("b").warn("link 'b' is odd", "links are odd", "'b'")
    assert warnings == ["/tmp/x/my.world, line 2: link 'b' is odd"]
    assert (warnings[0].cause, warnings[0].item) == ("links are odd", "'b' (my.world:2)")


def test_mending_leaves_a_sound_text_as_it_was():
    text = "<a x='1'><b>1 &lt; 2</b>\n<!-- c --><d/></a>"
    expected = '<a x="1"><b>1 &lt; 2</b>\n<d/></a>'
    assert repaired(text) == expected and repaired(expected) == expected


def test_elements_know_their_document():
    root = parse(GOOD, "x")
    assert isinstance(root, Node) and isinstance(root.document, Document)
    assert root.document.root is root and root.find("b").document is root.document


def test_a_great_text_is_mended_in_no_time():
    body = '<b c=1 d="<">x & y</b>\n' * 20000
    assert len(parse(f"<a>{body}</a>", "x")) == 20000
