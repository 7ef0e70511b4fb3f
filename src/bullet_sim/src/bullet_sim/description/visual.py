"""What a body looks like: its links as a tree of joints, with their visuals."""

from dataclasses import dataclass

from bullet_sim.description.parts import Shape
from bullet_sim.pose import Pose


@dataclass(frozen=True)
class VisualLink:
    """A link of a body.

    Attributes:
        parent: row of its parent in the body's links; -1: it is the root.
        origin: of its frame in the parent's at joint position 0.
        kind: 'fixed', 'revolute' (continuous, too) or 'prismatic'.
        axis: of length 1 in its frame.
        shapes: its visuals.
    """

    parent: int = -1
    origin: Pose = Pose()
    kind: str = "fixed"
    axis: tuple[float, float, float] = (1.0, 0.0, 0.0)
    shapes: tuple[Shape, ...] = ()


def visual_links(lumped, order, visuals=None):
    """VisualLinks of a LumpedModel.

    Args:
        lumped: LumpedModel.
        order: names of its links, the root first, in the order of the snapshot's joints.
        visuals: link name -> Shapes to use instead of the links' own.

    Returns:
        Tuple of VisualLink; a joint is before those below it if `order` is so.
    """
    joints = {joint.child: joint for joint in lumped.joints}
    rows = {name: row for row, name in enumerate(order)}
    found = []
    for name in order:
        shapes = tuple(lumped.links[name].visuals if visuals is None else visuals[name])
        joint = joints.get(name)
        if joint is None:
            found.append(VisualLink(shapes=shapes))
            continue
        kind = {"prismatic": "prismatic", "fixed": "fixed"}.get(joint.kind, "revolute")
        found.append(VisualLink(rows[joint.parent], joint.origin, kind, tuple(joint.axis), shapes))
    return tuple(found)


def depth_first(lumped):
    """Names of a LumpedModel's links, each followed by those below it."""
    below = {}
    for joint in lumped.joints:
        below.setdefault(joint.parent, []).append(joint.child)
    pending, found = [lumped.root], []
    while pending:
        name = pending.pop()
        found.append(name)
        pending += reversed(below.get(name, ()))
    return found
