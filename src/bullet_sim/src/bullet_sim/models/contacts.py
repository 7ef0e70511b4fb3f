"""Contacts as Gazebo (ODE) has them: friction of pairs, slip, weight on wheels.

Coulomb friction of pairs as Gazebo (ODE) has it: the smaller coefficient of both, along each of two
directions.

ODE bounds friction along two directions of the ground separately (a friction pyramid), whatever the
slip. Bullet can do the same, and does in most worlds. Its solver converges further than ODE's 50
iterations, and for two kinds of wheels that makes more difference than the shape of the bound: on
steered wheels, and on wheels of a skid-steered base with a direction of friction (fdir1, or mu2
other than mu), a friction cone is closer to what Gazebo's 50 iterations give
(docs/gazebo-comparison.md has the figures). A world with such wheels has the cone; PyBullet has one
setting for all bodies.

Bullet multiplies the coefficients of the two bodies. So what never moves gets 1, and a moving link
gets what its pair with the immobile ones comes to. Where that differs from one of these to the
next, and where moving links touch each other, it follows what the link touches just now.

With the cone, the friction of sliding skid-steered wheels is directed against their slip. Bullet
solves friction along two fixed directions, each with its own effective mass, and scales both
impulses into the cone. In the direction of rolling that mass is small, so the force of a sliding
wheel rotates towards the axle: a skid-steered base rotates at 0.3 to 0.7 of the rate that Coulomb
friction gives. Here the difference between Bullet's force of the last step and the one opposite to
the slip acts as an external force on the next. A wheel that does not slide gets none.
"""

import math
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from bullet_sim.component import Stateful
from bullet_sim.description.model import Joint, Link, Surface
from bullet_sim.models.model import Model, implausible_state
from bullet_sim.models.release import Release
from bullet_sim.models.sleep import Sleep
from bullet_sim.pose import Array, Pose, Vec3, matrix_from_quaternion

if TYPE_CHECKING:
    from bullet_sim.engine import Engine

Key = tuple[int, int]  # body, link
Pair = tuple[float, float]  # coefficients along the first and the second direction

DEFAULT = 1.0  # coefficient where a file gives none, as in Gazebo
# First direction where no fdir1 is given: what ODE makes of a normal that points upwards.
_ACROSS = (0.0, 1.0, 0.0)


