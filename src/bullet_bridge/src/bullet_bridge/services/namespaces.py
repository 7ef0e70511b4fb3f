"""The robot_namespace of a spawn request, applied to the plugins of the model."""

import xml.etree.ElementTree as ElementTree

from bullet_sim.errors import SimError
from bullet_sim.xml_reader import parse


def with_robot_namespace(text, namespace):
    """The model with <robotNamespace> in every <plugin> that has none, as gazebo_ros does.

    Args:
        text: URDF or SDF, str or bytes.
        namespace: of the spawn request; empty: the text stays as it is.

    Returns:
        The text, or the root of what was read of it, whose elements know their lines; a text that
        is not XML comes back unchanged, its reader says why.
    """
    if not namespace:
        return text
    try:
        root = parse(text, "model")
    except SimError:
        return text
    for plugin in root.iter("plugin"):
        if plugin.find("robotNamespace") is None:
            ElementTree.SubElement(plugin, "robotNamespace").text = namespace
    return root
