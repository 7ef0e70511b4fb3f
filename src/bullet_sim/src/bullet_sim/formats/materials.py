"""Materials of visuals: <material> of SDF with its scripts, Gazebo's standard materials.

Gazebo draws a visual without any material as Gazebo/White. A color of <material> makes a new one:
what it leaves out is OGRE's default, ambient and diffuse white, no highlights.
"""

from __future__ import annotations

import math
import os
from dataclasses import replace
from functools import lru_cache
from typing import Any, Callable

from bullet_sim.description.model import (
    RGB,
    RGBA,
    Finish,
    ModelDescription,
    Shape,
    TextureMapping,
)
from bullet_sim.files import read_file
from bullet_sim.formats.images.cache import image_of
from bullet_sim.formats.ogre import BLACK, WHITE, Material, Section, complete, look, read_script
from bullet_sim.xml_reader import (
    Node,
    child_flag,
    child_number,
    child_text,
    leading_numbers,
    warn_replaced,
)

Resolve = Callable[[str], str]  # URI -> path of a file


def rgba_of(element: Node | None, text: str | None, label: str) -> RGBA | None:
    """RGBA 0..1 of 3 or 4 numbers, or None with a warning.

    As in Gazebo, a value above 1 counts as one of 0..255, and one below 0 as 0.

    Args:
        element: contains the text; takes the warning.
    """
    values, _ = leading_numbers(text, 4)
    values += (1.0,) * (len(values) == 3)
    if len(values) == 4 and all(map(math.isfinite, values)):
        r, g, b, a = (_clamped(value) for value in values)
        return r, g, b, a
    message = f"{label} is '{(text or '').strip()}', must be 3 or 4 numbers from 0 to 1"
    warn_replaced(element, label, text, message, None)
    return None


def _clamped(value: float) -> float:
    """A component of a color as Gazebo's ignition::math::Color::Clamp has it."""
    return min(1.0, max(0.0, value / 255.0 if value > 1.0 else value))


