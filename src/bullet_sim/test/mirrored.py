"""Sources of mirrors for tests, from URDF."""

from bullet_sim.description.lump import lump
from bullet_sim.description.mirrors import mirrored_links, visual_links
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.snapshot import BodySource


def source_of(text, key=0, fixed_base=True):
    """BodySource of a URDF text whose meshes are paths."""
    lumped = lump(parse_urdf(text, str, "body"))
    return BodySource(key, fixed_base, visual_links(lumped, mirrored_links(lumped)))
