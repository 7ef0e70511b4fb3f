"""How a visual's surface reflects light, beside its colour or texture."""

from dataclasses import dataclass

RGB = tuple[float, float, float]


@dataclass(frozen=True)
class Finish:
    """Surface of a visual, RGB 0..1.

    Attributes:
        ambient: reflected of the light from everywhere; None: as the colour.
        specular: of the highlights; None: the mesh's own, or none.
        emissive: what it shines by itself.
        shininess: exponent of the highlights.
        opacity: 1 opaque, 0 invisible; multiplies the colour's.
        cast_shadows: whether it casts shadows.
        lit: False: drawn in its colour, whatever the light.
    """

    ambient: RGB | None = None
    specular: RGB | None = None
    emissive: RGB = (0.0, 0.0, 0.0)
    shininess: float = 24.0
    opacity: float = 1.0
    cast_shadows: bool = True
    lit: bool = True


PLAIN = Finish()
