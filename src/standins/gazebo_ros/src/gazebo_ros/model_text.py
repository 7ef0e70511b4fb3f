"""Model text and poses of a spawn request, without ROS."""

import math
import xml.etree.ElementTree as ElementTree
from xml.sax.saxutils import escape

DATABASE_TEMPLATE = (
    '<sdf version="1.4"><world name="default"><include><uri>model://%s</uri>'
    "</include></world></sdf>"
)


class ModelTextError(ValueError):
    """The model's text cannot be used."""


def from_database(model):
    """Returns SDF text that includes a model by its name."""
    return DATABASE_TEMPLATE % escape(model)


def checked(text, source, package_to_model=False):
    """Checks that a text is XML and drops an XML declaration.

    Args:
        text: URDF or SDF, str or bytes.
        source: where it came from, for the error text.
        package_to_model: turn package:// into model:// in mesh file names.

    Returns:
        The text (str) as the service wants it.

    Raises:
        ModelTextError: the text is empty or is not XML.
    """
    if not text.strip():
        raise ModelTextError(f"{source} is empty, expected URDF or SDF")
    try:
        raw = text if isinstance(text, bytes) else _without_declaration(text).encode("utf-8")
        root = ElementTree.fromstring(raw)
    except ElementTree.ParseError as error:
        raise ModelTextError(f"{source} is not valid XML: {error}") from None
    if package_to_model:
        for mesh in root.iter("mesh"):
            name = mesh.get("filename", "")
            if name.startswith("package://"):
                mesh.set("filename", "model://" + name[len("package://") :])
    return ElementTree.tostring(root, encoding="unicode")


def _without_declaration(text):
    text = text.lstrip("\ufeff \t\r\n")
    if text.startswith("<?xml"):
        text = text[text.index("?>") + 2 :] if "?>" in text else text
    return text


def quaternion_from_rpy(roll, pitch, yaw):
    """Returns the quaternion (x, y, z, w) of fixed-axis roll, pitch, yaw [rad] (URDF, REP 103)."""
    cr, sr = math.cos(roll / 2), math.sin(roll / 2)
    cp, sp = math.cos(pitch / 2), math.sin(pitch / 2)
    cy, sy = math.cos(yaw / 2), math.sin(yaw / 2)
    return (
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )
