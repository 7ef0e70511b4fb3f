"""Joints of URDF and SDF: types, axes, limits, and the tree that they form."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import inf
from typing import Tuple

import numpy as np

from bullet_sim.description.model import (
    MOVABLE_TYPES,
    WORLD_LINK,
    Gears,
    Joint,
    Link,
    Mimic,
    ModelDescription,
    SoftLimits,
)
from bullet_sim.formats.sdf.frames import Frames
from bullet_sim.pose import Pose, Vec3, Vector
from bullet_sim.xml_reader import (
    Node,
    child_bound,
    child_flag,
    child_floats,
    child_number,
    child_text,
    is_true,
    urdf_origin,
)

Version = Tuple[int, int]  # (major, minor) of an SDF document
UNLIMITED = 1e9  # [rad, m] replaces a missing limit on one side
NOTHING = 1e-300  # a limit of 0 for efforts and velocities, of which 0 means that there is none
_FORCES = ("effort", "velocity")


def unit_axis(vector: Vector, default: Vec3, label: str, element: Node) -> Vec3:
    """Unit vector of a joint's axis; the default, with a warning, for a zero vector.

    Args:
        vector: (3,).
        default: unit vector.
    """
    length = float(np.linalg.norm(vector))
    if length >= 1e-9:
        x, y, z = (np.asarray(vector, float) / length).tolist()
        return x, y, z
    used = " ".join(f"{value:g}" for value in default)
    element.warn(
        f"{label} axis is zero, must have a direction; {used} is used",
        "joint axes are zero; the format's default is used",
        label,
    )
    return default


def set_limits(
    joint: Joint, lower: float | None, upper: float | None, label: str, element: Node
) -> None:
    """Set a joint's limits [rad, m], None for none; swapped ones are ignored, as in ODE.

    Args:
        lower, upper: [rad, m].
    """
    if lower is None and upper is None:  # PyBullet has both or neither
        return
    lower = -UNLIMITED if lower is None else lower
    upper = UNLIMITED if upper is None else upper
    if lower > upper:
        element.warn(
            f"{label} has lower limit {lower} above upper {upper}; it has no limits, as in Gazebo",
            "joints have a lower limit above the upper one and so no limits",
            label,
        )
        return
    joint.lower, joint.upper = lower, upper


class Tree:
    """How the links of a model hang on each other, while its joints are read."""

    def __init__(self, joints: Iterable[Joint] = ()) -> None:
        self.above: dict[str, str] = {}  # child -> parent
        self._parents: set[str] = set()
        for joint in joints:
            self.add(joint)

    def add(self, joint: Joint) -> None:
        if not joint.closes:
            self.above[joint.child] = joint.parent
            self._parents.add(joint.parent)

    def would_loop(self, parent: str | None, child: str | None) -> bool:
        """Whether a joint between two links would close a loop."""
        while parent != child and child in self._parents and parent is not None:
            parent = self.above.get(parent)
        return parent == child


UNSUPPORTED_TYPES = ("floating", "planar")
URDF_TYPES = MOVABLE_TYPES + ("fixed",) + UNSUPPORTED_TYPES
SKIPPED = "joints are left out"


def read_joints(robot: Node, model: ModelDescription) -> None:
    """Add every valid <joint> of a <robot> to the model; others cause warnings."""
    tree = Tree()
    for element in robot.findall("joint"):
        joint = _joint(element, model, tree)
        if joint is not None:
            model.joints[joint.name] = joint
            tree.add(joint)


def _joint(element: Node, model: ModelDescription, tree: Tree) -> Joint | None:
    name = element.get("name") or ""
    label = f"joint '{name}' of '{model.name}'"
    parent, child = (
        end.get("link") if end is not None else None
        for end in (element.find("parent"), element.find("child"))
    )
    error = _urdf_error(name, parent, child, model, tree)
    if error:
        element.warn(f"{label} {error}; it is left out", SKIPPED, f"'{name}'")
        return None
    joint_type, origin = _joint_type(element, label, URDF_TYPES), urdf_origin(element, label)
    joint = Joint(name, joint_type, str(parent), str(child), origin)
    axis = element.find("axis")
    if axis is not None:
        vector = child_floats(axis, "@xyz", 3, f"{label} axis", (1.0, 0.0, 0.0))
        if joint.kind in MOVABLE_TYPES:
            joint.axis = unit_axis(vector, joint.axis, label, element)
    _limit(element, joint, label)
    dynamics = element.find("dynamics")
    if dynamics is not None:
        joint.damping = max(0.0, child_number(dynamics, "@damping", label, 0.0))
        joint.friction = max(0.0, child_number(dynamics, "@friction", label, 0.0))
    joint.mimic = _mimic(element, joint, label)
    joint.safety = _safety(element, joint, label)
    return joint


def _safety(element: Node, joint: Joint, label: str) -> SoftLimits | None:
    """<safety_controller>, of which urdfdom demands k_velocity."""
    safety = element.find("safety_controller")
    if safety is None or joint.kind not in MOVABLE_TYPES:
        return None
    if safety.get("k_velocity") is None:
        safety.warn(
            f"{label} safety_controller has no k_velocity, which URDF demands; it is ignored",
            "safety_controllers have no k_velocity, which URDF demands, and are ignored",
            f"'{joint.name}'",
        )
        return None
    keys = ("soft_lower_limit", "soft_upper_limit", "k_position", "k_velocity")
    where = f"{label} safety_controller"
    return SoftLimits(*(child_number(safety, f"@{key}", where, 0.0) for key in keys))


def _mimic(element: Node, joint: Joint, label: str) -> Mimic | None:
    mimic = element.find("mimic")
    if mimic is None or joint.kind not in MOVABLE_TYPES:
        return None
    return Mimic(
        mimic.get("joint") or "",
        child_number(mimic, "@multiplier", f"{label} mimic", 1.0),
        child_number(mimic, "@offset", f"{label} mimic", 0.0),
    )


def check_mimics(model: ModelDescription) -> None:
    """Drop a <mimic> of a joint that does not exist, with a warning, or of a commanded joint."""
    for joint in model.joints.values():
        if joint.mimic is None:
            continue
        other = model.joints.get(joint.mimic.joint)
        if other is None or other is joint or other.kind not in MOVABLE_TYPES:
            model.warn(
                f"joint '{joint.name}' of '{model.name}' mimics '{joint.mimic.joint}', which is no "
                "other joint that moves; it moves freely",
                "joints mimic what is no other joint that moves, and move freely",
                f"'{joint.name}'",
            )
            joint.mimic = None
        elif joint.name in model.transmissions.joints:
            joint.mimic = None  # controllers move it


def _urdf_error(
    name: str, parent: str | None, child: str | None, model: ModelDescription, tree: Tree
) -> str:
    """Why an element is no valid joint, or ''."""
    if not name:
        return "has no name"
    if name in model.joints:
        return "is there already: there are two joints of that name"
    for end, link in (("parent", parent), ("child", child)):
        if link not in model.links:
            return f"has {end} link '{link}', which does not exist; links are " + ", ".join(
                model.links
            )
    if child in tree.above:
        return f"gives link '{child}' more than one parent joint"
    return "closes a loop" if tree.would_loop(parent, child) else ""


def _joint_type(element: Node, label: str, types: tuple[str, ...]) -> str:
    """Type of a <joint>; one that is none of `types` becomes fixed, with a warning."""
    given = element.get("type")
    if given in types:
        return given
    lower = str(given).strip().lower()
    used = lower if lower in types else "fixed"
    element.warn(
        f"{label} has type '{given}', must be one of {', '.join(types)}; {used} is used",
        f"joints have type '{given}', which is not known here, and are {used}",
        label,
    )
    return used


def _limit(element: Node, joint: Joint, label: str) -> None:
    limit = element.find("limit")
    bounded = joint.kind in ("revolute", "prismatic")
    if limit is None:
        if bounded:
            element.warn(
                f"{label} has no <limit>; it moves without limits",
                "joints that need a <limit> have none and move without limits",
                f"'{joint.name}'",
            )
        return
    given = (child_bound(limit, f"@{key}", f"{label} limit") for key in _FORCES)
    effort, velocity = (inf if value is None else abs(value) for value in given)
    joint.limit = effort, velocity
    joint.effort, joint.velocity = (0.0 if v == inf else v or NOTHING for v in joint.limit)
    for key in _FORCES:
        if limit.get(key) is None and joint.kind != "fixed":
            limit.warn(
                f"{label} limit has no {key}, which URDF demands; it has no such limit",
                f"joint limits have no {key}, which URDF demands, and count as unlimited",
                f"'{joint.name}'",
            )
    if not bounded:
        return
    lower = child_bound(limit, "@lower", f"{label} limit", 0.0)
    upper = child_bound(limit, "@upper", f"{label} limit", 0.0)
    if joint.kind == "revolute" and lower is not None and upper is not None and lower > upper:
        limit.warn(
            f"{label} has lower limit {lower} above upper {upper}; they are exchanged",
            "joints have a lower limit above the upper one; they are exchanged, as in Gazebo",
            f"'{joint.name}'",
        )
        lower, upper = upper, lower
    set_limits(joint, lower, upper, label, element)


# Joints of several axes become a chain of hinges: the tags of their axes, or the axes.
CHAINS: dict[str, tuple[str | Vec3, ...]] = {
    "universal": ("axis", "axis2"),
    "revolute2": ("axis", "axis2"),
    "ball": ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
}
MASS_RATIO = 0.01  # mass and inertia of a link within such a chain, of those of its child
SDF_OF_URDF = (1, 7)  # the version of what sdformat makes of a URDF
SDF_TYPES = ("fixed", "revolute", "prismatic", "continuous", "screw", "gearbox", *CHAINS)
_UP = (0.0, 0.0, 1.0)


def _ends_error(model: ModelDescription, parent: str | None, child: str | None) -> str:
    """Why a joint has no two links, or ''."""
    if child not in model.links or parent not in model.links:
        return f"joins '{parent}' and '{child}', links are {', '.join(model.links)}"
    return f"joins '{child}' to itself" if parent == child else ""


# Attribute of a Joint -> path of its number, {} is the axis, its default, and that beside an <ode>.
_AXIS_NUMBERS: dict[str, tuple[str, float | None, float | None]] = {
    "damping": ("{}/dynamics/damping", 0.0, 0.0),
    "friction": ("{}/dynamics/friction", 0.0, 0.0),
    "stiffness": ("{}/dynamics/spring_stiffness", 0.0, 0.0),
    "rest": ("{}/dynamics/spring_reference", 0.0, 0.0),
    "stop_erp": ("physics/ode/limit/erp", None, 0.2),
    "stop_cfm": ("physics/ode/limit/cfm", None, 0.0),
    "stop_push": ("physics/ode/fudge_factor", 1.0, 1.0),
    "erp": ("physics/ode/erp", None, None),
    "cfm": ("physics/ode/cfm", None, None),
    "bounce": ("physics/ode/bounce", 0.0, 0.0),
}
_OF_GAZEBO = ("stiffness", "rest", "stop_erp", "stop_cfm", "stop_push")  # of a URDF


def read_dynamics(
    element: Node, joint: Joint, label: str, tag: str = "axis", names: Sequence[str] = _OF_GAZEBO
) -> None:
    """Read springs, limits and rows of a <joint> as ODEJoint::Load of Gazebo 11 does.

    Args:
        tag: of the axis.
        names: attributes of the Joint to set.
    """
    text = child_text(element, "physics/ode/implicit_spring_damper", "false")
    joint.implicit_damping = is_true(text)
    has_ode = element.find("physics/ode") is not None
    for name in names:
        path, without, beside = _AXIS_NUMBERS[name]
        default = beside if has_ode else without
        setattr(joint, name, child_number(element, path.format(tag), label, default))


class JointReader:
    """Adds the <joint>s of one <model> to a model.

    Args:
        poses: of the model's links in its frame, by name; links that a joint needs are added.
        prefix: of the names of the nested model that the joints are in.
        version: of the SDF document.
        tree: of the model's joints so far.
    """

    def __init__(
        self,
        model: ModelDescription,
        poses: dict[str, Pose],
        prefix: str,
        frames: Frames,
        version: Version,
        tree: Tree,
    ) -> None:
        self._model, self._poses, self._prefix = model, poses, prefix
        self._frames, self._version, self._tree = frames, version, tree

    def read(self, element: Node) -> None:
        """Add a <joint>, or warn why that is impossible."""
        model = self._model
        name = self._prefix + (element.get("name") or "joint")
        label = f"joint '{name}' of '{model.name}'"
        joint_type = _joint_type(element, label, SDF_TYPES)
        parent, child = self._ends(element, joint_type)
        if parent is None:
            joint = Joint(name, "fixed", WORLD_LINK, child, self._poses[child], closes=True)
            model.joints[name] = joint
            return
        error = _ends_error(model, parent, child)
        if error:
            item = f"'{name}' of '{model.name}'"
            element.warn(f"{label} {error}; it is left out", SKIPPED, item)
            return
        anchor = Pose()
        if element.find("pose") is not None:
            default = child_text(element, "child", "")
            pose = self._frames.pose_of(element, default, label)
            anchor = self._frames.pose(default).inverse() * pose
        origin = self._poses[parent].inverse() * self._poses[child]
        joint = Joint(name, joint_type, parent, child, origin, anchor=anchor)
        joint.closes = child in self._tree.above or self._tree.would_loop(parent, child)
        if joint_type == "gearbox":
            self._add_gears(element, joint, label)
        elif joint_type in CHAINS:
            self._add_chain(element, joint, label)
        else:
            if joint_type != "fixed":
                self._read_axis(element, joint, label)
            if joint_type == "screw":  # ODE's sign
                joint.thread = -child_number(element, "thread_pitch", label, 1.0) or 1.0
            model.joints[name] = joint
            self._tree.add(joint)

    def _ends(self, element: Node, joint_type: str) -> tuple[str | None, str]:
        """Names of parent and child; the first is None where a joint fixes a link to the world."""
        parent, child = child_text(element, "parent"), child_text(element, "child")
        if child == WORLD_LINK and joint_type == "fixed":
            parent, child = child, parent
        name = self._prefix + str(child)
        if parent != WORLD_LINK or name not in self._model.links:
            return self._prefix + str(parent), name
        self._model.fixed_base = True
        if joint_type == "fixed":
            return None, name
        self._model.links.setdefault(WORLD_LINK, Link(WORLD_LINK))
        self._poses.setdefault(WORLD_LINK, Pose())
        return WORLD_LINK, name

    def _add_gears(self, element: Node, joint: Joint, label: str) -> None:
        """Add the gears of a gearbox joint, which is between links that other joints hold."""
        model, base = self._model, child_text(element, "gearbox_reference_body", "")
        if self._prefix + base not in model.links:
            element.warn(
                f"{label} has the reference body '{base}', links are {', '.join(model.links)}; "
                "it is left out",
                SKIPPED,
                f"'{joint.name}' of '{model.name}'",
            )
            return
        axes = []
        for tag in ("axis", "axis2"):
            self._read_axis(element, joint, label, tag)
            axes.append(joint.axis)
        first, second = joint.anchor.matrix, (joint.origin * joint.anchor).matrix
        model.gears[joint.name] = Gears(
            joint.name,
            joint.child,
            joint.parent,
            self._prefix + base,
            unit_axis(first @ axes[0], _UP, label, element),
            unit_axis(second @ axes[1], _UP, label, element),
            child_number(element, "gearbox_ratio", label, 1.0),
            joint.erp,
            joint.cfm,
        )

    def _add_chain(self, element: Node, original: Joint, label: str) -> None:
        """Add the hinges that make up a joint of several axes, with small links between them.

        The first has the joint's name, the others have a number appended. The second axis of a ball
        joint must not rotate by 90 degrees.
        """
        links, axes = self._model.links, CHAINS[original.kind]
        child = links[original.child]
        parent, origin = original.parent, original.origin * original.anchor
        for index, axis in enumerate(axes, 1):
            last = index == len(axes)
            name = original.name if index == 1 else f"{original.name}__{index}"
            link = original.child if last else f"{original.name}__link{index}"
            if last:
                origin = origin * original.anchor.inverse()
            anchor = original.anchor if last else Pose()
            joint = Joint(name, "continuous", parent, link, origin, anchor=anchor)
            joint.closes = last and original.closes
            if isinstance(axis, str):
                joint.kind = "revolute"
                self._read_axis(element, joint, label, axis, original.anchor)
            else:
                joint.axis = axis
            self._model.joints[name] = joint
            self._tree.add(joint)
            if not last:
                moment = MASS_RATIO * max(float(child.inertia.trace()) / 3.0, 1e-6)
                mass = MASS_RATIO * max(child.mass, 1e-3)
                links[link] = Link(link, mass=mass, inertia=moment * np.eye(3))
                self._poses[link] = self._poses[original.child] * original.anchor
            parent, origin = link, Pose()

    def _read_axis(
        self, element: Node, joint: Joint, label: str, tag: str = "axis", anchor: Pose | None = None
    ) -> None:
        """Read an axis with its limits; anchor: joint frame in the child's; None: joint.anchor."""
        joint.axis = self._axis(
            element, joint, label, tag, joint.anchor if anchor is None else anchor
        )
        if joint.kind != "continuous":
            lower = child_bound(element, f"{tag}/limit/lower", label)
            upper = child_bound(element, f"{tag}/limit/upper", label)
            set_limits(joint, lower, upper, label, element)
        joint.effort, joint.velocity = (
            0.0 if bound is None or bound < 0.0 else bound or NOTHING
            for bound in (child_bound(element, f"{tag}/limit/{key}", label) for key in _FORCES)
        )
        read_dynamics(element, joint, label, tag, tuple(_AXIS_NUMBERS))
        joint.damping, joint.friction = max(0.0, joint.damping), max(0.0, joint.friction)
        if element.find(f"{tag}/dynamics/friction") is None and tag == "axis":
            joint.motor = (
                max(0.0, child_number(element, "physics/ode/max_force", label, joint.friction)),
                child_number(element, "physics/ode/velocity", label, 0.0),
            )

    def _axis(self, element: Node, joint: Joint, label: str, tag: str, anchor: Pose) -> Vec3:
        """Unit vector of an axis in the joint's frame."""
        vector = child_floats(element, f"{tag}/xyz", 3, f"{label} {tag}", _UP)
        of_model, before = False, self._version < (1, 5)
        if self._version < (1, 7):
            of_model = child_flag(element, f"{tag}/use_parent_model_frame", label, before)
        xyz = element.find(f"{tag}/xyz")
        frame = xyz.get("expressed_in") if xyz is not None else None
        if joint.kind == "screw":  # Gazebo 11 (ODEScrewJoint::SetAxis) takes it in the model's
            of_model, frame = True, None
        if of_model or frame:
            joint_frame = self._frames.pose(child_text(element, "child", "")) * anchor
            axis_frame = self._frames.pose(frame, xyz) if frame else Pose()
            vector = joint_frame.matrix.T @ axis_frame.matrix @ vector
        return unit_axis(vector, _UP, label, element)


def read_sdf_joints(robot: Node, model: ModelDescription) -> None:
    """Add the joints that a URDF has within <gazebo>, which sdformat copies; they close loops."""
    poses, tree = model.poses(), Tree(model.joints.values())
    for element in robot.findall("gazebo"):
        if element.get("reference") is not None:
            continue
        frames = Frames(element, model.name, poses=poses)
        reader = JointReader(model, poses, "", frames, SDF_OF_URDF, tree)
        for joint in element.findall("joint"):
            child = child_text(joint, "child")
            is_held = joint.get("type") == "fixed" and child == model.root
            if child_text(joint, "parent") != WORLD_LINK or is_held:
                reader.read(joint)
            else:
                joint.warn(
                    f"joint '{joint.get('name')}' of '{model.name}' joins '{child}' to the world, "
                    f"which a joint within <gazebo> must be fixed for, and of '{model.root}'; it "
                    "is left out",
                    SKIPPED,
                    f"'{joint.get('name')}' of '{model.name}'",
                )
