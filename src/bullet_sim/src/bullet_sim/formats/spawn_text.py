"""Texts of spawn requests as gazebo_ros sorts them: URDF, SDF, a light; what takes their name."""

import re
from dataclasses import dataclass

from bullet_sim.errors import SimError
from bullet_sim.xml_reader import Node, add_child, parse

_FIRST_TAG = re.compile(r"<\s*([A-Za-z_][\w.-]*)")


@dataclass(frozen=True)
class SpawnText:
    """A text.

    Attributes:
        text: what a reader of the format takes: the root, or the text where it is not XML.
        kind: "urdf" (<robot>), "sdf" (<sdf> or, of old, <gazebo>), "light" (an <sdf> that begins
            with a <light>) or "" for any other root.
        tag: name of its root.
        takes_request: whether the name and the pose of the request apply. In gazebo_ros they do
            for a <robot>, the first <model> of an <sdf>, or the first <include> of its <world>.
    """

    text: "Node | str | bytes"
    kind: str
    tag: str
    takes_request: bool = True

    @classmethod
    def read(cls, text: "str | bytes", namespace: str) -> "SpawnText":
        """Sort the text of a request.

        Args:
            namespace: written into <robotNamespace> of each <plugin> that has none; empty: of none.
        """
        try:
            root = parse(text, "model")
        except SimError:  # its reader says why
            first = _FIRST_TAG.search(_plain(text))
            tag = first.group(1) if first else ""
            return cls(text, _KINDS.get(tag, ""), tag)
        if namespace:
            for plugin in root.iter("plugin"):
                if plugin.find("robotNamespace") is None:
                    add_child(plugin, "robotNamespace", namespace)
        kind = _KINDS.get(root.tag, "")
        if kind == "sdf" and len(root) and root[0].tag.lower() == "light":
            return cls(root, "light", root.tag)
        takes = kind != "sdf" or (
            root.tag == "sdf"
            and (root.find("model") is not None or root.find("world/include") is not None)
        )
        return cls(root, kind, root.tag, takes)

    @property
    def light(self) -> Node:
        """The <light> of a text of that kind."""
        assert isinstance(self.text, Node)
        return self.text[0]


_KINDS = {"robot": "urdf", "sdf": "sdf", "gazebo": "sdf"}


def _plain(text: "str | bytes") -> str:
    """The start of a text without declarations and comments."""
    text = text.decode("latin-1") if isinstance(text, bytes) else text
    return re.sub(r"<[?!].*?>", "", text[:10_000], flags=re.DOTALL)