# Gazebo's standard materials ---------------------------------------------------------------------
# The numbers of Gazebo 11's materials Gazebo/NAME: ambient and diffuse RGB, specular gray (None: as
# the diffuse color), shininess.
_PLAIN: dict[str, tuple[RGB, RGB, float | None, float]] = {
    "Grey": ((0.3,) * 3, (0.7,) * 3, 0.01, 1.5),
    "DarkGrey": ((0.175,) * 3, (0.175,) * 3, 0.175, 1.5),
    "White": (WHITE, WHITE, 0.1, 128.0),
    "FlatBlack": ((0.1,) * 3, (0.1,) * 3, 0.01, 1.0),
    "Black": (BLACK, BLACK, 0.1, 5.0),
    "Red": ((1.0, 0.0, 0.0), (1.0, 0.0, 0.0), 0.1, 1.0),
    "RedBright": ((0.87, 0.26, 0.07), (0.87, 0.26, 0.07), None, 1.0),
    "Green": ((0.0, 1.0, 0.0), (0.0, 1.0, 0.0), 0.1, 1.0),
    "Blue": ((0.0, 0.0, 1.0), (0.0, 0.0, 1.0), 0.1, 1.0),
    "SkyBlue": ((0.13, 0.44, 0.70), (0.0, 0.0, 1.0), 0.1, 1.0),
    "Yellow": ((1.0, 1.0, 0.0), (1.0, 1.0, 0.0), 0.0, 0.0),
    "ZincYellow": ((0.9725, 0.9529, 0.2078), (0.9725, 0.9529, 0.2078), None, 1.0),
    "DarkYellow": ((0.7, 0.7, 0.0), (0.7, 0.7, 0.0), 0.0, 0.0),
    "Purple": ((1.0, 0.0, 1.0), (1.0, 0.0, 1.0), 0.1, 1.0),
    "Turquoise": ((0.0, 1.0, 1.0), (0.0, 1.0, 1.0), 0.1, 1.0),
    "Orange": ((1.0, 0.5088, 0.0468), (1.0, 0.5088, 0.0468), 0.5, 128.0),
    "Indigo": ((0.33, 0.0, 0.5), (0.33, 0.0, 0.5), 0.1, 1.0),
    "Gold": ((0.4, 0.24869, 0.020759), (0.8, 0.64869, 0.120759), 0.4, 12.5),
    "Pioneer2Body": ((0.481193, 0.000123, 0.000123), (0.681193, 0.000923, 0.000923), 0.5, 12.5),
    "Editor": (WHITE, WHITE, 0.1, 128.0),
}
# Ambient and diffuse gray, specular gray, shininess, its image in Gazebo's media, that one's mean,
# which the drawn one has, too.
_PICTURED: dict[str, tuple[float, float, float, float, str, RGB]] = {
    "WoodFloor": (0.5, 1.0, 0.0, 0.0, "hardwood_floor.jpg", (0.54, 0.251, 0.05)),
    "CeilingTiled": (0.5, 1.0, 0.0, 0.0, "ceiling_tiled.jpg", (0.919, 0.919, 0.919)),
    "PaintedWall": (1.0, 1.0, 0.0, 0.0, "paintedWall.jpg", (0.898, 0.773, 0.463)),
    "WoodPallet": (0.5, 1.0, 0.0, 0.0, "WoodPallet.png", (0.543, 0.384, 0.185)),
    "Wood": (1.0, 1.0, 0.2, 12.5, "wood.jpg", (0.763, 0.506, 0.266)),
    "Bricks": (1.0, 1.0, 0.2, 12.5, "bricks.png", (0.562, 0.379, 0.37)),
    "Road": (0.1, 0.8, 0.01, 2.0, "road1.jpg", (0.413, 0.411, 0.404)),
    "Residential": (0.1, 0.8, 0.01, 2.0, "residential.jpg", (0.476, 0.452, 0.424)),
    "Pedestrian": (0.1, 0.8, 0.01, 2.0, "sidewalk.jpg", (0.582, 0.582, 0.53)),
    "Motorway": (0.1, 0.8, 0.01, 2.0, "motorway.jpg", (0.411, 0.406, 0.396)),
    "Trunk": (0.1, 0.8, 0.01, 2.0, "trunk.jpg", (0.485, 0.459, 0.419)),
    "Primary": (0.1, 0.8, 0.01, 2.0, "primary.jpg", (0.413, 0.411, 0.404)),
    "Secondary": (0.1, 0.8, 0.01, 2.0, "secondary.jpg", (0.484, 0.458, 0.418)),
    "Steps": (0.1, 0.8, 0.01, 2.0, "steps.jpeg", (0.47, 0.47, 0.47)),
    "BuildingFrame": (1.0, 1.0, 0.2, 12.5, "building_frame.png", (0.64, 0.64, 0.64)),
    "Runway": (0.5, 1.0, 0.0, 0.0, "runway.png", (0.403, 0.403, 0.388)),
    "Grass": (0.5, 1.0, 0.0, 0.0, "grass.jpg", (0.247, 0.481, 0.054)),
    "CoM": (0.5, 1.0, 0.0, 0.0, "com.png", (0.5, 0.5, 0.5)),
}
_SAME = {
    "Gray": "Grey",
    "DarkGray": "DarkGrey",
    "Tertiary": "Residential",
    "Footway": "Pedestrian",
    "Lanes_6": "Motorway",
    "Lanes_4": "Trunk",
    "Lanes_2": "Primary",
    "Lane_1": "Secondary",
}
# Translucent ones: diffuse RGB and alpha.
_GLASS: dict[str, RGBA] = {
    "GreenTransparent": (0.0, 1.0, 0.0, 0.5),
    "BlueTransparent": (0.0, 0.0, 1.0, 0.5),
    "DarkMagentaTransparent": (0.6, 0.0, 0.6, 0.5),
    "GreyTransparent": (0.5, 0.5, 0.5, 0.5),
    "BlackTransparent": (0.0, 0.0, 0.0, 0.5),
    "YellowTransparent": (1.0, 1.0, 0.0, 0.5),
    "LightBlueLaser": (0.5, 0.5, 1.0, 0.4),
    "BlueLaser": (0.0, 0.0, 1.0, 0.4),
    "OrangeTransparent": (1.0, 0.44, 0.0, 0.4),
}
# In one color whatever the light, RGB and alpha.
_UNLIT: dict[str, RGBA] = {
    "RedTransparent": (1.0, 0.0, 0.0, 0.5),
    "RedTransparentOverlay": (1.0, 0.0, 0.0, 0.5),
    "GreenTransparentOverlay": (0.0, 1.0, 0.0, 0.5),
    "BlueTransparentOverlay": (0.0, 0.0, 1.0, 0.5),
    "OrangeTransparentOverlay": (1.0, 0.5088, 0.0468, 0.8),
    "DarkOrangeTransparentOverlay": (0.6, 0.305, 0.028, 0.8),
    "JointAnchor": (1.0, 1.0, 1.0, 1.0),
}
# That shine in a color. Other Glows are white: their last pass has no other color than emissive.
_LAMPS: dict[str, RGB] = {
    "LightOn": (0.0, 1.0, 0.0),
    "LightOff": (1.0, 0.0, 0.0),
    "RedGlow": (1.0, 0.0, 0.0),
}
_GLOWS = ("White", "Green", "Blue", "Yellow", "Purple", "Turquoise")
GRASS = TextureMapping((50.0, 0.0, -24.5, 0.0, 50.0, -24.5), anisotropy=16)  # its scale is 0.02
MEDIA = "file://media/materials/textures"  # where Gazebo has its images