class Friction(Stateful):
    """Coefficients of all links of a world."""

    STATE = ("_given", "_axis", "_fixed", "_updated", "followers")

    def __init__(self, engine: "Engine") -> None:
        self._engine = engine
        self._given: dict[Key, Pair] = {}  # of all links with collisions
        self._axis: dict[Key, int] = {}  # principal axis of the first direction, of moving links
        self._fixed: set[int] = set()  # bodies that never move
        self._updated: dict[Key, tuple[Pair, float]] = {}  # pair, factor that update() has set
        self.followers: tuple[int, ...] = ()  # bodies whose coefficients depend on what they touch

    def assign(self, models: Iterable[Model]) -> None:
        """Give every link its coefficient; call it when models came or went."""
        self._given, self._axis, self._fixed, self._updated = {}, {}, set(), {}
        models = list(models)
        ghosts = {model.body for model in models if model.is_ghost}
        for model in models:
            self._read(model)
        grounds = self._grounds()
        following: set[int] = set()
        for (body, link), mine in self._given.items():
            if body in self._fixed:
                self._engine.set_friction(body, link, 1.0)
                continue
            pairs = {_pair(mine, ground) for ground in grounds} or {mine}
            if len(pairs) > 1:
                following.add(body)
            self._set(body, link, min(pairs), 1.0)
        moving = {body for body, _ in self._given} - self._fixed - ghosts
        if len(moving) > 1:  # they may touch each other; a product with 1 is right as it is
            following |= {
                body for (body, _), mu in self._given.items() if mu != (1.0, 1.0)
            } & moving
        self.followers = tuple(sorted(following))

    def _grounds(self) -> set[Pair]:
        return {mu for (body, _), mu in self._given.items() if body in self._fixed}

    def _read(self, model: Model) -> None:
        immobile = model.is_static
        if immobile:
            self._fixed.add(model.body)
        for name, link in model.rigid_parts.items():
            surface, index = link.surface, model.index(name)
            first = DEFAULT if surface.friction is None else surface.friction
            second = first if surface.friction2 is None else surface.friction2
            self._given[model.body, index] = first, second
            if first != second and not immobile:
                self._axis[model.body, index] = self._principal(model.body, index, surface)

    def _principal(self, body: int, link: int, surface: Surface) -> int:
        """Index of the principal axis that is closest to the first direction of friction."""
        axes = matrix_from_quaternion(self._engine.principal_axes(body, link))
        direction = surface.direction
        if direction is None:
            orientation = self._engine.link_motion(body, link)[1]
            direction = matrix_from_quaternion(orientation).T @ np.array(_ACROSS)
        return int(np.argmax(np.abs(axes.T @ np.asarray(direction))))

    def _set(self, body: int, link: int, pair: Pair, other: float) -> None:
        """Set a coefficient such that times `other` it is that of a pair."""
        first, second = pair
        coefficient = max(first, second)
        scale = None
        axis = self._axis.get((body, link))
        if axis is not None and first != second:
            scale = [second / coefficient] * 3
            scale[axis] = first / coefficient
        else:
            coefficient = min(first, second)
        self._engine.set_friction(body, link, coefficient / other if other > 0.0 else 0.0, scale)

    def restart(self) -> None:
        """Set the coefficients that links have before they touch anything."""
        for body, link in self._updated:
            pairs = {_pair(self._given[body, link], ground) for ground in self._grounds()}
            self._set(body, link, min(pairs, default=self._given[body, link]), 1.0)
        self._updated = {}

    def resume(self) -> None:
        """Set the coefficients of `_updated`, which was restored."""
        for (body, link), setting in self._updated.items():
            self._set(body, link, *setting)

    def update(self) -> None:
        """Set the coefficients of such links by what each presses on hardest."""
        partners: dict[Key, tuple[float, Key]] = {}  # force, the other link
        for body in self.followers:
            if self._engine.is_asleep(body):
                continue
            for link, other, other_link, force in self._engine.touching(body):
                if force > partners.get((body, link), (0.0,))[0] and (
                    {(body, link), (other, other_link)} <= self._given.keys()
                ):
                    partners[body, link] = force, (other, other_link)
        for mine, (_, partner) in partners.items():
            factor = 1.0
            if partner[0] not in self._fixed:
                if partners.get(partner, (0.0, None))[1] == mine and mine < partner:
                    continue  # of two that press on each other one is left as it is
                factor = self._engine.friction(*partner)
            setting = _pair(self._given[mine], self._given[partner]), factor
            if setting != self._updated.get(mine):
                self._updated[mine] = setting
                self._set(*mine, *setting)


def _pair(mine: Pair, other: Pair) -> Pair:
    """Coefficients of a pair along both directions."""
    return min(mine[0], other[0]), min(mine[1], other[1])


SLOWEST = 0.01  # [m/s] of slip below which Bullet's force is left alone; full effect at twice that
_UPRIGHT = 0.7  # cosine between a steering axis and the model's z axis
_APART = 1e-3  # [m] between axles that count as two
_PARALLEL = 0.999  # cosine between axles that count as parallel


def needs_cone(model: Model) -> bool:
    """Whether a model has steered wheels, or must skid on wheels with a direction of friction.

    A wheel is steered if it is a link with collisions below an unlimited revolute joint, whose
    parent is the child of an upright revolute joint with limits or a transmission: a swivel
    castor's has neither.
    """
    transmissions = model.description.transmissions
    steering = {
        joint.child
        for joint in model.parts_joints
        if joint.kind in ("revolute", "continuous")
        and (joint.lower is not None or joint.name in transmissions)
        and abs(_axle(joint)[2]) > _UPRIGHT
    }
    if any(
        joint.parent in steering and model.rigid_parts[joint.child].collisions
        for joint in model.parts_joints
        if joint.kind in ("revolute", "continuous") and joint.lower is None
    ):
        return True
    surfaces = [
        model.rigid_parts[name].surface
        for name in skid_wheels(model.parts_joints, model.rigid_parts)
    ]
    return any(s.direction is not None or s.friction2 not in (None, s.friction) for s in surfaces)


