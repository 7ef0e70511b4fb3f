"""Poses of an SDF model's parts in the model's frame, with <pose relative_to> of SDF 1.7."""

from bullet_sim.formats.xml_read import child_text, sdf_pose
from bullet_sim.pose import Pose


class Frames:
    """Frames of one <model>: its links, joints, <frame>s and nested models.

    Args:
        element: the <model>.
        name: of the model, for messages.
    """

    def __init__(self, element, name):
        self._name = name
        self._given, self._known = {}, {"__model__": Pose(), "": Pose(), "world": Pose()}
        for tag in ("link", "model", "frame", "joint", "include"):
            for part in element.findall(tag):
                key = part.get("name") or child_text(part, "name") or ""
                if key:
                    self._given.setdefault(key, (part, self._default(part, tag)))
        self._busy = []

    @staticmethod
    def _default(part, tag):
        if tag == "joint":
            return child_text(part, "child", "")
        return part.get("attached_to") or "" if tag == "frame" else ""

    def pose(self, name, element=None):
        """Pose of a named frame in the model's frame.

        Args:
            name: of the frame; one that does not exist, or is relative to itself in a circle,
                counts as the model's frame.
            element: Node that names it and takes the warning.
        """
        if name in self._known:
            return self._known[name]
        if name not in self._given:
            outer, _, inner = name.partition("::")
            if inner and outer in self._given:  # a frame inside a nested model
                part, _ = self._given[outer]
                return self.pose(outer, element) * Frames(part, name).pose(inner, element)
            return self._of_model(
                element,
                f"model '{self._name}' has no frame '{name}'; frames are {', '.join(self._given)}",
                name,
            )
        part, default = self._given[name]
        if name in self._busy:
            return self._of_model(
                part,
                f"frames of model '{self._name}' are relative to each other in a "
                f"circle: {', '.join(self._busy)}",
                name,
            )
        self._busy.append(name)
        pose = self.place(part, default, f"'{name}' of '{self._name}'")
        self._busy.remove(name)
        self._known[name] = pose
        return pose

    @staticmethod
    def _of_model(element, text, name):
        if element is not None:
            element.warn(
                f"{text}; the model's frame is used",
                "frames do not exist or lead in a circle; the model's frame is used",
                f"'{name}'",
            )
        return Pose()

    def place(self, element, default, what):
        """Pose of an element with a <pose> in the model's frame.

        Args:
            element: e.g. a <visual>.
            default: name of the frame that its pose is relative to when it names none.
            what: for messages.
        """
        found = element.find("pose")
        base = (found.get("relative_to") if found is not None else None) or default
        return self.pose(base, element) * sdf_pose(element, what)
