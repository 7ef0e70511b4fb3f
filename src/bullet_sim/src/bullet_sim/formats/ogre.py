"""OGRE material scripts (.material): their sections, and the look of one material.

The syntax is that of OGRE 1.9's manual, "Material Scripts": nested sections in braces, one
statement a line, comments as in C++. A section of a child material continues the one of the same
name, or without a name the one at the same place, of its parent. What programs, animations and
environment maps do is not read.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import List

import numpy as np

from bullet_sim.description.model import RGB, RGBA, Finish, Layer, Shape, TextureMapping

Statement = List[str]
_COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)
_TOKEN = re.compile(r'"[^"\n]*"|[{}\n]|[^\s{}"]+')
MAX_DEPTH = 16  # of parents of parents


@dataclass
class Section:
    """A section in braces.

    Attributes:
        kind: 'material', 'technique', 'pass', 'texture_unit' or any other first word.
        name: its name; '': none.
        parent: name of the material that a material continues; '': none.
        statements: lines of words.
    """

    kind: str
    name: str = ""
    parent: str = ""
    statements: list[Statement] = field(default_factory=list)
    sections: list[Section] = field(default_factory=list)

    def of_kind(self, kind: str) -> list[Section]:
        """The sections of a kind in it."""
        return [section for section in self.sections if section.kind == kind]


def read_script(text: str) -> list[Section]:
    """Materials of a script, abstract ones too; what is cut off ends where the text does."""
    root = Section("script")
    open_sections: list[Section] = [root]
    line: Statement = []
    for token in [*_TOKEN.findall(_COMMENT.sub(" ", text)), "\n"]:
        if token == "{":
            section = _section(line or _last_statement(open_sections[-1]))
            open_sections[-1].sections.append(section)
            open_sections.append(section)
            line = []
        elif token in "}\n":
            if line:
                open_sections[-1].statements.append(line)
                line = []
            if token == "}" and len(open_sections) > 1:
                open_sections.pop()
        else:
            line.append(token.strip('"'))
    return root.of_kind("material")


def _last_statement(section: Section) -> Statement:
    """The line above a brace that stands alone, which is the head of what it opens."""
    return section.statements.pop() if section.statements else []


def _section(head: Statement) -> Section:
    """Section of a head such as: material A : B."""
    words = [word for word in head if word != "abstract"]
    kind, names = (words[0] if words else ""), words[1:]
    if ":" in names:
        colon = names.index(":")
        return Section(kind, " ".join(names[:colon]), " ".join(names[colon + 1 :]))
    return Section(kind, " ".join(names))


def _continued(parent: Section, child: Section) -> Section:
    """A section with what its parent says before it."""
    sections = list(parent.sections)
    counts: dict[str, int] = {}
    for section in child.sections:
        places = [place for place, other in enumerate(sections) if other.kind == section.kind]
        named = [place for place in places if section.name and sections[place].name == section.name]
        number = counts.get(section.kind, 0)
        counts[section.kind] = number + 1
        if named:
            chosen = named[0]
        elif not section.name and number < len(places):
            chosen = places[number]
        else:
            sections.append(section)
            continue
        sections[chosen] = _continued(sections[chosen], section)
    statements = parent.statements + child.statements
    return Section(child.kind, child.name or parent.name, "", statements, sections)


def complete(name: str, materials: Mapping[str, Section]) -> Section | None:
    """A material with what it inherits; None: there is none of that name.

    Args:
        materials: by name.
    """
    section = materials.get(name)
    for _ in range(MAX_DEPTH):
        if section is None or not section.parent or section.parent not in materials:
            break
        parent = materials[section.parent]
        grandparent = parent.parent
        section = _continued(parent, section)
        section.parent = grandparent
    return section


WHITE: RGB = (1.0, 1.0, 1.0)
BLACK: RGB = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Material:
    """What a visual looks like; the defaults are OGRE's.

    Attributes:
        color: diffuse RGBA.
        texture: path of its image, or the file name that a script has; '': none.
        tint: mean color of an image that can be neither found nor drawn, which stands for it.
    """

    color: RGBA = (*WHITE, 1.0)
    texture: str = ""
    finish: Finish = Finish(ambient=WHITE, specular=BLACK, shininess=0.0)
    tint: RGB | None = None

    def on(self, shape: Shape) -> Shape:
        """A visual with this material; whether it casts shadows stays."""
        color, finish = self.color, replace(self.finish, cast_shadows=shape.finish.cast_shadows)
        if not finish.lit and not finish.blend and not self.texture:
            color = (*WHITE, color[3])  # without light OGRE draws in the color of the corners
        if self.tint is not None:
            color = (*_product(color[:3], self.tint), color[3])
            finish = replace(
                finish,
                ambient=_product(finish.ambient or WHITE, self.tint),
                emissive=_product(finish.emissive, self.tint),
            )
        return replace(shape, color=color, texture=self.texture, painted=True, finish=finish)


def _product(a: RGB, b: RGB) -> RGB:
    red, green, blue = (x * y for x, y in zip(a, b))
    return red, green, blue


def look(material: Section) -> Material:
    """What a material looks like: its first technique, its passes one over the other.

    A pass that replaces what is below it hides it; one that adds to it adds its colors where both
    have the same texture.
    """
    techniques = material.of_kind("technique")
    passes = [_pass(section) for section in techniques[0].of_kind("pass")] if techniques else []
    if not passes:
        return Material()
    result = passes[0]
    for other in passes[1:]:
        if not other.finish.blend:
            result = other
        elif other.finish.blend == "add" and other.texture in ("", result.texture):
            result = _sum(result, other)
    return result


def _sum(one: Material, other: Material) -> Material:
    def add(a: RGB | None, b: RGB | None) -> RGB:
        red, green, blue = (x + y for x, y in zip(a or (0.0,) * 3, b or (0.0,) * 3))
        return red, green, blue

    red, green, blue = add(one.color[:3], other.color[:3])
    finish = one.finish
    return Material(
        (red, green, blue, one.color[3]),
        one.texture,
        replace(
            finish,
            ambient=add(finish.ambient, other.finish.ambient),
            specular=add(finish.specular, other.finish.specular),
            emissive=add(finish.emissive, other.finish.emissive),
            shininess=max(finish.shininess, other.finish.shininess),
        ),
    )


_COLORS = {"ambient": WHITE, "diffuse": WHITE, "emissive": BLACK, "specular": BLACK}
# scene_blend, also as its two factors -> Finish.blend; others replace.
_BLENDS = {
    ("add",): "add",
    ("one", "one"): "add",
    ("modulate",): "modulate",
    ("dest_colour", "zero"): "modulate",
    ("colour_blend",): "color",
    ("alpha_blend",): "alpha",
    ("src_alpha", "one_minus_src_alpha"): "alpha",
}
_REJECTIONS = ("greater", "greater_equal")


def _pass(section: Section) -> Material:
    said = {words[0]: words[1:] for words in section.statements}
    diffuse, specular = _numbers(said.get("diffuse", ())), _numbers(said.get("specular", ()))
    colors = {name: _color(said.get(name, ()), default) for name, default in _COLORS.items()}
    rejection = said.get("alpha_rejection", [""])
    finish = Finish(
        ambient=colors["ambient"],
        specular=colors["specular"],
        emissive=colors["emissive"],
        shininess=specular[-1] if len(specular) > 3 else 0.0,
        lit=said.get("lighting") != ["off"],
        blend=_BLENDS.get(tuple(said.get("scene_blend", ())), ""),
        rejection=_first(rejection[1:], 0.0) / 255.0 if rejection[0] in _REJECTIONS else 0.0,
        double_sided=said.get("cull_hardware") == ["none"],
    )
    alpha = diffuse[3] if len(diffuse) > 3 else 1.0
    material = Material((*colors["diffuse"], alpha), "", finish)
    for unit in section.of_kind("texture_unit"):
        material = _with_unit(material, unit)
    return material


MAX_LAYERS = 3  # texture_units beyond the first
# The first words of colour_op and colour_op_ex -> Layer.operation; others multiply.
_OPERATIONS = {
    ("add",): "add",
    ("add_smooth",): "add",
    ("replace",): "replace",
    ("source1", "src_texture"): "replace",
    ("alpha_blend",): "alpha_blend",
    ("blend_texture_alpha", "src_texture"): "alpha_blend",
}


def _operation(said: Mapping[str, Sequence[str]]) -> str:
    words = tuple(said.get("colour_op_ex") or said.get("colour_op") or ())
    if words[:1] == ("source2",) and words[2:3] == ("src_texture",):
        return "replace"
    return _OPERATIONS.get(words[:1]) or _OPERATIONS.get(words[:2]) or "modulate"


def _with_unit(material: Material, unit: Section) -> Material:
    """A pass with one more texture_unit."""
    said = {words[0]: words[1:] for words in unit.statements}
    texture, finish = (said.get("texture") or [""])[0], material.finish
    red, green, blue, alpha = material.color
    manual = said.get("colour_op_ex", [])
    if manual[:2] == ["source1", "src_manual"]:  # a color of its own, whatever the light
        red, green, blue = _color(manual[3:], (red, green, blue))
        finish = replace(finish, lit=False)
    manual = said.get("alpha_op_ex", [])
    if manual[:2] == ["source1", "src_manual"]:
        alpha = _first(manual[3:], alpha)
    filters = said.get("filtering", [""])
    mapping = TextureMapping(
        _transform(said),
        "clamp" if (said.get("tex_address_mode") or [""])[0] == "clamp" else "",
        "nearest" if filters in (["none"], ["point", "point", "none"]) else "",
        int(_first(said.get("max_anisotropy", ()), 1.0)) if filters == ["anisotropic"] else 1,
    )
    operation, first = _operation(said), not material.texture and not finish.layers
    if not texture:
        return replace(material, color=(red, green, blue, alpha), finish=finish)
    if first and operation == "modulate":
        finish = replace(finish, mapping=mapping)
        return Material((red, green, blue, alpha), texture, finish)
    layers = (*finish.layers, Layer(texture, operation, mapping))[:MAX_LAYERS]
    return replace(material, finish=replace(finish, layers=layers))


def _transform(said: Mapping[str, Sequence[str]]) -> tuple[float, ...]:
    """TextureMapping.transform of a texture_unit: scaled about the image's center, then moved,
    then rotated about the center, as OGRE's TextureUnitState does."""
    scale, scroll = _numbers(said.get("scale", ())), _numbers(said.get("scroll", ()))
    angle = math.radians(_first(said.get("rotate", ()), 0.0))
    u, v = scale if len(scale) == 2 and all(scale) else (1.0, 1.0)
    matrix = np.array([[1.0 / u, 0.0, 0.5 - 0.5 / u], [0.0, 1.0 / v, 0.5 - 0.5 / v], [0, 0, 1]])
    if len(scroll) == 2:
        matrix[:2, 2] += scroll
    if angle:
        cos, sin = math.cos(angle), math.sin(angle)
        turn = np.array([[cos, -sin, 0.5], [sin, cos, 0.5], [0.0, 0.0, 1.0]])
        turn[:2, 2] -= turn[:2, :2] @ (0.5, 0.5)
        matrix = turn @ matrix
    flip = np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 1.0], [0.0, 0.0, 1.0]])  # OGRE's v points down
    matrix = flip @ matrix @ flip
    return tuple(matrix[:2].ravel().tolist()) if not np.array_equal(matrix, np.eye(3)) else ()


def _numbers(words: Sequence[str]) -> tuple[float, ...]:
    """Finite numbers at the start of some words."""
    numbers: list[float] = []
    for word in words:
        try:
            number = float(word)
        except ValueError:
            break
        if not math.isfinite(number):
            break
        numbers.append(number)
    return tuple(numbers)


def _first(words: Sequence[str], default: float) -> float:
    return (*_numbers(words), default)[0]


def _color(words: Sequence[str], default: RGB) -> RGB:
    numbers = _numbers(words)
    return (numbers[0], numbers[1], numbers[2]) if len(numbers) >= 3 else default