def skid_wheels(joints: Iterable[Joint], links: Mapping[str, Link]) -> list[str]:
    """Links that are wheels of a base that must skid to rotate.

    Args:
        joints: Joints of a model without fixed ones.

    Returns:
        Names of the children of unlimited joints that share a parent, where three or more have
        parallel axles, not all on one line.
    """
    axles: dict[str, list[Joint]] = {}
    for joint in joints:
        if joint.kind in ("revolute", "continuous") and joint.lower is None:
            if links[joint.child].collisions:
                axles.setdefault(joint.parent, []).append(joint)
    wheels = []
    for siblings in axles.values():
        for first in siblings:
            axis = _axle(first)
            parallel = [j for j in siblings if abs(axis @ _axle(j)) > _PARALLEL]
            if len(parallel) >= 3 and any(_distance(first, j, axis) > _APART for j in parallel):
                wheels.append(first.child)
    return wheels


def _axle(joint: Joint) -> Array:
    axis = joint.origin.matrix @ joint.anchor.matrix @ np.asarray(joint.axis)
    return axis / np.linalg.norm(axis)


def _distance(first: Joint, second: Joint, axis: Array) -> float:
    """Distance [m] of two parallel axles."""
    offset = np.subtract(second.origin.position, first.origin.position)
    return float(np.linalg.norm(offset - (offset @ axis) * axis))


class Slip(Stateful):
    """Directs the friction of sliding wheels against their slip."""

    STATE = ("_wheels", "_forces")

    def __init__(self, engine: "Engine") -> None:
        self._engine = engine
        self._wheels: dict[int, set[int]] = {}  # body -> link indices
        # (body, link, force, point) for the next step
        self._forces: list[tuple[int, int, tuple[float, ...], Vec3]] = []

    def assign(self, models: Iterable[Model]) -> None:
        """Choose the friction model; find the wheels of all models where it is the cone."""
        self._wheels, self._forces = {}, []
        moving = [model for model in models if not model.is_static]
        cone = any(needs_cone(model) for model in moving)
        self._engine.set_friction_cone(cone)
        for model in moving if cone else ():
            names = skid_wheels(model.parts_joints, model.rigid_parts)
            if names:
                self._wheels[model.body] = {model.index(name) for name in names}

    @property
    def has_wheels(self) -> bool:
        """Whether there are such wheels."""
        return bool(self._wheels)

    @property
    def active(self) -> bool:
        """Whether wheels slide, so that every step counts."""
        return bool(self._forces)

    def apply(self) -> None:
        """Apply the forces for the next step."""
        for force in self._forces:
            self._engine.apply_force(*force)

    def update(self) -> None:
        """Compute the forces from the sliding contacts of the last step."""
        self._forces = [
            (body, link, _correction(force, velocity, limit), point)
            for body, links in self._wheels.items()
            for link, point, force, velocity, limit in self._engine.slip(body, links, SLOWEST)
        ]


def _correction(force: Vec3, velocity: Vec3, limit: float) -> tuple[float, ...]:
    """Coulomb's force [N] against a slip less the force that acts."""
    speed = math.sqrt(velocity[0] ** 2 + velocity[1] ** 2 + velocity[2] ** 2)
    ratio = min(1.0, speed / SLOWEST - 1.0)
    return tuple(ratio * (-limit * v / speed - f) for v, f in zip(velocity, force))


class Weight(Stateful):
    """Upward forces on links without gravity."""

    STATE = ("_links",)

    def __init__(self, engine: "Engine") -> None:
        self._engine = engine
        # (model, link name, mass [kg], center (3,) in the link's frame)
        self._links: list[tuple[Model, str, float, Array]] = []

    def assign(self, models: Iterable[Model]) -> None:
        """Find the links of all models."""
        self._links = [
            (model, link.name, link.mass, link.center)
            for model in models
            if not model.is_static
            for link in model.description.links.values()
            if not link.gravity and link.mass > 0.0
        ]

    @property
    def active(self) -> bool:
        """Whether there are such links."""
        return bool(self._links)

    def apply(self) -> None:
        """Apply the forces for the next step."""
        gravity = self._engine.gravity
        for model, name, mass, center in self._links:
            index, offset = model.link_in_body(name)
            position, orientation, _, _ = self._engine.link_motion(model.body, index)
            frame = Pose(position, orientation) * offset
            point = tuple(frame.position + frame.matrix @ center)
            self._engine.apply_force(model.body, index, tuple(-mass * g for g in gravity), point)


