"""Changes to loaded models: wrenches, efforts, properties of links and joints."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from bullet_sim.component import Stateful
from bullet_sim.description.lump import moved
from bullet_sim.errors import CommandError, ModelError
from bullet_sim.pose import Array, Vector

if TYPE_CHECKING:
    from bullet_sim.models.model import Model


ROUNDING = 1e-5  # of a step: of times that ROS cuts to whole nanoseconds


def step_range(
    step_count: int, time_step: float, start: float, duration: float
) -> tuple[int, float]:
    """Physics steps during which a wrench or an effort acts.

    Args:
        step_count: steps made so far.
        time_step: [s].
        start: simulated time [s]; a past one means now.
        duration: [s]; negative: without end; shorter than a step: not at all, as in gazebo_ros.

    Returns:
        (first, end): it acts in the steps first <= index < end; end may be infinite.

    Raises:
        CommandError: a number is NaN or infinite.
    """
    for name, value in (("start_time", start), ("duration", duration)):
        if not math.isfinite(value):
            raise CommandError(f"{name} is {value} s, must be finite")
    now = step_count * time_step
    # gazebo_ros compares with the time at the end of the step that is to be made
    first = max(step_count, math.ceil(start / time_step - ROUNDING) - 1)
    if duration < 0:
        return first, math.inf
    return first, max(first, math.floor((max(start, now) + duration) / time_step + ROUNDING))


@dataclass(frozen=True)
class _Load:
    model: Model
    part: str  # name of the link or joint
    type: str  # 'link' or 'joint'
    first: int
    end: float
    apply: Callable[[], None]


class Forces(Stateful):
    """External wrenches and efforts, applied before every physics step."""

    STATE = ("_loads",)

    def __init__(self) -> None:
        self._loads: list[_Load] = []

    @property
    def active(self) -> bool:
        """Whether a wrench or an effort acts now or later."""
        return bool(self._loads)

    def apply_wrench(
        self, model: Model, link: str, force: Vector, torque: Vector, steps: tuple[int, float]
    ) -> None:
        """Apply a force at the center of mass of a link's rigid part, and a torque; without an
        effect on a static model.

        Args:
            force, torque: (3,) [N], [N m] along world axes; they do not rotate with the link.
            steps: as step_range gives it.

        Raises:
            SimError: no such link, a number that is NaN or infinite.
        """
        self._check(model, f"wrench on link '{link}'", (*force, *torque))
        part, _ = model.link_in_body(link)
        force, torque = np.asarray(force, float), np.asarray(torque, float)
        self._add(model, link, "link", steps, lambda: model.apply_wrench(part, force, torque))

    def apply_effort(
        self, model: Model, joint: str, effort: float, steps: tuple[int, float]
    ) -> None:
        """Apply an effort [N m, N] to a joint in addition to its controller, see
        Joints.add_effort.

        Raises:
            SimError: no such joint, a number that is NaN or infinite.
        """
        self._check(model, f"effort on joint '{joint}'", (effort,))
        model.joints.motor(joint)
        self._add(model, joint, "joint", steps, lambda: model.joints.add_effort(joint, effort))

    def _add(
        self,
        model: Model,
        part: str,
        part_type: str,
        steps: tuple[int, float],
        apply: Callable[[], None],
    ) -> None:
        if steps[1] > steps[0] and not model.is_static:
            self._loads.append(_Load(model, part, part_type, *steps, apply))

    @staticmethod
    def _check(model: Model, label: str, values: Iterable[float]) -> None:
        for value in values:
            if not math.isfinite(value):
                raise CommandError(f"{label} of '{model.name}' has {value}, must be finite")

    def apply(self, step: int) -> None:
        """Apply all that act in the next physics step; `step` is the number of steps made.

        Of several wrenches on a link the last counts, as in gazebo_ros, which sets the force of a
        body; efforts add up.
        """
        acting = [load for load in self._loads if load.first <= step < load.end]
        last = {(load.model, load.part): load for load in acting if load.type == "link"}
        for load in acting:
            if load.type == "joint" or last[load.model, load.part] is load:
                load.apply()
        self._loads = [load for load in self._loads if load.end > step + 1]

    def rescale(self, before: int, now: int, ratio: float) -> None:
        """Keep the times of all after a change of the physics step.

        Args:
            before, now: number of steps made, of the old and of the new size.
            ratio: the old step over the new one.
        """

        def rescaled(load: _Load) -> _Load:
            first = now + max(0, round((load.first - before) * ratio))
            left = load.end - max(load.first, before)
            end = first + (left if math.isinf(left) else max(1, round(left * ratio)))
            return replace(load, first=first, end=end)

        self._loads = [rescaled(load) for load in self._loads]

    def clear_link(self, name: str) -> int:
        """Clear all wrenches on the link MODEL::LINK, the only name that Gazebo compares.

        Returns:
            How many there were.
        """
        return self._remove(
            lambda load: load.type == "link" and f"{load.model.name}::{load.part}" == name
        )

    def clear_joint(self, name: str) -> int:
        """Clear all efforts on joints of a plain name, of all models, as Gazebo does.

        Returns:
            How many there were.
        """
        return self._remove(lambda load: (load.type, load.part) == ("joint", name))

    def remove_model(self, model: Model) -> int:
        """Clear all wrenches and efforts on a model; returns how many there were."""
        return self._remove(lambda load: load.model is model)

    def clear(self) -> None:
        """Clear all wrenches and efforts."""
        self._loads = []

    def _remove(self, matches: Callable[[_Load], bool]) -> int:
        others = [load for load in self._loads if not matches(load)]
        count = len(self._loads) - len(others)
        self._loads = others
        return count


NO_STOP = 1e16  # [rad, m] Gazebo's limit of a joint without one


def link_properties(model: Model, link: str) -> tuple[float, Array, Array, bool]:
    """Mass and inertia of a link, and whether gravity acts on it.

    A link that fixed joints merge into another, or a model's static link, has those of its
    description; one that carries merged links has the sum, as in Gazebo.

    Returns:
        mass [kg], center of mass (3,) [m] in the link frame, inertia (3, 3) [kg m^2] about it,
        whether gravity acts on it.

    Raises:
        ModelError: no such link.
    """
    _, offset = model.link_in_body(link)
    part = model.rigid_parts.get(link)
    part = model.description.links[link] if part is None else moved(part, offset.inverse())
    center = model.set_masses[link][1] if link in model.set_masses else part.center
    return part.mass, center, part.inertia, part.gravity


def gazebos_properties(model: Model, link: str) -> tuple[float, Array, Array, bool]:
    """As link_properties, of a link as Gazebo has it: a fixed joint of an SDF does not merge its
    links, and what a URDF fixes to the world carries what is merged into it. The inertia of a
    single link is what its file says, about the axes of its <inertial>."""
    name, offset = model.link_in_body(link)
    mass, center, inertia, gravity = link_properties(model, link)
    carrier, own, described = (
        model.rigid_parts[name],
        model.description.links[link],
        model.description,
    )
    others = model.bodies if not described.is_urdf else described.links
    shared = any(model.link_in_body(other)[0] == name for other in others if other != link)
    if own.file_inertia is not None and not (shared and described.is_urdf):
        inertia = own.file_inertia
    if not described.is_urdf:
        if shared:
            mass, center = own.mass, own.center
    elif name != link and link in model.bodies:
        whole = moved(carrier, offset.inverse())
        mass, center, inertia = whole.mass, whole.center, whole.inertia
    return mass, center, inertia, carrier.gravity if link in model.bodies else gravity


def set_link_properties(
    model: Model, link: str, mass: float, center: Vector, inertia: Any, gravity: bool
) -> None:
    """Change a link's mass and inertia; survives a reset of the world.

    Args:
        mass: [kg].
        center: (3,) [m], inertia: (3, 3) [kg m^2], as link_properties gives them. The center is
            kept for link_properties alone: links move as they are loaded.
        gravity: whether gravity acts on it.

    Raises:
        ModelError: the request is impossible or not physical; nothing has changed then.
    """
    _, offset = model.link_in_body(link)
    label = f"link '{link}' of '{model.name}'"
    part = model.rigid_parts.get(link)
    if model.is_static:
        raise ModelError(f"{label} never moves: the model is static")
    if part is None:
        raise ModelError(
            f"{label} is merged into another by a fixed joint; change one of "
            f"{', '.join(model.rigid_parts)}"
        )
    inertia = np.asarray(inertia, float)
    if not (np.isfinite(inertia).all() and math.isfinite(mass) and mass > 0):
        raise ModelError(
            f"{label}: mass is {mass} kg, inertia {inertia.tolist()}; must be finite, "
            "the mass above 0"
        )
    reported = np.asarray(center, float)
    if not np.isfinite(reported).all():
        raise ModelError(f"{label}: the center of mass is {reported.tolist()} m, must be finite")
    if np.linalg.eigvalsh(inertia).min() <= 0:
        raise ModelError(f"{label}: inertia {inertia.tolist()} is not positive definite")
    inertia = offset.matrix @ inertia @ offset.matrix.T
    try:
        model.change(("mass", link), lambda: model.body.set_mass(link, mass, inertia))
    except ModelError as error:
        raise ModelError(f"{label}: {error}") from error
    weight = gravity, mass, part.center
    model.change(("gravity", link), lambda: model.body.set_gravity(link, *weight))
    part.mass, part.inertia, part.gravity = float(mass), inertia, gravity
    model.set_masses[link] = part.mass, reported, inertia


def set_link_gravity(model: Model, link: str, gravity: bool) -> None:
    """Switch gravity on a link on or off, and on those that fixed joints merge with it; survives a
    reset of the world.

    Raises:
        ModelError: no such link.
    """
    name, _ = model.link_in_body(link)
    part = model.rigid_parts[name]
    weight = gravity, part.mass, part.center
    model.change(("gravity", name), lambda: model.body.set_gravity(name, *weight))
    part.gravity = gravity


def set_joint_stops(
    model: Model, joint: str, lower: float | None = None, upper: float | None = None
) -> None:
    """Change a joint's limits [rad, m]; None leaves one; survives a reset of the world.

    As in Gazebo, a lower one above the upper one means none.

    Raises:
        ModelError: not finite; with PyBullet's own solver also of a joint without stops, and where
            the lower one is above the upper one.
    """
    model.joints.motor(joint)
    limits = model.joints.limits[joint]
    label = f"joint '{joint}' of '{model.name}'"
    ends = limits.lower, limits.upper
    if None in ends and model.engine.settings is None:  # PyBullet's own solver
        raise ModelError(f"{label} is {limits.kind} and has no stops to change")
    old = [-NO_STOP if ends[0] is None else ends[0], NO_STOP if ends[1] is None else ends[1]]
    low = old[0] if lower is None else float(lower)
    high = old[1] if upper is None else float(upper)
    crossed = low > high and model.engine.settings is None
    if not (math.isfinite(low) and math.isfinite(high)) or crossed:
        raise ModelError(f"{label}: stops are {low} and {high}, must be finite, the lower first")
    model.change(("stops", joint), lambda: model.body.motor(joint).set_limits(low, high))
    limits.lower, limits.upper = (low, high) if low <= high else (None, None)


def set_joint_parameter(model: Model, joint: str, name: str, value: float) -> bool:
    """Change a parameter of a joint that ODE alone has; survives a reset of the world.

    Args:
        name: see Motor.set_parameter.

    Returns:
        Whether the world's solver has it.

    Raises:
        ModelError: the value is not finite.
    """
    model.joints.motor(joint)
    if not math.isfinite(value):
        raise ModelError(f"joint '{joint}' of '{model.name}': {name} is {value}, must be finite")
    if not model.body.motor(joint).set_parameter(name, value):
        return False

    def change() -> None:
        model.body.motor(joint).set_parameter(name, value)

    model.change((name, joint), change)
    return True


def set_joint_damping(model: Model, joint: str, damping: float) -> None:
    """Change a joint's damping [N m s/rad, N s/m]; survives a reset of the world.

    Raises:
        ModelError: negative or not finite.
    """
    model.joints.motor(joint)
    if not (math.isfinite(damping) and damping >= 0):
        raise ModelError(
            f"joint '{joint}' of '{model.name}': damping is {damping}, must be 0 or more"
        )
    model.change(
        ("damping", joint),
        lambda: model.body.motor(joint).set_damping(float(damping)),
    )
    model.joints.limits[joint].damping = float(damping)
