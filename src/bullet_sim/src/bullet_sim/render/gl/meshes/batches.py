"""Instances of one mesh that are drawn together, and their place in the graphics memory."""

from dataclasses import dataclass

ROWS = 12  # numbers of an instance's place
WIDTH = ROWS + 20  # and with its colours: diffuse, ambient, specular, emissive, label
INSTANCE = ("4f",) * 8
INSTANCE_NAMES = (
    "in_row0",
    "in_row1",
    "in_row2",
    "in_color",
    "in_ambient",
    "in_specular",
    "in_emissive",
    "in_label",
)
CORNER, CORNER_NAMES = ("3f", "3f", "2f"), ("in_position", "in_normal", "in_uv")


@dataclass(frozen=True)
class Kind:
    """What the instances of a batch have in common.

    Attributes:
        textured, shiny, lit: see shaders.Programs.
        double_sided: whether the inside is drawn, too.
        transparent: drawn after all others, from far to near.
    """

    textured: bool = False
    shiny: bool = False
    lit: bool = True
    double_sided: bool = False
    transparent: bool = False


class Selection:
    """Some instances of a batch in the graphics memory, for one purpose.

    Attributes:
        buffer: moderngl Buffer with room for all of them.
        arrays: program -> vertex array.
        count: of those in the buffer.
        held: bytes that tell which ones, or None when they may have moved.
    """

    def __init__(self, gl, room):
        self.buffer = gl.buffer(reserve=4 * WIDTH * room, dynamic=True)
        self.arrays, self.count, self.held = {}, 0, None


class Batch:
    """Instances of one mesh that are drawn together.

    Attributes:
        look: Look of the first.
        kind: Kind.
        first, end: its range in the stage's table.
        selections: purpose -> Selection.
    """

    def __init__(self, look, kind, first, end):
        self.look, self.kind, self.first, self.end = look, kind, first, end
        self.selections = {}


def attributes(program, buffer, layout, names, ending=""):
    """Content of a vertex array: what a program does not use is skipped.

    Args:
        layout: formats of the attributes, e.g. ("3f", "2f").
        names: of the attributes.
        ending: of the whole format: " /i" for one a instance.
    """
    kinds = [
        kind if name in program else f"{4 * int(kind[0])}x" for kind, name in zip(layout, names)
    ]
    return (buffer, " ".join(kinds) + ending, *[name for name in names if name in program])
