"""What of SDF has an effect in Gazebo and none here: one warning by name.

docs/support has a row of state "ignored" for each, which a test compares with these.
"""

from __future__ import annotations

from collections.abc import Iterator

from bullet_sim.xml_reader import Node

NO, ZERO = ("false", "0"), ("0",)
# Path from the root of its description in sdformat -> values with which there is no difference,
# besides an empty text.
UNREAD: dict[str, tuple[str, ...]] = {
    "physics@type": ("ode",),
    "physics/ode/solver/type": ("quick",),
    "physics/ode/solver/precon_iters": ZERO,
    "physics/ode/solver/friction_model": ("pyramid_model",),
    "projector/texture": (),
    "projector/fov": (),
    "projector/near_clip": (),
    "projector/far_clip": (),
    "heightmap/texture/normal": (),
}
_SKIPPED = ("plugin", "actor")  # what they contain is none of SDF, or is left out as a whole
_BY_TAG: dict[str, list[tuple[str, ...]]] = {}
for _path in UNREAD:
    _parts = tuple(_path.split("/"))
    _BY_TAG.setdefault(_parts[-1], []).append(_parts)


def warn_unread(root: Node) -> None:
    """Warn of what an SDF document has that is ignored here, once for each element."""
    for path, node in _nodes(root, ()):
        _check(node, path, (node.text or "").strip())
        for key, value in node.attrib.items():
            _check(node, (*path[:-1], f"{path[-1]}@{key}"), value.strip())


def _nodes(node: Node, above: tuple[str, ...]) -> Iterator[tuple[tuple[str, ...], Node]]:
    path = (*above, node.tag)
    yield path, node
    for child in node:
        if isinstance(child.tag, str) and child.tag not in _SKIPPED:
            yield from _nodes(child, path)


def _check(node: Node, path: tuple[str, ...], value: str) -> None:
    for parts in _BY_TAG.get(path[-1], ()):
        if path[-len(parts) :] != parts:
            continue
        name = "/".join(parts)
        if value and not any(_same(value, other) for other in UNREAD[name]):
            node.warn(
                f"<{name}> is '{value}', which has an effect in Gazebo and is ignored here",
                f"<{name}> have an effect in Gazebo and are ignored here",
                f"'{value}'",
            )
        return


def _same(value: str, other: str) -> bool:
    """Whether two texts are alike, as numbers if they are."""
    one, two = value.lower().split(), other.split()
    return len(one) == len(two) and all(map(_alike, one, two))


def _alike(one: str, two: str) -> bool:
    try:
        return one == two or float(one) == float(two)
    except ValueError:
        return False
