"""<visual> and <collision> of SDF -> shapes, with colours and textures."""

import os
from dataclasses import replace

from bullet_sim.description.finish import Finish
from bullet_sim.description.parts import Geometry, Shape
from bullet_sim.formats.colors import rgba_of
from bullet_sim.formats.geometry import mesh_geometry, usable_size
from bullet_sim.formats.materials import script_material
from bullet_sim.formats.xml_read import (
    child_flag,
    child_floats,
    child_number,
    child_text,
    floats,
    is_true,
)
from bullet_sim.pose import Pose

PLANE_SIZE = (100.0, 100.0)  # [m] of a visual plane that gives none
PLANE_THICKNESS = 0.002  # [m]
GREY = (0.7, 0.7, 0.7, 1.0)
_ONE = (1.0, 1.0, 1.0)


def parse_shape(element, tag, link, pose, model, resolve):
    """Shape of a <visual> or <collision>, or None with a warning.

    Args:
        element: the element.
        tag: 'visual' or 'collision'.
        link: name of its link.
        pose: in the link's frame.
        model: ModelDescription; gets warnings.
        resolve: function URI -> path.
    """
    name = element.get("name") or tag
    what = f"{tag} '{name}' of link '{link}' of '{model.name}'"
    geometry = element.find("geometry")
    if geometry is None or not len(geometry):
        model.warn(
            f"{what} has no geometry; it is left out",
            "shapes have no geometry and are left out",
            what,
        )
        return None
    parsed = _geometry(geometry[0], what, model, resolve, tag)
    parsed = parsed and usable_size(parsed, what, model)
    if parsed is None:
        return None
    turn = _plane_turn(geometry[0], what)
    if parsed.kind == "heightmap":
        turn = Pose(child_floats(geometry[0], "pos", 3, f"{what} heightmap", (0.0, 0.0, 0.0)))
    shape = Shape(parsed, pose * turn, name=name, link=link)
    if tag == "collision":
        return shape
    if geometry[0].tag == "plane":  # a thin box below the surface
        shape = replace(shape, pose=shape.pose * Pose((0.0, 0.0, -PLANE_THICKNESS / 2)))
    return _looks(element, shape, what, model, resolve)


def _plane_turn(shape, what):
    """Rotation of a plane whose normal is not +z: the shortest."""
    if shape.tag != "plane":
        return Pose()
    x, y, z = child_floats(shape, "normal", 3, f"{what} plane", (0.0, 0.0, 1.0))
    length = (x * x + y * y + z * z) ** 0.5
    if length < 1e-9 or (x == 0.0 and y == 0.0 and z > 0.0):
        return Pose()
    x, y, z = x / length, y / length, z / length
    if z < -0.999999:
        return Pose(orientation=(1.0, 0.0, 0.0, 0.0))
    return Pose(orientation=(-y, x, 0.0, 1.0 + z)).normalised()


def _geometry(shape, what, model, resolve, tag):
    if shape.tag == "plane":
        if tag == "collision":
            return Geometry("plane")
        size = child_floats(shape, "size", 2, f"{what} plane", PLANE_SIZE)
        return Geometry("box", size + (PLANE_THICKNESS,))
    if shape.tag == "box":
        return Geometry("box", child_floats(shape, "size", 3, f"{what} box", _ONE))
    if shape.tag == "cylinder":
        return Geometry(
            "cylinder",
            (child_number(shape, "radius", what, 1.0), child_number(shape, "length", what, 1.0)),
        )
    if shape.tag == "sphere":
        return Geometry("sphere", (child_number(shape, "radius", what, 1.0),))
    if shape.tag == "mesh":
        scale = child_floats(shape, "scale", 3, f"{what} mesh", _ONE)
        uri = shape.document.beside(child_text(shape, "uri", ""))
        geometry = mesh_geometry(uri, scale, what, resolve, model)
        submesh = child_text(shape, "submesh/name")
        if geometry is not None and submesh:
            geometry = replace(
                geometry,
                submesh=submesh,
                centered=is_true(child_text(shape, "submesh/center", "false")),
            )
        return geometry
    if shape.tag in ("heightmap", "polyline"):
        return (_heightmap if shape.tag == "heightmap" else _polyline)(shape, what, model, resolve)
    if shape.tag != "empty":
        model.warn(
            f"{what} has geometry <{shape.tag}>, known are plane, box, cylinder, sphere, "
            "mesh, heightmap, polyline; it is left out",
            "shapes have a geometry that is unknown here and are left out",
            f"{what} <{shape.tag}>",
        )
    return None


def _heightmap(shape, what, model, resolve):
    uri = child_text(shape, "uri", "")
    size = child_floats(shape, "size", 3, f"{what} heightmap", _ONE)
    try:
        path = resolve(shape.document.beside(uri))
        found = os.path.isfile(path)
    except ValueError:
        found = False
    if not found:
        model.warn(
            f"{what}: heightmap '{uri}' is not found; it is left out",
            "heightmaps are missing and left out",
            uri,
        )
        return None
    return Geometry("heightmap", size, path=path)


def _polyline(shape, what, model, _):
    points = tuple(
        floats(point.text or "", 2, f"{what} polyline point") for point in shape.findall("point")
    )
    return Geometry(
        "polyline", (child_number(shape, "height", f"{what} polyline", 1.0),), points=points
    )


def _looks(element, shape, what, model, resolve):
    material = element.find("material")
    color, texture = None, ""
    if material is not None:
        text = child_text(material, "diffuse") or child_text(material, "ambient")
        color = rgba_of(material, text, f"{what} material") if text else None
        script = material.find("script")
        found = script_material(script, resolve, what, model) if script is not None else None
        if found is not None:
            color, texture = found.color or color, found.texture
    if color is None and not texture and shape.geometry.kind != "mesh":
        color = GREY
    clear = min(1.0, max(0.0, child_number(element, "transparency", what, 0.0)))
    if clear and color is not None:
        color = color[:3] + (color[3] * (1.0 - clear),)
    if clear >= 1.0:
        color = (0.0, 0.0, 0.0, 0.0)
    finish = _finish(element, material, 1.0 - clear if color is None else 1.0, what)
    return replace(shape, color=color, texture=texture, painted=color is not None, finish=finish)


def _finish(element, material, opacity, what):
    """Finish of a <visual>: its <material> beside colour and texture."""
    casts = child_flag(element, "cast_shadows", what, True)
    if material is None:
        return Finish(opacity=opacity, cast_shadows=casts)

    def color(tag, default):
        text = child_text(material, tag)
        found = rgba_of(material, text, f"{what} material") if text else None
        return default if found is None else found[:3]

    has_script = material.find("script") is not None
    return Finish(
        None if has_script or not child_text(material, "diffuse") else color("ambient", None),
        color("specular", None),
        color("emissive", (0.0, 0.0, 0.0)),
        child_number(material, "shininess", what, 0.0) or Finish.shininess,
        opacity,
        casts,
        child_flag(material, "lighting", what, True),
    )
