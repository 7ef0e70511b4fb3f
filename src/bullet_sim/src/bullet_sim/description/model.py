"""A robot's description: links, joints, shapes, their appearance."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Tuple
from xml.etree.ElementTree import Element

import numpy as np

from bullet_sim.description.transmissions import Transmissions
from bullet_sim.description.warnings import Warnings
from bullet_sim.errors import ModelError
from bullet_sim.pose import Array, Pose, Vec3

RGB = Tuple[float, float, float]
RGBA = Tuple[float, float, float, float]


@dataclass(frozen=True)
class TextureMapping:
    """How an image lies on a surface.

    Attributes:
        transform: (a, b, c, d, e, f): the image is read at (a u + b v + c, d u + e v + f), v
            upwards; (): where the texture coordinates say.
        wrap: beyond its edges it is repeated (''), or its edge is ('clamp').
        filtering: '' trilinear, or 'nearest'.
        anisotropy: samples along the longer side of a pixel's footprint, 1: one.
    """

    transform: tuple[float, ...] = ()
    wrap: str = ""
    filtering: str = ""
    anisotropy: int = 1


@dataclass(frozen=True)
class Layer:
    """One more image on a surface, laid over its light and its first image.

    Attributes:
        path: of the image.
        operation: 'modulate' (multiplied), 'add', 'replace', 'alpha_blend' (by its own alpha) or
            'height' (by the height of the point, before the light).
        mapping: how it lies on the surface.
        blend: height [m] at which one of 'height' begins to cover what is below it, and the
            distance [m] within which it does so.
    """

    path: str
    operation: str = "modulate"
    mapping: TextureMapping = TextureMapping()
    blend: tuple[float, float] = (0.0, 1.0)


@dataclass(frozen=True)
class Finish:
    """Surface of a visual, RGB 0..1.

    Attributes:
        ambient: reflectance of ambient light; None: as the color.
        specular: of the highlights; None: the mesh's, or none.
        emissive: light that it emits.
        shininess: exponent of the highlights; 0: none.
        opacity: 1 opaque, 0 invisible; multiplies the color's.
        lit: False: rendered in its color, whatever the light.
        blend: how it is laid over what is behind it: '' it hides it (unless it is translucent),
            'alpha', 'add', 'modulate' or 'color'.
        rejection: points with an alpha of at most this are left out.
        double_sided: whether its back is rendered, too.
        mapping: of its texture.
        layers: further images, the lowest first.
        normal_map: path of an image of normals in the surface's axes; '': none.
        gloss: whether the alpha of its images is the strength of the highlights.
    """

    ambient: RGB | None = None
    specular: RGB | None = None
    emissive: RGB = (0.0, 0.0, 0.0)
    shininess: float = 24.0
    opacity: float = 1.0
    cast_shadows: bool = True
    lit: bool = True
    blend: str = ""
    rejection: float = 0.0
    double_sided: bool = False
    mapping: TextureMapping = TextureMapping()
    layers: tuple[Layer, ...] = ()
    normal_map: str = ""
    gloss: bool = False


PLAIN = Finish()


MOVABLE_TYPES = ("revolute", "continuous", "prismatic")
DEFAULT_SIM_TYPE = "gazebo_ros_control/DefaultRobotHWSim"
STEER_BOT_SIM_TYPE = "steer_bot_hardware_gazebo/SteerBotHardwareGazebo"


@dataclass
class Geometry:
    """A shape: box (size [m]), cylinder (radius, length), sphere (radius), plane, mesh, heightmap
    (size [m]), polyline (height [m]) or road (width [m]).

    Attributes:
        outlines: corners (x, y) of polylines [m]; what an odd number of them surrounds is filled.
        path, scale: file and size factors of a mesh; a negative factor mirrors.
        submesh: name of the only part of the mesh file to use; empty: all.
        centered: the submesh is moved so that its center is the origin.
        points: of the middle of a road [m].
        sampling: points of a heightmap for each pixel and side.
        flat: only the upper side of a box is rendered, which is a plane's.
        is_converted: the mesh file was made of another one, with its normals.
        relief: of a mesh: the heightmap of which its file was made.
    """

    kind: str
    size: tuple[float, ...] = ()
    path: str = ""
    scale: Vec3 = (1.0, 1.0, 1.0)
    submesh: str = ""
    centered: bool = False
    outlines: tuple[tuple[tuple[float, float], ...], ...] = ()
    points: tuple[Vec3, ...] = ()
    sampling: int = 2
    flat: bool = False
    is_converted: bool = False
    relief: Geometry | None = None


WORLD_LINK = "world"  # what a joint names whose other link it holds in the world
EVERYTHING = 0xFFFF  # collide_bitmask where none is given
EVERYWHERE = 0xFFFFFFFF  # visibility_flags where none are given
VISIBLE = 0x0FFFFFFC  # bits that sensors see; the others are those of Gazebo's window


@dataclass(frozen=True)
class Torsion:
    """Friction against turning about a contact's normal.

    Attributes:
        patch_radius: of what touches [m], if by_patch; else it is that of a surface with
            surface_radius [m] by the contact's depth.
        slip: angular velocity per moment [rad/(N m s)].
    """

    coefficient: float = 1.0
    patch_radius: float = 0.0
    surface_radius: float = 0.0
    by_patch: bool = True
    slip: float = 0.0


@dataclass
class Surface:
    """Contact properties of a link; None: not given.

    Attributes:
        friction, friction2: Coulomb coefficients along the first and the second direction.
        direction: the first direction (fdir1) in the link's frame.
        stiffness [N/m], damping [N s/m]: of the contact, where it is softer than Bullet's.
        kp [N/m], kd [N s/m]: the same as the file says, for the solver 'ode'.
        slip1, slip2: slip velocity per force along the two directions [m/(N s)], for the same.
        bitmask: two links touch where the AND of their masks is not 0.
        without_contact: contacts are told, but push nothing (collide_without_contact), ...
        without_contact_bitmask: ... where the AND of both masks is not 0.
        max_speed: at which a link that was spawned inside another is pushed out [m/s].
        min_depth: penetration that is not corrected then [m].
        bounce: restitution, of what comes faster than bounce_speed [m/s], for the solver 'ode';
            what is sent away is bounded by max_speed, as in Gazebo.
        torsion: for the same.
        most: contacts of a pair of shapes at most, for the same.
    """

    friction: float | None = None
    friction2: float | None = None
    direction: Vec3 | None = None
    stiffness: float | None = None
    damping: float | None = None
    kp: float | None = None
    kd: float | None = None
    slip1: float = 0.0
    slip2: float = 0.0
    bitmask: int = EVERYTHING
    without_contact: bool = False
    without_contact_bitmask: int = 1
    max_speed: float | None = None
    min_depth: float = 0.0
    bounce: float = 0.0
    bounce_speed: float = 1e5
    torsion: Torsion | None = None
    most: int = 10


@dataclass
class Shape:
    """A visual or a collision: geometry at a pose in its link's frame, color RGBA 0..1.

    Attributes:
        texture: path of a texture image; empty: none.
        painted: the color replaces a mesh's own materials.
        link: link that had it in the file, before links were merged.
        surface: contact properties of a collision, the direction in its own axes, for the solver
            'ode'; None: its link's.
        laser_retro: intensity that a lidar measures: of a collision, or of a visual for gpu_ray.
        visibility: of a visual, its visibility_flags.
        number: of a collision among those of its link in the file.
        given: its name in the file; empty: it has none, and `name` is made of its link's.
    """

    geometry: Geometry
    pose: Pose = Pose()
    color: RGBA | None = None
    texture: str = ""
    painted: bool = False
    name: str = ""
    link: str = ""
    finish: Finish = PLAIN
    surface: Surface | None = None
    laser_retro: float = 0.0
    visibility: int = EVERYWHERE
    number: int = 0
    given: str = ""

    def at(self, pose: Pose) -> Shape:
        """The same shape in a frame in which its current frame has the given pose."""
        return replace(self, pose=pose * self.pose)


LIGHT_TYPES = ("directional", "point", "spot")


@dataclass(frozen=True)
class Light:
    """One light.

    Attributes:
        kind: 'directional', 'point' or 'spot'.
        position: [m] in the world, or in its link's frame; meaningless for a directional light.
        direction: in which it shines, unit vector in the same.
        diffuse, specular: RGB 0..1.
        reach: maximum distance that is lit [m].
        constant, linear [1/m], quadratic [1/m^2]: the light decreases with 1 / (constant +
            linear d + quadratic d^2).
        inner, outer: full angles of a spot's cones [rad]: all of its light inside the inner one,
            none outside the outer one.
        falloff: exponent between the two.
        cast_shadows: whether it casts shadows; only those of a directional light are rendered.
    """

    name: str
    kind: str = "directional"
    position: Vec3 = (0.0, 0.0, 0.0)
    direction: Vec3 = (0.0, 0.0, -1.0)
    diffuse: RGB = (1.0, 1.0, 1.0)
    specular: RGB = (0.1, 0.1, 0.1)
    reach: float = 10.0
    constant: float = 1.0
    linear: float = 1.0
    quadratic: float = 0.0
    inner: float = 0.0
    outer: float = 0.0
    falloff: float = 0.0
    cast_shadows: bool = False

    def at(self, pose: Pose) -> Light:
        """The same light in a frame in which its current frame has the given pose."""
        return self.within(pose.matrix, np.asarray(pose.position))

    def within(self, rotation: Array, origin: Array) -> Light:
        """As at(), by the (3, 3) axes and the (3,) origin of its current frame."""
        x, y, z = (rotation @ self.position + origin).tolist()
        right, ahead, up = (rotation @ self.direction).tolist()
        return replace(self, position=(x, y, z), direction=(right, ahead, up))


INERTIA = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


@dataclass
class Link:
    """A rigid link: mass [kg], center of mass in the link frame, inertia (3, 3) about it.

    Attributes:
        hollow: collisions that are there without a shape, as Gazebo has those of missing meshes.
        lights: that it carries, in its frame.
        gravity: False: the file disables gravity for it.
        self_collide: collides with other links of its model that have it.
        kinematic: the solver 'ode' moves it as its velocity says: neither forces nor gravity do.
        decay: fractions of its linear and angular velocity that it loses in each step of the
            solver 'ode'.
        wind: a wind of the world acts on it.
        file_inertia: its inertia (3, 3) about the axes of its <inertial>, as the file has it.
    """

    name: str
    mass: float = 0.0
    center: Array = field(default_factory=lambda: np.zeros(3))
    inertia: Array = field(default_factory=lambda: np.zeros((3, 3)))
    visuals: list[Shape] = field(default_factory=list)
    collisions: list[Shape] = field(default_factory=list)
    hollow: list[Shape] = field(default_factory=list)
    lights: list[Light] = field(default_factory=list)
    surface: Surface = field(default_factory=Surface)
    gravity: bool = True
    self_collide: bool = False
    kinematic: bool = False
    decay: tuple[float, float] = (0.0, 0.0)
    wind: bool = False
    file_inertia: Array | None = None

    def set_inertia(self, pose: Pose, moments: Sequence[float]) -> None:
        """Set center and inertia, (ixx, ixy, ixz, iyy, iyz, izz) in a frame in the center."""
        xx, xy, xz, yy, yz, zz = moments
        local = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        self.file_inertia, self.inertia = local, pose.matrix @ local @ pose.matrix.T
        self.center = np.array(pose.position)


@dataclass(frozen=True)
class Mimic:
    """How a joint follows another.

    Attributes:
        joint: name of the joint that it follows.
        multiplier, offset: its position is multiplier times the other's, plus offset [rad, m].
        max_effort: maximum effort for following [N m, N]; None: the joint's limit.
        sensitiveness: deviation below which it is not corrected [rad, m].
    """

    joint: str
    multiplier: float = 1.0
    offset: float = 0.0
    max_effort: float | None = None
    sensitiveness: float = 0.0


@dataclass(frozen=True)
class SoftLimits:
    """A URDF's <safety_controller>, see controllers.limits.CommandLimits.

    Attributes:
        lower, upper: where it begins to slow down [rad, m].
        k_position: velocity per distance from there [1/s].
        k_velocity: effort per velocity beyond the bounds [N m s/rad, N s/m].
    """

    lower: float
    upper: float
    k_position: float
    k_velocity: float


@dataclass
class Joint:
    """A joint.

    Attributes:
        origin: child link's frame in the parent's.
        axis: unit vector in the joint's frame.
        lower, upper: limits [rad, m]; None: none.
        effort, velocity: limits [N m, N], [rad/s, m/s]; 0: the file gives none.
        damping, friction: [N m s/rad, N s/m], [N m, N].
        implicit_damping: the solver 'ode' has damping as a constraint, which no step is too long
            for; False: as an effort of the last velocity.
        stiffness, rest: of a spring [N m/rad, N/m] of the solver 'ode', and where it is at rest
            [rad, m].
        stop_erp: fraction of the way beyond a limit that a step of the solver 'ode' corrects.
        stop_cfm: how soft a limit is for it [rad/s per N m s, m/s per N s]; None: both the world's.
        stop_push: how much of its motor's effort away from a limit acts there, for the same.
        erp, cfm: of its rows, for the same; None: the world's.
        bounce: restitution at its limits, for the same.
        motor: effort and velocity of its motor at the start, for the same; None: its friction.
        thread: of a screw [rad/m] along its axis, for the same.
        anchor: joint's frame in the child link's; in a URDF the two are equal.
        closes: its child is held by other joints, too, so that it closes a loop, or by the world.
        mimic: set if it follows another joint.
        limit: effort [N m, N] and speed [rad/s, m/s] of a URDF's <limit>, which bound what
            controllers command; infinite where it does not say; None: no <limit>.
        safety: SoftLimits of a URDF, which bound the same.
    """

    name: str
    kind: str
    parent: str
    child: str
    origin: Pose = Pose()
    axis: Vec3 = (1.0, 0.0, 0.0)
    lower: float | None = None
    upper: float | None = None
    effort: float = 0.0
    velocity: float = 0.0
    damping: float = 0.0
    friction: float = 0.0
    implicit_damping: bool = False
    stiffness: float = 0.0
    rest: float = 0.0
    stop_erp: float | None = None
    stop_cfm: float | None = None
    stop_push: float = 1.0
    erp: float | None = None
    cfm: float | None = None
    bounce: float = 0.0
    motor: tuple[float, float] | None = None
    thread: float = 1.0
    anchor: Pose = Pose()
    closes: bool = False
    mimic: Mimic | None = None
    limit: tuple[float, float] | None = None
    safety: SoftLimits | None = None

    @property
    def holds(self) -> bool:
        """Whether it is a fixed one that holds its child in the world, where the model starts."""
        return self.closes and self.kind == "fixed" and self.parent == WORLD_LINK


def fixed_joint(parent: str, parent_pose: Pose, child: str, pose: Pose) -> Joint:
    """The Joint that holds a link at a pose, which is relative to the same as its parent's."""
    return Joint(f"{child}__fixed", "fixed", parent, child, parent_pose.inverse() * pose)


