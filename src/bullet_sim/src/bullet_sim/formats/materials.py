"""OGRE material scripts of SDF models: the texture or the colour of a material."""

import os
import re
from dataclasses import dataclass

from bullet_sim.formats.colors import gazebo_color
from bullet_sim.formats.xml_read import child_text

# Where Gazebo has looked for scripts already when a material names none.
EVERYWHERE = ("file://media/materials/scripts", "file://Media/materials/scripts")
_TOKEN = re.compile(r'"[^"]*"|[{}]|[^\s{}]+')


@dataclass(frozen=True)
class Material:
    """Path of a texture image, or a colour RGBA 0..1."""

    texture: str = ""
    color: tuple[float, float, float, float] | None = None


def read_materials(text):
    """All materials of an OGRE script: name -> (picture's file name or '', RGBA or None).

    The first texture and the first colour of a material count; inherited values
    ("material A : B") are copied; everything else is ignored.
    """
    found, current, depth = {}, None, 0
    for line in re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL).splitlines():
        words = _TOKEN.findall(line.split("//")[0])
        if words and words[0] == "material" and depth == 0 and len(words) > 1:
            names = [word.strip('"') for word in words[1:] if word not in ("{", "}", ":")]
            current = names[0]
            parent = found.get(names[1]) if len(names) > 1 else None
            found[current] = parent or ("", None)
        elif current is not None and len(words) > 1:
            found[current] = _noted(found[current], words)
        depth = max(0, depth + words.count("{") - words.count("}"))
    return found


def _noted(so_far, words):
    texture, color = so_far
    if words[0] == "texture":
        texture = words[1].strip('"')
    elif words[0] in ("diffuse", "ambient") and (color is None or words[0] == "diffuse"):
        try:
            values = tuple(min(1.0, max(0.0, float(word))) for word in words[1:5])
        except ValueError:
            return so_far
        if len(values) >= 3:
            color = (values + (1.0,))[:4]
    return texture, color


def script_material(element, resolve, what, model):
    """Material of a <script> element, or None with a warning when it is not found.

    Args:
        element: <script> with <name> and <uri>s.
        resolve: function URI -> path.
        what: for messages.
        model: ModelDescription; gets the warning.
    """
    name = child_text(element, "name", "")
    color = gazebo_color(name) if name.startswith("Gazebo/") else None
    if color is not None:
        return Material(color=color)
    files, folders = [], []
    uris = [(uri.text or "").strip() for uri in element.findall("uri")]
    for uri in uris or EVERYWHERE:
        try:
            path = resolve(element.document.beside(uri))
        except ValueError:
            continue
        folders.append(path if os.path.isdir(path) else os.path.dirname(path))
        files += _scripts(path)
    for path in files:
        try:
            with open(path, encoding="utf-8", errors="replace") as file:
                found = read_materials(file.read()).get(name)
        except OSError:
            continue
        if found is None:
            continue
        texture, color = found
        if not texture:
            return Material(color=color)
        picture = _picture(texture, folders)
        if picture:
            return Material(picture, color)
        model.warn(
            f"{what}: picture '{texture}' of material '{name}' is in none of {', '.join(folders)}",
            "pictures of materials are missing",
            f"'{texture}'",
        )
        return Material(color=color)
    model.warn(
        f"{what}: material '{name}' is not found in its scripts; it stays grey",
        "materials are not found in their scripts and stay grey",
        f"'{name}'",
    )
    return None


def _scripts(path):
    if os.path.isdir(path):
        return sorted(
            os.path.join(path, name) for name in os.listdir(path) if name.endswith(".material")
        )
    return [path] if os.path.isfile(path) else []


def _picture(name, folders):
    for folder in folders:
        for place in (
            folder,
            os.path.join(folder, "..", "textures"),
            os.path.join(folder, "materials", "textures"),
        ):
            path = os.path.normpath(os.path.join(place, name))
            if os.path.isfile(path):
                return path
    return ""
