"""What a model is made of, whatever file format it came from."""

from dataclasses import dataclass, field
from typing import Dict, List, Optional, Tuple

import numpy as np

from bullet_sim.pose import Pose

MOVABLE_TYPES = ('revolute', 'continuous', 'prismatic')


@dataclass
class Geometry:
    """A shape: box (size [m]), cylinder (radius, length), sphere (radius), plane, or mesh."""

    kind: str
    size: Tuple[float, ...] = ()
    path: str = ''
    scale: Tuple[float, float, float] = (1.0, 1.0, 1.0)


@dataclass
class Shape:
    """A visual or a collision: geometry at a pose in its link's frame, colour RGBA 0..1."""

    geometry: Geometry
    pose: Pose = Pose()
    color: Optional[Tuple[float, float, float, float]] = None


@dataclass
class Surface:
    """Contact properties; None: the engine's default."""

    friction: Optional[float] = None
    stiffness: Optional[float] = None
    damping: Optional[float] = None


@dataclass
class Link:
    """A rigid part: mass [kg], centre of mass in the link frame, inertia (3, 3) about it."""

    name: str
    mass: float = 0.0
    centre: np.ndarray = field(default_factory=lambda: np.zeros(3))
    inertia: np.ndarray = field(default_factory=lambda: np.zeros((3, 3)))
    visuals: List[Shape] = field(default_factory=list)
    collisions: List[Shape] = field(default_factory=list)
    surface: Surface = field(default_factory=Surface)


@dataclass
class Joint:
    """A joint: origin of the child's frame in the parent's, unit axis in the child's frame.

    Limits: lower/upper [rad, m] (None: none), effort [N m, N], velocity [rad/s, m/s];
    0 effort or velocity means that the file gives none.
    """

    name: str
    kind: str
    parent: str
    child: str
    origin: Pose = Pose()
    axis: Tuple[float, float, float] = (1.0, 0.0, 0.0)
    lower: Optional[float] = None
    upper: Optional[float] = None
    effort: float = 0.0
    velocity: float = 0.0
    damping: float = 0.0
    friction: float = 0.0


@dataclass
class ModelDescription:
    """A whole model.

    Attributes:
        links, joints: by name, in file order.
        root: name of the root link.
        sensors: sensor specifications (see specs.py).
        control_namespace: namespace of the ros_control plugin; None: the model has none.
        static: never moves.
        warnings: what was ignored or mended, one sentence each.
    """

    name: str
    links: Dict[str, Link] = field(default_factory=dict)
    joints: Dict[str, Joint] = field(default_factory=dict)
    root: str = ''
    sensors: List[object] = field(default_factory=list)
    control_namespace: Optional[str] = None
    static: bool = False
    warnings: List[str] = field(default_factory=list)

    def warn(self, text):
        """Note something that was ignored or mended, once."""
        if text not in self.warnings:
            self.warnings.append(text)

    def joints_of(self, parent):
        """Joints whose parent is the given link, in file order."""
        return [joint for joint in self.joints.values() if joint.parent == parent]

    def unreachable(self):
        """Links that no chain of joints connects to the root: those of a loop, and below it."""
        found = [self.root]
        for name in found:
            found += [j.child for j in self.joints_of(name) if j.child not in found]
        return [name for name in self.links if name not in found]
