"""Frames of an SDF model or world and their poses, which are relative to each other."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping

from bullet_sim.pose import Pose
from bullet_sim.xml_reader import Node, child_text, sdf_pose

_PARTS = {"world": ("model", "include", "frame")}
_PARTS_OF_MODEL = ("link", "model", "frame", "joint")


class Frames:
    """Frames of one <model>: its links, joints, <frame>s and nested models; or those of a <world>:
    its models, includes and <frame>s.

    Args:
        element: <model> or <world>.
        name: of it, for messages.
        open_include: of an <include> of a world the <model> of its file; it may raise OSError or
            ValueError.
        poses: of frames that are described elsewhere, by name.
    """

    def __init__(
        self,
        element: Node,
        name: str,
        open_include: Callable[[Node], Node] | None = None,
        poses: Mapping[str, Pose] | None = None,
    ) -> None:
        self._name, self._kind, self._open = name, element.tag, open_include
        self._elements: dict[str, tuple[Node, str]] = {}
        self._poses = {"__model__": Pose(), "": Pose(), "world": Pose(), **(poses or {})}
        self._unnamed: list[Node] = []  # includes whose file has their name
        for tag in _PARTS.get(element.tag, _PARTS_OF_MODEL):
            for part in element.findall(tag):
                key = child_text(part, "name") if tag == "include" else part.get("name")
                if key:
                    self._elements.setdefault(key, (part, self._default(part, tag)))
                elif tag == "include":
                    self._unnamed.append(part)

    @staticmethod
    def _default(part: Node, tag: str) -> str:
        if tag == "joint":
            return child_text(part, "child", "")
        return part.get("attached_to") or "" if tag == "frame" else ""

    def pose(self, name: str, element: Node | None = None) -> Pose:
        """Pose of a named frame in the model's frame, or in the world.

        Args:
            name: of the frame; one that does not exist, or is relative to itself in a circle,
                is replaced by the model's frame, or the world.
            element: that names it; takes the warning.
        """
        waiting: dict[str, None] = {}  # each relative to the next; not by recursion: ropes are long
        while name not in self._poses and name not in waiting:
            if name not in self._elements:
                self._name_includes()
            if name not in self._elements:
                break
            waiting[name] = None
            element, default = self._elements[name]
            name = self._base(self._placed(element), default)
        pose = self._poses[name] if name in self._poses else self._end(name, element, waiting)
        for name in reversed(waiting):
            placed = self._placed(self._elements[name][0])
            if placed is None:
                pose = Pose()
            else:
                pose = pose * sdf_pose(placed, f"'{name}' of '{self._name}'")
            self._poses[name] = pose
        return pose

    def _end(self, name: str, element: Node | None, waiting: Collection[str]) -> Pose:
        """Pose of a frame that is not among the elements, or for which its own pose waits."""
        if name in waiting:
            return self._model_frame(
                element,
                f"frames of model '{self._name}' are relative to each other in a "
                f"circle: {', '.join(waiting)}",
                name,
            )
        outer, _, inner = name.partition("::")
        if inner and outer in self._elements:  # a frame inside a nested model
            part, _ = self._elements[outer]
            return self.pose(outer, element) * Frames(part, name).pose(inner, element)
        return self._model_frame(
            element,
            f"{self._kind} '{self._name}' has no frame '{name}'; frames are "
            f"{', '.join(self._elements)}",
            name,
        )

    def _name_includes(self) -> None:
        """Read the names of included models that have none but their file's."""
        unnamed, self._unnamed = self._unnamed, []
        for include in unnamed:
            try:
                name = self._open(include).get("name") if self._open else None
            except (OSError, ValueError):
                continue  # whoever reads the world warns of it
            self._elements.setdefault(name or "", (include, ""))

    def _model_frame(self, element: Node | None, text: str, name: str) -> Pose:
        if element is not None:
            element.warn(
                f"{text}; the {self._kind}'s frame is used",
                f"frames do not exist or lead in a circle; the {self._kind}'s frame is used",
                f"'{name}'",
            )
        return Pose()

    def pose_of(self, element: Node, default: str, label: str) -> Pose:
        """Pose of an element with a <pose> in the model's frame, or in the world.

        That of an <include> without one is the pose of the <model> of its file.

        Args:
            default: name of the frame that its pose is relative to when it names none.
        """
        placed = self._placed(element)
        if placed is None:
            return Pose()
        return self.pose(self._base(placed, default), placed) * sdf_pose(placed, label)

    def _placed(self, element: Node) -> Node | None:
        """The element whose <pose> counts for one; None: it cannot be had."""
        if element.tag == "include" and element.find("pose") is None and self._open:
            try:
                return self._open(element)
            except (OSError, ValueError):
                return None
        return element

    @staticmethod
    def _base(placed: Node | None, default: str) -> str:
        """Name of the frame that an element's pose is relative to."""
        pose = None if placed is None else placed.find("pose")
        named = None if pose is None else pose.get("relative_to")
        return named or ("" if placed is None else default)
