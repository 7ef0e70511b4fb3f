"""What sdformat 9.3, that of Gazebo 11.1, makes of a URDF's <gazebo> elements.

Source: ParseSDFExtension and InsertSDFExtensionLink, -Joint, -Collision and -Robot of
parser_urdf.cc. It copies what it does not know behind what it writes itself, and Gazebo reads the
first of several elements of one name: which of two counts follows from their order alone.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from bullet_sim.xml_reader import Node, copied

# Of which sdformat makes something else; all other children of <gazebo> are copied.
OF_CONTACT = {"kp": "kp", "kd": "kd", "maxVel": "max_vel", "minDepth": "min_depth"}
OF_FRICTION = {"mu1": "mu", "mu2": "mu2", "fdir1": "fdir1"}
OF_COLLISION = {"laserRetro": "laser_retro", "maxContacts": "max_contacts"}
OF_AXIS = {"springReference": "spring_reference", "springStiffness": "spring_stiffness"}
OF_LIMIT = {"stopCfm": "cfm", "stopErp": "erp"}
DAMPING = ("cfmDamping", "implicitSpringDamper")
CONVERTED = {
    *(*OF_CONTACT, *OF_FRICTION, *OF_COLLISION, *OF_AXIS, *OF_LIMIT, *DAMPING),
    *("material", "collision", "visual", "static", "turnGravityOff", "dampingFactor"),
    *("selfCollide", "fudgeFactor", "provideFeedback", "canonicalBody"),
    *("disableFixedJointLumping", "preserveFixedJoint"),
}


def text_of(element: Node, *tags: str) -> str | None:
    """Text of the last child with one of these tags, which counts of several; None: none."""
    found = [child for child in element if child.tag in tags]
    return (found[-1].text or "").strip() if found else None


def is_yes(text: str | None) -> bool:
    """Whether sdformat takes the text of one of its own flags for true."""
    text = (text or "").strip()
    return text.lower() in ("true", "yes") or text == "1"


def link_element(elements: Iterable[Node], robot: Node) -> Node:
    """The <link> of a link with the <gazebo> elements of all that is merged into it.

    Args:
        elements: in the order in which sdformat has them, see Merging.

    Returns:
        A <link> with flags and what is copied; <inertial> and <pose> as in the file alone.
    """
    link = _made("link", robot)
    for element in elements:
        off = text_of(element, "turnGravityOff")
        falls = off is None or off.lower() in ("false", "no") or off == "0"
        _put(link, "gravity", "true" if falls else "false", element)
        decay = _add(link, "velocity_decay", element)
        damping = text_of(element, "dampingFactor")
        if damping is not None:
            _put(decay, "linear", damping, element)
            _put(decay, "angular", damping, element)
        collides = text_of(element, "selfCollide")
        if collides is not None:
            _put(link, "self_collide", "1" if is_yes(collides) else "0", element)
        link.extend(copies(element))
    return link


def joint_element(elements: Iterable[Node], robot: Node) -> Node:
    """The <axis> and <physics> of a joint, with what is copied behind them."""
    joint = _made("joint", robot)
    dynamics = _add(_add(joint, "axis", robot), "dynamics", robot)
    physics = _add(joint, "physics", robot)
    ode = _add(physics, "ode", robot)
    limit = _add(ode, "limit", robot)
    for element in elements:
        for into, tags in ((limit, OF_LIMIT), (dynamics, OF_AXIS)):
            _put_numbers(into, tags, element)
        feedback, damping = text_of(element, "provideFeedback"), text_of(element, *DAMPING)
        for into in (physics, ode):
            if feedback is not None:
                _put(into, "provide_feedback", str(is_yes(feedback)).lower(), element)
        if damping is not None:
            _put(ode, "implicit_spring_damper", str(is_yes(damping)).lower(), element)
        _put_numbers(ode, {"fudgeFactor": "fudge_factor"}, element)
        joint.extend(copies(element))
    return joint


def model_element(elements: Iterable[Node], robot: Node) -> Node:
    """The <model> with the <gazebo> elements without a reference.

    Each says whether the model is static, so that the last one counts.
    """
    model = _made("model", robot)
    for element in elements:
        static = "true" if is_yes(text_of(element, "static")) else "false"
        _put(model, "static", static, element)
        model.extend(copies(element))
    return model


def collision_element(elements: Iterable[Node], robot: Node) -> Node:
    """The <collision> of a link's shapes, without <pose> and <geometry>, which are the file's.

    A <surface> that is copied replaces the one that there is. (Where that had a <contact> or
    <friction> and the new one has none, sdformat crashes as soon as it writes there.)
    """
    made = _made("collision", robot)
    for element in elements:
        for blob in (blob for block in element if block.tag == "collision" for blob in block):
            replaced = made.find("surface") if blob.tag == "surface" else None
            if replaced is not None:
                made.remove(replaced)
            made.append(copied(blob))
        for tag, keys in (("contact", OF_CONTACT), ("friction", OF_FRICTION)):
            part = _found(_found(made, "surface", element), tag, element)
            _put_numbers(_found(part, "ode", element), keys, element)
        _put_numbers(made, OF_COLLISION, element)
    return made


def visual_element(elements: Iterable[Node], robot: Node) -> Node:
    """The <visual> of a link's shapes with what is copied, besides its <material>."""
    visual = _made("visual", robot)
    for block in (child for element in elements for child in element if child.tag == "visual"):
        visual.extend(copied(blob) for blob in block if blob.tag != "material")
    return visual


class Merging:
    """The <gazebo> elements of a URDF, by the link that they hold for.

    Args:
        groups: links that remain -> these and those that fixed joints merge into them, in the order
            in which sdformat merges them.
    """

    def __init__(self, elements: Sequence[Node], groups: Mapping[str, Sequence[str]]) -> None:
        self._of: dict[str, list[Node]] = {}
        for element in elements:
            self._of.setdefault(element.get("reference") or "", []).append(element)
        self.groups = groups

    def of(self, name: str) -> list[Node]:
        """Those with this reference; "": with none."""
        return self._of.get(name, [])

    def of_group(self, name: str) -> list[Node]:
        """Those of a link that remains, with those of what is merged into it."""
        return [element for link in self.groups[name] for element in self.of(link)]


def copies(element: Node) -> list[Node]:
    """Copies of what a <gazebo> element has that sdformat does not convert."""
    return [copied(child) for child in element if child.tag not in CONVERTED]


def _made(tag: str, like: Node) -> Node:
    node = Node(tag)
    node.document, node.line = like.document, like.line
    return node


def _add(parent: Node, tag: str, like: Node) -> Node:
    node = _made(tag, like)
    parent.append(node)
    return node


def _found(parent: Node, tag: str, like: Node) -> Node:
    node = parent.find(tag)
    return _add(parent, tag, like) if node is None else node


def _put(parent: Node, tag: str, text: str, like: Node) -> None:
    """As AddKeyValue of sdformat: an element at the end, for the first one of its name."""
    old = parent.find(tag)
    if old is not None:
        parent.remove(old)
    _add(parent, tag, like).text = text


def _put_numbers(parent: Node, tags: Mapping[str, str], element: Node) -> None:
    for tag, name in tags.items():
        text = text_of(element, tag)
        if text is not None:
            _put(parent, name, text, element)
