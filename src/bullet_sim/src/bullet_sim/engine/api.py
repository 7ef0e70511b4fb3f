"""What an engine is: a world of bodies that are made of models, their joints' motors, and steps.

`ode/` steps as Gazebo's ODE does, `bullet/` as PyBullet does. Poses are those of link frames (not
of inertial frames) in the world, quaternions are (x, y, z, w), velocities along the world's axes.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, Tuple

import numpy as np

from bullet_sim.pose import Array, Motion, Pose, Quat, Vec3, Vector

if TYPE_CHECKING:
    from bullet_sim.description.lump import LumpedModel
    from bullet_sim.description.model import Joint, ModelDescription
    from bullet_sim.description.world import OdeSettings
    from bullet_sim.engine.efforts import EffortRow

BodyLink = Tuple[int, str]  # number of a body, and the name of one of its links
WORLD: BodyLink = (-1, "")  # in the place of a link to which something is attached


class Contact(NamedTuple):
    """One contact point, seen from a link.

    Attributes:
        body, link: number of the other body and the name of its link.
        position: (3,) [m] in the world.
        normal: (3,) unit vector from the other link towards this one, in the world.
        depth: penetration [m]; negative: a gap within the margin.
        force: (3,) [N] on this link, world axes.
        is_first: this link is the first of both in Gazebo.
    """

    body: int
    link: str
    position: Array
    normal: Array
    depth: float
    force: Array
    is_first: bool = True


class ContactRows(NamedTuple):
    """Contact points of a link, in the order of Contacts, in arrays.

    Attributes:
        others: (number of the other body, its link) of each.
        firsts: whether this link is the first of both in Gazebo.
        numbers: (n, 10 or more) position, normal, depth and force: see Contact.
        wrenches: (n, 6) on this link about its center of mass, in its axes [N, N m]; None: they
            were not computed.
    """

    others: list[BodyLink]
    firsts: list[bool]
    numbers: Array
    wrenches: Array | None = None


def contact_rows(contacts: Sequence[Contact]) -> ContactRows:
    """Contacts in arrays."""
    numbers = np.empty((len(contacts), 10))
    for row, contact in zip(numbers, contacts):
        row[:3], row[3:6], row[6], row[7:] = contact[2:6]
    others = [(contact.body, contact.link) for contact in contacts]
    return ContactRows(others, [contact.is_first for contact in contacts], numbers)


class Touch(NamedTuple):
    """Two links that press against each other: a link of the body that was asked, the number of the
    other body, its link, and the force between them [N]."""

    link: str
    body: int
    other: str
    force: float


class Rays(NamedTuple):
    """Rays of a lidar.

    Attributes:
        center: (3,) [m] in the world, from which all come.
        directions: (n, 3) unit vectors, world axes.
        near, far: distances at which they begin and end [m].
    """

    center: Array
    directions: Array
    near: float
    far: float


class EngineState(NamedTuple):
    """State of all bodies of an engine.

    Attributes:
        layout: of the engine when it was saved.
        is_cleared: the contacts were cleared; the world has to go on without them.
        data: the engine's own.
    """

    layout: int
    is_cleared: bool
    data: Any


class JointState(Protocol):
    """What a joint's state is read into: position [rad, m] and velocity [rad/s, m/s]."""

    position: float
    velocity: float