CHECK_STEPS = 10  # steps between two checks of contacts while nothing slides


class Contacts(Stateful):
    """Everything about contacts that is computed between steps.

    Contacts are checked at fixed step counts, so that results do not depend on the size of batches.

    Args:
        on_implausible: function of a message, called once for each model whose state is
            implausible.
    """

    STATE = ("_friction", "_slip", "_release", "_weight", "_sleep", "_changed", "_reported")
    CACHE = ("_models",)

    def __init__(
        self, engine: "Engine", on_implausible: Callable[[str], None] | None = None
    ) -> None:
        self._engine = engine
        self.on_implausible = on_implausible
        self._friction, self._slip = Friction(engine), Slip(engine)
        self._release, self._weight = Release(engine), Weight(engine)
        self._sleep = Sleep(engine)
        self._models: dict[str, Model] = {}
        self._changed = False
        self._reported: set[str] = set()

    def model_added(self, model: Model) -> None:
        """A model was spawned or reloaded."""
        self._changed = True
        self._release.check_later(model)

    def model_moved(self, model: Model) -> None:
        """The pose of a model was set."""
        self._release.check_later(model)

    def model_removed(self, model: Model) -> None:
        """A model is about to be deleted."""
        self._changed = True
        self._release.remove(model)
        self._reported.discard(model.name)

    def clear(self) -> None:
        """All models are about to be reloaded."""
        self._changed, self._reported = True, set()
        self._release.clear()

    @property
    def is_releasing(self) -> bool:
        """Whether models are being pushed out of others."""
        return self._release.moving

    @property
    def is_idle(self) -> bool:
        """Whether stride, apply_forces and update have nothing to do, until a model changes."""
        return self._engine.ode is not None or not (
            self._slip.has_wheels
            or self._friction.followers
            or self._release.active
            or self._weight.active
            or self._sleep.bodies
        )

    def begin_restore(self) -> None:
        """A saved state is about to be restored: stop what the engine does for the present one."""
        self._release.end()
        self._friction.restart()

    def end_restore(self) -> None:
        """A saved state was restored: have the engine do what belongs to it."""
        self._friction.resume()
        self._release.resume()

    def prepare(self, models: dict[str, Model]) -> None:
        """Before the first step after a change; `models` of the world by name."""
        if not self._changed:
            return
        self._changed, self._models = False, models
        if self._engine.ode is not None:  # which has all of this itself
            return
        self._friction.assign(models.values())
        self._slip.assign(models.values())
        self._weight.assign(models.values())
        self._sleep.assign(models.values())

    def stride(self, step: int, count: int) -> int:
        """How many of `count` steps can be made in one call, `step` steps having been made."""
        if self._slip.active or self._release.active or self._weight.active:
            return 1
        if self._slip.has_wheels or self._friction.followers:
            count = min(count, CHECK_STEPS - step % CHECK_STEPS)
        if self._sleep.bodies:
            count = min(count, self._sleep.interval - step % self._sleep.interval)
        return count

    def apply_forces(self) -> None:
        """Apply forces for the next step."""
        if self._release.active:
            self._release.move()
        if self._weight.active:
            self._weight.apply()
        if self._slip.active:
            self._slip.apply()

    def update(self, step: int, may_sleep: bool = True) -> None:
        """After a stride, `step` steps having been made.

        Args:
            may_sleep: whether what rests may fall asleep: no wrench is to come.
        """
        due = step % CHECK_STEPS == 0
        if self._slip.has_wheels and (due or self._slip.active):
            self._slip.update()
        if due and self._friction.followers:
            self._friction.update()
        if self._sleep.bodies and step % self._sleep.interval == 0:
            if may_sleep and not self._release.active:
                self._sleep.update()

    def check(self) -> None:
        """Report each model with an implausible state once."""
        for name, model in self._models.items():
            if name in self._reported or model.is_static or self.on_implausible is None:
                continue
            text = implausible_state(model, self._engine)
            if text is not None:
                self._reported.add(name)
                self.on_implausible(text)