def standard(name: str, resolve: Resolve | None = None) -> Material | None:
    """One of Gazebo's standard materials; None: no such material.

    Args:
        name: 'Gazebo/Orange' or 'Orange'.
        resolve: finds Gazebo's images, if they are installed; else drawn ones stand for them.
    """
    plain = name.strip().rsplit("/", 1)[-1]
    plain = _SAME.get(plain, plain)
    return _pictured(plain, resolve) if plain in _PICTURED else _STANDARD.get(plain)


def _finish(ambient: RGB, specular: RGB, shininess: float, **others: Any) -> Finish:
    return Finish(ambient=ambient, specular=specular, shininess=shininess, **others)


def _pictured(name: str, resolve: Resolve | None) -> Material:
    ambient, diffuse, gray, shininess, image, mean = _PICTURED[name]
    mapping = GRASS if name == "Grass" else TextureMapping()
    finish = _finish((ambient,) * 3, (gray,) * 3, shininess, mapping=mapping)
    try:
        path = os.path.join(resolve(MEDIA), image) if resolve is not None else ""
    except ValueError:
        path = ""
    if not os.path.isfile(path):
        path = image_of(name, mean)
    return Material((diffuse, diffuse, diffuse, 1.0), path, finish, None if path else mean)


_STANDARD = {
    name: Material((*diffuse, 1.0), finish=_finish(ambient, (gray,) * 3, shininess))
    if gray is not None
    else Material((*diffuse, 1.0), finish=_finish(ambient, diffuse, shininess))
    for name, (ambient, diffuse, gray, shininess) in _PLAIN.items()
}
for _name, _rgba in _GLASS.items():
    _STANDARD[_name] = Material(_rgba, finish=_finish(_rgba[:3], BLACK, 0.0, blend="alpha"))
for _name, _rgba in _UNLIT.items():
    _blend = "alpha" if _rgba[3] < 1.0 else ""
    _STANDARD[_name] = Material(_rgba, finish=_finish(WHITE, BLACK, 0.0, lit=False, blend=_blend))