class Motor(Protocol):
    """Motor of one joint. It keeps its command until the next; efforts last one step.

    Attributes:
        applied: effort that effort rows have applied in the last step, None: none commands it
            [N m, N].
    """

    applied: float | None

    def track_velocity(self, velocity: float, effort: float) -> None:
        """Track a velocity [rad/s, m/s] with at most `effort` [N m, N]."""

    def track_position(self, position: float, effort: float, speed: float) -> None:
        """Track a position [rad, m] with at most `effort` [N m, N] and `speed` [rad/s, m/s]."""

    def impose_velocity(self, velocity: float, effort: float) -> None:
        """Move the joint as Gazebo's Joint::SetVelocity does before each step [rad/s, m/s]; with
        Bullet by its motor, with at most `effort` [N m, N]."""

    def impose_position(self, position: float, effort: float, speed: float) -> None:
        """Move the joint as Gazebo's Joint::SetPosition does before each step [rad, m], so that its
        friction alone holds it in between; with Bullet as track_position()."""

    def release(self) -> None:
        """Release the joint: it moves freely, with its friction, which efforts have to overcome."""

    def add_effort(self, effort: float) -> None:
        """Apply an effort [N m, N] in the next step; several add up."""

    def set_position(self, position: float) -> None:
        """Put the joint to a position [rad, m], at rest."""

    def set_limits(self, lower: float, upper: float) -> None:
        """Change the limits [rad, m]; a lower one above the upper one: none."""

    def set_damping(self, damping: float) -> None:
        """Change the viscous damping [N m s/rad, N s/m]."""

    def set_parameter(self, name: str, value: float) -> bool:
        """Change erp, cfm, stop_erp, stop_cfm, fudge_factor, fmax or vel, which ODE alone has.

        fmax and vel are the effort [N m, N] and the velocity [rad/s, m/s] of the motor; the effort
        is that of the friction, too, which the joint has again when it is released.

        Returns:
            Whether this engine has it.
        """

    def measure_load(self) -> None:
        """Measure the joint's forces from the next step on."""

    def load(self) -> tuple[Array, Array, float]:
        """What a measured joint exerts on its child link.

        Returns:
            force (3,) [N] and torque (3,) [N m] about the joint in the link's axes; the motor's
            effort [N m, N].
        """


class Body(Protocol):
    """A model in an engine.

    Attributes:
        number: by which contacts name it.
        links: names, the root first, each before its children, with those that mirrors of a world
            have besides (see description/mirrors.py).
        joints: names of its joints, those that fixed ones became last.
        moves: it can move, as a whole or in its joints.
    """

    @property
    def number(self) -> int: ...
    @property
    def links(self) -> Sequence[str]: ...
    @property
    def joints(self) -> Sequence[str]: ...
    @property
    def moves(self) -> bool: ...

    def motor(self, joint: str) -> Motor:
        """The motor of a joint."""

    # Where it is and how it moves.
    def pose(self) -> tuple[Vec3, Quat]:
        """Pose of the root link's frame."""

    def set_pose(self, position: Vector, orientation: Vector) -> None:
        """Move the root link's frame to a pose; joints stay."""

    def set_velocity(self, linear: Vector, angular: Vector) -> None:
        """Set the velocity of a model [m/s, rad/s]: of the centers of mass of all its links, as
        Gazebo's Model::SetLinearVel; with Bullet of the root link's frame, joints keep theirs."""

    def hold_velocity(self, velocity: Vec3) -> None:
        """Have the next call of Engine.step() set, between any two of its steps, the velocity of a
        model that moves on the ground: as set_velocity() of a velocity forward and to the left of
        its root link's heading [m/s] and a yaw rate [rad/s]. With Bullet it has no effect."""

    @property
    def is_held(self) -> bool:
        """Whether hold_velocity() has had an effect since the last step."""

    def set_link_velocity(self, link: str, linear: Vector) -> None:
        """Set the velocity of one link's center of mass [m/s], as Gazebo's Link::SetLinearVel; with
        Bullet that of a root link alone."""

    def place_link(self, link: str, pose: Pose, linear: Vector, angular: Vector) -> None:
        """Put one link's frame to a pose, with a velocity of its center of mass [m/s, rad/s];
        joints pull it, and what they connect with it, in the next steps.

        Raises:
            ModelError: with Bullet, where the link is below a joint; a root link takes the others
                along there.
        """

    def gather(self) -> None:
        """Put loose links where they started, relative to the root link."""

    def link_motion(self, link: str, offset: tuple[Vec3, Quat] | None = None) -> Motion:
        """Pose and velocity of a link frame.

        Args:
            offset: pose of another frame of the link, in the link frame, that is meant instead.

        Returns:
            position [m], quaternion, linear [m/s] of the frame's origin, angular [rad/s].
        """

    def recorded_motion(self, link: str, offset: tuple[Vec3, Quat] | None = None) -> Any:
        """As link_motion(), after each of k recorded steps: four sequences of arrays (k,), which
        functions of plain numbers take; None: there is none, or a number is not finite."""

    def link_center(self, link: str) -> Vec3:
        """Center of mass [m] of a link."""

    def joint_states(self) -> Sequence[tuple[float, float, float]]:
        """(position, velocity, effort) of each joint: [rad, m], [rad/s, m/s] and [N m, N].

        The effort is what effort rows have applied in the last step, without that of the motor, as
        Gazebo's Joint::GetForce.
        """

    def read_joints(self, states: Iterable[JointState]) -> None:
        """Read positions and velocities of the joints, in their order."""

    def joint_positions(self) -> tuple[float, ...]:
        """Positions [rad, m] of the joints."""

    def set_joint_positions(self, positions: Vector) -> None:
        """Set the joints to positions (n,) [rad, m], at rest."""

    def coordinates(self) -> tuple[float, ...]:
        """Positions [rad, m] of the joints of `links` but the root, for mirrors of a world."""

    # What acts on it, for the next step alone.
    def apply_force(self, link: str, force: Vector, point: Vector, torque: Vector = ...) -> None:
        """Apply a force (3,) [N] to a link at a point, and a torque (3,) [N m]; several add up."""

    # Properties of links.
    def set_mass(self, link: str, mass: float, inertia: Array) -> None:
        """Change a link's mass [kg] and its inertia (3, 3) [kg m^2].

        Raises:
            ModelError: with Bullet, where the principal axes change.
        """

    def set_gravity(self, link: str, is_on: bool, mass: float, center: Vector) -> None:
        """Have gravity act on a link, or not; mass [kg] and center [m] in its frame are its own."""

    def set_friction(self, link: str, friction: float) -> None:
        """Set both Coulomb coefficients of a link."""

    def set_slip(self, link: str, slip1: float, slip2: float) -> None:
        """Set how fast a link slips for a force along both directions of friction [m/(N s)]; with
        Bullet it has no effect."""

    def set_bitmask(self, link: str, bits: int) -> None:
        """Let a link touch only what shares a bit (of 16) with it; the others have all bits."""

    # Contacts, as of the last step.
    def contacts(self, link: str) -> list[Contact]:
        """Contact points of one link that press or touch."""

    def contact_rows(self, link: str) -> ContactRows:
        """contacts() in arrays."""

    def records_contacts(self, link: str) -> bool:
        """Have contacts of a link be recorded with steps; whether they are."""

    def touching(self) -> list[Touch]:
        """Pairs of links in contact."""


