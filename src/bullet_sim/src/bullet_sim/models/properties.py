"""Masses, joint stops and damping of a loaded model, read and changed at run time."""

import math

import numpy as np

from bullet_sim.errors import ModelError
from bullet_sim.pose import matrix_from_quaternion

TOLERANCE = 1e-6  # relative tolerance of values that cannot change


def link_properties(model, link):
    """Mass and inertia of a link.

    A link that fixed joints merge into another, or a model's static link, has those of its
    description; one that carries merged links has the sum, as in Gazebo.

    Returns:
        mass [kg], centre of mass (3,) [m] in the link frame, inertia (3, 3) [kg m^2] about it.

    Raises:
        ModelError: no such link.
    """
    model.link_in_body(link)
    found = model.rigid_parts.get(link) or model.description.links[link]
    return found.mass, found.centre, found.inertia


def set_link_properties(model, link, mass, centre, inertia, gravity):
    """Change a link's mass and inertia; survives a reset of the world.

    Args:
        mass: [kg].
        centre: (3,) [m], inertia: (3, 3) [kg m^2], as link_properties gives them.
        gravity: whether gravity acts on it; only True is possible.

    Raises:
        ModelError: the request is impossible or not physical; nothing has changed then.
    """
    index, _ = model.link_in_body(link)
    what = f"link '{link}' of '{model.name}'"
    part = model.rigid_parts.get(link)
    if model.is_static:
        raise ModelError(f"{what} never moves: the model is static")
    if part is None:
        raise ModelError(
            f"{what} is merged into another by a fixed joint; change one of "
            f"{', '.join(model.rigid_parts)}"
        )
    inertia = np.asarray(inertia, float)
    if not (np.isfinite(inertia).all() and math.isfinite(mass) and mass > 0):
        raise ModelError(
            f"{what}: mass is {mass} kg, inertia {inertia.tolist()}; must be finite, "
            "the mass above 0"
        )
    if not gravity:
        raise ModelError(f"{what}: gravity_mode cannot be switched off here")
    if not np.allclose(centre, part.centre, rtol=0.0, atol=1e-6):
        raise ModelError(f"{what}: the centre of mass cannot move, it is {part.centre.tolist()} m")
    moments, before = _moments(model, index, inertia), part.inertia
    if moments is None:
        raise ModelError(
            f"{what}: inertia {inertia.tolist()} has other principal axes than "
            f"{before.tolist()}, which cannot change"
        )
    if moments.min() <= 0:
        raise ModelError(f"{what}: inertia {inertia.tolist()} is not positive definite")
    model.change(("mass", link), lambda: model.engine.set_mass(model.body, index, mass, moments))
    part.mass, part.inertia = float(mass), inertia


def _moments(model, index, inertia):
    """Moments (3,) of an inertia along the loaded principal axes; None if those do not fit."""
    axes = matrix_from_quaternion(model.engine.principal_axes(model.body, index))
    turned = axes.T @ inertia @ axes
    off = turned - np.diag(np.diag(turned))
    return np.diag(turned) if np.abs(off).max() <= TOLERANCE * np.abs(turned).max() else None


def set_joint_stops(model, joint, lower=None, upper=None):
    """Change a joint's stops [rad, m]; None keeps one; survives a reset of the world.

    Raises:
        ModelError: the joint has no stops, or lower is above upper, or not finite.
    """
    number, limits = model.joints.index(joint), model.joints.limits[joint]
    what = f"joint '{joint}' of '{model.name}'"
    if limits.lower is None:
        raise ModelError(f"{what} is {limits.kind} and has no stops to change")
    lower = limits.lower if lower is None else float(lower)
    upper = limits.upper if upper is None else float(upper)
    if not (math.isfinite(lower) and math.isfinite(upper) and lower <= upper):
        raise ModelError(f"{what}: stops are {lower} and {upper}, must be finite, the lower first")
    model.change(
        ("stops", joint), lambda: model.engine.set_joint_limits(model.body, number, lower, upper)
    )
    limits.lower, limits.upper = lower, upper


def set_joint_damping(model, joint, damping):
    """Change a joint's damping [N m s/rad, N s/m]; survives a reset of the world.

    Raises:
        ModelError: negative or not finite.
    """
    number = model.joints.index(joint)
    if not (math.isfinite(damping) and damping >= 0):
        raise ModelError(
            f"joint '{joint}' of '{model.name}': damping is {damping}, must be 0 or more"
        )
    model.change(
        ("damping", joint),
        lambda: model.engine.set_joint_damping(model.body, number, float(damping)),
    )
    model.joints.limits[joint].damping = float(damping)