for _name, _rgb in _LAMPS.items():
    _STANDARD[_name] = Material((*_rgb, 1.0), finish=_finish(_rgb, BLACK, 0.0, emissive=_rgb))
for _name in _GLOWS:
    _glow = _finish(WHITE, BLACK, 0.0, emissive=_PLAIN[_name][1])
    _STANDARD[f"{_name}Glow"] = Material(finish=_glow)
NOTHING = Material(finish=_finish(WHITE, (0.1, 0.1, 0.1), 128.0))  # Gazebo/White, of no material


# Scripts ------------------------------------------------------------------------------------------
# Where Gazebo has searched for scripts already when a material names none.
DEFAULT_SCRIPTS = ("file://media/materials/scripts", "file://Media/materials/scripts")


def script_material(
    element: Node, resolve: Resolve, label: str, model: ModelDescription
) -> Material | None:
    """Material of a <script> element, or None with a warning when it does not exist.

    Args:
        element: <script> with <name> and <uri>s.
    """
    name = child_text(element, "name", "")
    known = standard(name, resolve) if name.startswith("Gazebo/") else None
    material = known or _scripted(name, element, resolve, label, model)
    if material is None:
        model.warn(
            f"{label}: material '{name}' is not in its scripts; it stays white",
            "materials are not in their scripts and stay white",
            f"'{name}'",
        )
    return material


def named_material(
    name: str, element: Node, resolve: Resolve, label: str, model: ModelDescription
) -> Material | None:
    """Material of a name alone: a standard one, or of a script that Gazebo finds by itself.

    Args:
        element: that names it.
    """
    return standard(name, resolve) or _scripted(name, element, resolve, label, model)


def _scripted(
    name: str, element: Node, resolve: Resolve, label: str, model: ModelDescription
) -> Material | None:
    """Material of the scripts of an element's <uri>s, or of DEFAULT_SCRIPTS without any."""
    paths = _paths(element, resolve)
    folders = _folders(paths)
    sections: dict[str, Section] = {}
    for file in (file for path in paths for file in _scripts(path)):
        for material in _read_file(file, _changed(file)):
            sections.setdefault(material.name, material)
    section = complete(name, sections)
    if section is None:
        return None
    appearance = look(section)

    def image(file: str) -> str:
        path = _texture_path(file, folders)
        if not path:
            model.warn(
                f"{label}: image '{file}' of material '{name}' is in none of {', '.join(folders)}",
                "images of materials are missing",
                f"'{file}'",
            )
        return path

    layers = [replace(layer, path=image(layer.path)) for layer in appearance.finish.layers]
    finish = replace(appearance.finish, layers=tuple(layer for layer in layers if layer.path))
    texture = image(appearance.texture) if appearance.texture else ""
    return replace(appearance, texture=texture, finish=finish)


def _paths(script: Node, resolve: Resolve) -> list[str]:
    """Files and folders of a <script>'s <uri>s, as far as they are found."""
    uris = [(uri.text or "").strip() for uri in script.findall("uri")]
    paths = []
    for uri in uris or DEFAULT_SCRIPTS:
        try:
            paths.append(resolve(script.document.resolve_relative(uri)))
        except ValueError:
            continue
    return paths


def _folders(paths: list[str]) -> list[str]:
    return [path if os.path.isdir(path) else os.path.dirname(path) for path in paths]


def _changed(path: str) -> int:
    try:
        return os.stat(path).st_mtime_ns
    except OSError:
        return 0


@lru_cache(maxsize=64)
def _read_file(path: str, _: int) -> tuple[Section, ...]:
    """Materials of a script file, none where it cannot be read."""
    try:
        return tuple(
            read_script(read_file(path, "material script", "text_bytes").decode(errors="replace"))
        )
    except (OSError, ValueError):
        return ()


def _scripts(path: str) -> list[str]:
    if os.path.isdir(path):
        return sorted(
            os.path.join(path, name) for name in os.listdir(path) if name.endswith(".material")
        )
    return [path] if os.path.isfile(path) else []


