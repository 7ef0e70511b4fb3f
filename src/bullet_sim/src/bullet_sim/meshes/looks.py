"""What the materials of a mesh file look like in Gazebo."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from bullet_sim.description.model import RGB, RGBA

KEY = "look"  # in the metadata of a trimesh


@dataclass(frozen=True)
class Look:
    """A material; the defaults are those of Gazebo's Gazebo/White, of parts without one.

    Attributes:
        diffuse: multiplies the image.
        image: Pillow image.
        double_sided: whether the inside is rendered, too.
    """

    diffuse: RGBA = (1.0, 1.0, 1.0, 1.0)
    ambient: RGB = (1.0, 1.0, 1.0)
    specular: RGB = (0.1, 0.1, 0.1)
    shininess: float = 128.0
    emissive: RGB = (0.0, 0.0, 0.0)
    image: Any = None
    double_sided: bool = False


def look_of(mesh: Any) -> Look | None:
    """Look of a trimesh; None: it has no material."""
    if KEY in mesh.metadata:
        look: Look = mesh.metadata[KEY]
        return look
    visual = mesh.visual
    if visual is None or not visual.defined:
        return None
    material = getattr(visual, "material", None)
    if material is None:  # colors of corners or faces
        color = rgba(visual.main_color)
        return Look(color, color[:3], (0.0,) * 3, 0.0)
    if hasattr(material, "glossiness"):
        return _of_mtl(material)
    color = rgba(material.main_color)
    return Look(color, color[:3], (0.0,) * 3, 0.0, image=material.baseColorTexture)


def rgba(color: Iterable[float]) -> RGBA:
    """RGBA 0..1 of trimesh's color of 0..255, whose alpha may be missing."""
    red, green, blue, alpha = (float(value) / 255.0 for value in (*color, 255)[:4])
    return red, green, blue, alpha


def _of_mtl(material: Any) -> Look:
    """Look of an MTL: what is missing is black, and diffuse 0.6 below an image, as in tinyobj."""
    given = dict(getattr(material, "kwargs", None) or {})
    gray = 0.6 if material.image is not None else 0.0
    red, green, blue = _numbers(given.get("kd"), (gray,) * 3)
    (opacity,) = _numbers(given.get("d"), (1.0,))
    (shininess,) = _numbers(given.get("ns"), (1.0,))
    return Look(
        (red, green, blue, min(1.0, max(0.0, opacity))),
        _numbers(given.get("ka"), (0.0,) * 3),
        _numbers(given.get("ks"), (0.0,) * 3),
        shininess,
        _numbers(given.get("ke"), (0.0,) * 3),
        material.image,
    )


def _numbers(value: Any, default: Any) -> Any:
    """As many finite numbers as the default has; `value` is a number, text or a list of them."""
    words = (
        value.split() if isinstance(value, str) else np.atleast_1d([] if value is None else value)
    )
    try:
        numbers = tuple(float(word) for word in words)[: len(default)]
    except (TypeError, ValueError):
        return default
    return numbers if len(numbers) == len(default) and np.isfinite(numbers).all() else default