@dataclass
class Gears:
    """Two links that rotate as gears do, for the solver 'ode': what the first one is turned by is
    minus `ratio` times what the second one is.

    Attributes:
        first, second: names of the links (<child> and <parent> of a gearbox joint).
        base: name of the link against which both rotate.
        axis, second_axis: unit vectors in the frames of the two links.
        erp, cfm: as those of a Joint.
    """

    name: str
    first: str
    second: str
    base: str
    axis: Vec3
    second_axis: Vec3
    ratio: float = 1.0
    erp: float | None = None
    cfm: float | None = None


@dataclass
class ModelDescription:
    """A full model.

    Attributes:
        links, joints: by name, in file order; those of a model inside it have its name and '::'
            before theirs.
        root_pose: of the root link's frame in the model's.
        loose: links that no chain of joints connects with the root, and that are no link's child:
            Pose of the frame in the model's, where it starts. With the solver 'ode' each moves
            freely, with what hangs on it; they are fixed where the model is static.
        nested: models inside it, by such names: (first link, Pose of its frame in that link).
        gears: gearbox joints, by name.
        sensors: sensor specifications (of bullet_sim.plugins).
        control_namespace: namespace of the ros_control plugin; None: the model has none.
        control_period: of its controllers [s]; 0: every physics step.
        emergency_stop: topic in that namespace, <eStopTopic>; empty: none.
        robot_sim_type: of its hardware layer, as in <robotSimType>; empty: the default.
        kept: fixed joints that are not merged, as a URDF's <preserveFixedJoint> wants it.
        measured: joints whose force and torque a sensor measures; fixed ones are not merged.
        robot_param: name of the parameter whose URDF has the transmissions; empty: the file's own.
        transmissions: which hardware interfaces its joints have, see controllers.interfaces.
        static: never moves.
        fixed_base: joints hold it in the world; joints move.
        auto_disable: it may sleep while it rests.
        sensor_elements: <sensor>s with the link that each is in, and the pose in its frame.
        joint_sensor_elements: <sensor>s with the joint that each is in.
        has_sensors: also such as are left out; with the solver 'ode' it does not sleep then.
        is_urdf: its file is a URDF, which Gazebo turns into SDF.
        is_empty: all its links were left out; what stands for them has no shape and never moves.
        log_level: of the simulator's log from when the model is there; empty: it stays.
        motion: ActorMotion of an actor, which nothing else moves.
        origin: <origin> of a URDF's <robot>, within the pose at which it is spawned.
    """

    name: str
    links: dict[str, Link] = field(default_factory=dict)
    joints: dict[str, Joint] = field(default_factory=dict)
    root_pose: Pose = Pose()
    loose: dict[str, Pose] = field(default_factory=dict)
    gears: dict[str, Gears] = field(default_factory=dict)
    nested: dict[str, tuple[str, Pose]] = field(default_factory=dict)
    root: str = ""
    sensors: list[Any] = field(default_factory=list)
    control_namespace: str | None = None
    control_period: float = 0.0
    emergency_stop: str = ""
    robot_sim_type: str = ""
    kept: set[str] = field(default_factory=set)
    measured: set[str] = field(default_factory=set)
    robot_param: str = ""
    transmissions: Transmissions = Transmissions()
    static: bool = False
    self_collide: bool = False
    fixed_base: bool = False
    auto_disable: bool = True
    has_sensors: bool = False
    sensor_elements: list[tuple[str, Pose, Element]] = field(default_factory=list)
    joint_sensor_elements: list[tuple[str, Element]] = field(default_factory=list)
    is_urdf: bool = False
    is_empty: bool = False
    log_level: str = ""
    motion: Any = None
    origin: Pose = field(default_factory=Pose)
    warnings: Warnings = field(default_factory=Warnings)

    def warn(self, text: str, cause: str = "", item: str = "") -> None:
        """Add a warning about something ignored or repaired, once: see ReadWarning."""
        self.warnings.add(text, cause, item)

    def scope_of(self, name: str) -> str:
        """Prefix of a link's or joint's name that is the model inside which it is; "" for its
        own."""
        scopes = (f"{path}::" for path in self.nested)
        return max((scope for scope in scopes if name.startswith(scope)), key=len, default="")

    def joints_of(self, parent: str) -> list[Joint]:
        """Joints whose parent is the given link, in file order, without those that close loops."""
        return [j for j in self.joints.values() if j.parent == parent and not j.closes]

    def below(self) -> dict[str, list[Joint]]:
        """Link -> joints_of() it, of links that have such joints."""
        joints: dict[str, list[Joint]] = {}
        for joint in self.joints.values():
            if not joint.closes:
                joints.setdefault(joint.parent, []).append(joint)
        return joints

    def above(self) -> dict[str, Joint]:
        """Link -> the joint by which it hangs on its parent; other joints close loops."""
        return {joint.child: joint for joint in self.joints.values() if not joint.closes}

    def poses(self) -> dict[str, Pose]:
        """Link -> its pose in the model's frame, all joints at 0."""
        poses, below = {self.root: self.root_pose, **self.loose}, self.below()
        for name in (pending := list(poses)):
            for joint in below.get(name, ()):
                poses[joint.child] = poses[name] * joint.origin
                pending.append(joint.child)
        return poses

    def unreachable(self) -> list[str]:
        """Links without a chain of joints to the root or a loose link: those of a loop, and below
        it."""
        reached, below = dict.fromkeys((self.root, *self.loose)), self.below()
        for name in (pending := list(reached)):
            children = [j.child for j in below.get(name, ()) if j.child not in reached]
            reached.update(dict.fromkeys(children))
            pending += children
        return [name for name in self.links if name not in reached]

    def find_root(self, label: str) -> None:
        """Set the root link and check that the joints make trees, but for those that close loops.

        Args:
            label: of the description, for messages, e.g. "URDF of 'car'".

        Raises:
            ModelError: no link, a link with two parents, no root, several that are not loose, a
                loop.
        """
        if not self.links:
            raise ModelError(f"{label} has no link")
        children = Counter(joint.child for joint in self.joints.values() if not joint.closes)
        repeated = sorted(child for child, count in children.items() if count > 1)
        if repeated:
            raise ModelError(
                f"link '{repeated[0]}' of '{self.name}' has more than one parent joint"
            )
        roots = [link for link in self.links if link not in children and link not in self.loose]
        if len(roots) != 1:
            raise ModelError(
                f"{label} has {len(roots)} root links ({', '.join(roots) or 'a loop'}), must be one"
            )
        self.root = roots[0]
        if self.unreachable():
            raise ModelError(
                f"joints of model '{self.name}' form a loop: no path from its root "
                f"'{self.root}' to {', '.join(self.unreachable())}"
            )


@dataclass(frozen=True)
class VisualLink:
    """A link of a body.

    Attributes:
        parent: row of its parent in the body's links; -1: it is the root.
        origin: of its frame in the parent's at joint position 0.
        kind: 'fixed', 'revolute' (continuous, too) or 'prismatic'.
        axis: unit vector in its frame.
    """

    parent: int = -1
    origin: Pose = Pose()
    kind: str = "fixed"
    axis: Vec3 = (1.0, 0.0, 0.0)
    shapes: tuple[Shape, ...] = ()
    lights: tuple[Light, ...] = ()
