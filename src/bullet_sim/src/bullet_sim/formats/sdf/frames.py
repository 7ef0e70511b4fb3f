"""Frames of an SDF model and their poses, which are relative to each other."""

from __future__ import annotations

from bullet_sim.pose import Pose
from bullet_sim.xml_reader import Node, child_text, sdf_pose


class Frames:
    """Frames of one <model>: its links, joints, <frame>s and nested models."""

    def __init__(self, element: Node, name: str) -> None:
        self._name = name
        self._elements: dict[str, tuple[Node, str]] = {}
        self._poses = {"__model__": Pose(), "": Pose(), "world": Pose()}
        for tag in ("link", "model", "frame", "joint"):
            for part in element.findall(tag):
                key = part.get("name") or ""
                if key:
                    self._elements.setdefault(key, (part, self._default(part, tag)))
        self._pending: list[str] = []

    @staticmethod
    def _default(part: Node, tag: str) -> str:
        if tag == "joint":
            return child_text(part, "child", "")
        return part.get("attached_to") or "" if tag == "frame" else ""

    def pose(self, name: str, element: Node | None = None) -> Pose:
        """Pose of a named frame in the model's frame.

        Args:
            name: of the frame; one that does not exist, or is relative to itself in a circle,
                is replaced by the model's frame.
            element: that names it; takes the warning.
        """
        if name in self._poses:
            return self._poses[name]
        if name not in self._elements:
            outer, _, inner = name.partition("::")
            if inner and outer in self._elements:  # a frame inside a nested model
                part, _ = self._elements[outer]
                return self.pose(outer, element) * Frames(part, name).pose(inner, element)
            return self._model_frame(
                element,
                f"model '{self._name}' has no frame '{name}'; frames are "
                f"{', '.join(self._elements)}",
                name,
            )
        part, default = self._elements[name]
        if name in self._pending:
            return self._model_frame(
                part,
                f"frames of model '{self._name}' are relative to each other in a "
                f"circle: {', '.join(self._pending)}",
                name,
            )
        self._pending.append(name)
        pose = self.pose_of(part, default, f"'{name}' of '{self._name}'")
        self._pending.remove(name)
        self._poses[name] = pose
        return pose

    @staticmethod
    def _model_frame(element: Node | None, text: str, name: str) -> Pose:
        if element is not None:
            element.warn(
                f"{text}; the model's frame is used",
                "frames do not exist or lead in a circle; the model's frame is used",
                f"'{name}'",
            )
        return Pose()

    def pose_of(self, element: Node, default: str, label: str) -> Pose:
        """Pose of an element with a <pose> in the model's frame.

        Args:
            default: name of the frame that its pose is relative to when it names none.
        """
        pose = element.find("pose")
        named = None if pose is None else pose.get("relative_to") or pose.get("frame")  # 1.6
        base = named or default
        return self.pose(base, element) * sdf_pose(element, label)
