"""The links of a BodySource, also of one that names only a URDF file."""

from bullet_sim.description.lump import lump
from bullet_sim.description.visual import depth_first, visual_links
from bullet_sim.formats.urdf import parse_urdf


def links_of(source):
    """VisualLinks of a BodySource; read from its file when it has none.

    Raises:
        OSError, ModelError: the file cannot be read.
    """
    if source.links is not None:
        return source.links
    with open(source.path, encoding="utf-8") as file:
        lumped = lump(parse_urdf(file.read(), lambda uri: uri, "body"))
    return visual_links(lumped, depth_first(lumped))
