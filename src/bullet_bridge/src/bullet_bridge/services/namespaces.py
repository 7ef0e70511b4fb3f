"""The robot_namespace of a spawn request, applied to the plugins of the model."""

import xml.etree.ElementTree as ElementTree

from bullet_sim.errors import SimError
from bullet_sim.formats.xml_read import parse


def with_robot_namespace(text, namespace):
    """The model's text with <robotNamespace> in every <plugin> that has none, as gazebo_ros does.

    Args:
        text: URDF or SDF, str or bytes.
        namespace: of the spawn request; empty: the text stays as it is.

    Returns:
        The text; one that is not XML is returned unchanged, the parser reports the error.
    """
    if not namespace:
        return text
    try:
        root = parse(text, "model")
    except SimError:
        return text
    plugins = [plugin for plugin in root.iter("plugin") if plugin.find("robotNamespace") is None]
    if not plugins:
        return text
    for plugin in plugins:
        ElementTree.SubElement(plugin, "robotNamespace").text = namespace
    return ElementTree.tostring(root, encoding="unicode")