class Records(Protocol):
    """States after each of several steps: what reads them alone need not end a batch of steps.

    Attributes:
        most: steps that are recorded at most.
    """

    @property
    def most(self) -> int: ...

    def begin(self) -> None:
        """Record the states after the next steps."""

    def end(self, count: int) -> None:
        """Record no more: a number of steps were made."""

    def show(self, number: int) -> None:
        """Let bodies and joints be as they were after a recorded step, until show_end().

        Args:
            number: of the step, from 0.
        """

    def show_contacts(self, number: int) -> None:
        """As show(), for contacts alone, of links that record them: Body.records_contacts()."""

    def show_end(self) -> None:
        """Let bodies and joints be as they are."""


class Engine(Protocol):
    """A world of bodies.

    Attributes:
        time_step: [s].
        gravity: acceleration in the world frame [m/s^2].
        settings: what was configured, where all of it has an effect; None: with Bullet.
        solver_iterations: of the constraint solver per step.
        bodies: by their numbers.
        layout: number that tells what was added, removed or filtered since clear().
        placements: how often bodies were put somewhere; what is static stays in between.
        unlocked: let other threads of Python run during steps: where each has a world of its own.
        records: None: it has none.
    """

    time_step: float
    gravity: Vec3
    layout: int
    placements: int
    unlocked: bool

    @property
    def records(self) -> Records | None: ...

    @property
    def bodies(self) -> Mapping[int, Body]: ...
    @property
    def settings(self) -> OdeSettings | None: ...
    @property
    def solver_iterations(self) -> int: ...

    def configure(self, settings: OdeSettings) -> None:
        """Set what a world file says of the solver, of which Bullet knows the iterations."""

    def set_solver_iterations(self, count: int) -> None:
        """Change the iterations of the constraint solver per step."""

    def set_gravity(self, gravity: Vec3) -> None:
        """Set gravity [m/s^2] in the world frame."""

    def set_time_step(self, time_step: float) -> None:
        """Set the physics step [s]."""

    def is_compiled(self) -> bool:
        """Whether compile() has nothing to do."""

    def compile(self) -> None:
        """Compile what the first step would else have to compile."""

    def close(self) -> None:
        """Free everything; the engine is not usable afterwards."""

    def clear(self) -> None:
        """Remove every body and return to the state of a new engine."""

    def lump(self, description: ModelDescription) -> LumpedModel:
        """The links and joints that are made of a description."""

    def add(self, model: LumpedModel, description: ModelDescription, pose: Pose) -> Body:
        """Add a model with its root link's frame at a pose.

        Args:
            model: of lump(), with meshes that can be read.

        Raises:
            ModelError: it cannot be added.
        """

    def remove(self, body: Body) -> None:
        """Remove a body."""

    def step(
        self, count: int = 1, efforts: Sequence[EffortRow] = (), records: bool = False
    ) -> Array | None:
        """Advance by `count` time steps.

        Args:
            efforts: apply an effort to its joint before each step, and hold their last state then.
            records: whether to record the joints, for at most MAX_RECORDED steps.

        Returns:
            Positions (count, j) [rad, m] of all joints before each step, see joint_columns(); None:
            they were not to be recorded.
        """

    def joint_columns(self, body: Body, joints: Iterable[str]) -> list[int]:
        """Columns of some of a body's joints in what step() records."""

    def save_state(self) -> EngineState:
        """State of all bodies; contacts may start anew by it."""

    def restore_state(self, state: EngineState) -> bool:
        """Restore a state; the bodies have to be the same.

        Returns:
            Whether the world goes on as it did when the state was saved, to the bit.
        """

    def attach(self, key: Any, one: BodyLink, other: BodyLink) -> None:
        """Hold a link where it is now relative to another one, by a fixed joint; meanwhile they do
        not collide.

        Args:
            key: hashable, for the methods that follow; what it had attached is let go.
        """

    def attach_by_joint(self, key: Any, parent: BodyLink, child: BodyLink, joint: Joint) -> bool:
        """Connect a link with another one, or with WORLD, by a joint that is at 0 now.

        Args:
            joint: its anchor counts, not its names and origin.

        Returns:
            Whether it does: Bullet knows no such joints.
        """

    def detach(self, key: Any) -> bool:
        """Let go what is attached; whether the key is known, also of what is let go by now."""

    def attach_again(self, key: Any) -> bool:
        """Attach what was let go as it was attached first, with Bullet where it is now; whether the
        key is known."""

    def attached_state(self, key: Any) -> tuple[float, float]:
        """Position [rad, m] and velocity [rad/s, m/s] of a joint of attach_by_joint()."""

    def add_attached_effort(self, key: Any, effort: float) -> None:
        """Have an effort [N m, N] act on such a joint in the next step."""

    def attachments(self) -> dict[Any, tuple[BodyLink, BodyLink]]:
        """What attach() holds now."""

    def all_contacts(self) -> tuple[Array, Array, Array]:
        """Contact points of all bodies that press, as of the last step.

        Returns:
            (n, 3) places [m], (n, 3) unit normals, (n,) normal forces [N], in the world frame.
        """

    def cast_rays(self, rays: Rays) -> Array:
        """Distances to what the rays of a lidar hit first; a ray that begins inside a solid shape
        does not hit that.

        Returns:
            (n,) float64 [m]; inf: nothing up to `far`; -inf: something nearer than `near`.
        """

    def mesh_scene(
        self, meshes: Sequence[tuple[int, Pose, Array]], positions: Array, orientations: Array
    ) -> Any:
        """Triangles at which rays are cast, of links that are put anywhere: see ode/rays.py.

        Args:
            meshes: row of the link, pose in it and triangles (n, 3, 3) [m] of each.
            positions, orientations: of the links (n, 3) [m] and (n, 4).

        Returns:
            A MeshScene; None: with Bullet, which casts rays at collisions alone.
        """