def _texture_path(name: str, folders: list[str]) -> str:
    for folder in folders:
        for directory in (
            folder,
            os.path.join(folder, "..", "textures"),
            os.path.join(folder, "materials", "textures"),
        ):
            path = os.path.normpath(os.path.join(directory, name))
            if os.path.isfile(path):
                return path
    return ""


# <material> of a visual ---------------------------------------------------------------------------
def with_material(
    element: Node, shape: Shape, label: str, model: ModelDescription, resolve: Resolve
) -> Shape:
    """A visual with what its <material>, <transparency> and <cast_shadows> say.

    Args:
        element: <visual>.
        shape: without a material.
    """
    material = material_of(element.find("material"), label, model, resolve)
    transparency = min(1.0, max(0.0, child_number(element, "transparency", label, 0.0)))
    casts = child_flag(element, "cast_shadows", label, True)
    finish = replace(shape.finish, cast_shadows=casts)
    if material is None:
        lit = child_flag(element, "material/lighting", label, True)
        emissive = _given(element.find("material"), "emissive", label) or BLACK
        if shape.geometry.kind == "mesh":  # with materials of its own
            finish = replace(finish, opacity=1.0 - transparency, lit=lit, emissive=emissive)
            return replace(shape, finish=finish)
        material = replace(NOTHING, finish=replace(NOTHING.finish, lit=lit, emissive=emissive))
    shape = material.on(replace(shape, finish=finish))
    red, green, blue, alpha = shape.color or (*WHITE, 1.0)
    return replace(shape, color=(red, green, blue, alpha * (1.0 - transparency)))


def material_of(
    material: Node | None, label: str, model: ModelDescription, resolve: Resolve
) -> Material | None:
    """Material of a <material>; None: it gives none, what it is on has its own."""
    if material is None:
        return None
    script = material.find("script")
    base = script_material(script, resolve, label, model) if script is not None else None
    ambient, specular = (_given(material, tag, label) for tag in ("ambient", "specular"))
    text = child_text(material, "diffuse")
    diffuse = rgba_of(material, text, f"{label} material") if text else None
    if base is None and ambient is None and specular is None and diffuse is None:
        return None
    base = base or Material()
    finish = base.finish
    if ambient is not None:
        finish = replace(finish, ambient=ambient)
    if specular is not None:
        shininess = child_number(material, "shininess", label, 0.0)
        finish = replace(finish, specular=specular, shininess=shininess)
    emissive = _given(material, "emissive", label)
    if emissive is not None:
        finish = replace(finish, emissive=emissive)
    finish = replace(finish, lit=finish.lit and child_flag(material, "lighting", label, True))
    finish = replace(finish, normal_map=_normal_map(material, resolve, label, model))
    return replace(base, color=diffuse or base.color, finish=finish)


def _normal_map(material: Node, resolve: Resolve, label: str, model: ModelDescription) -> str:
    """Path of the image of a <shader> with normals in the surface's axes; '': none."""
    shader = material.find("shader")
    if shader is None or shader.get("type") != "normal_map_tangent_space":
        return ""
    name = child_text(shader, "normal_map", "")
    if name in ("", "__default__"):
        return ""
    script = material.find("script")
    folders = [] if script is None else _folders(_paths(script, resolve))
    path = _texture_path(name, folders)
    if path:
        return path
    try:
        return resolve(shader.document.resolve_relative(name))
    except ValueError as error:
        model.warn(
            f"{label}: normal map '{name}' is not found: {error}",
            "normal maps are not found",
            f"'{name}'",
        )
        return ""


def _given(material: Node | None, tag: str, label: str) -> RGB | None:
    """RGB of a child of a <material>; None: not given."""
    text = child_text(material, tag) if material is not None else None
    color = rgba_of(material, text, f"{label} material") if text else None
    return None if color is None else color[:3]
