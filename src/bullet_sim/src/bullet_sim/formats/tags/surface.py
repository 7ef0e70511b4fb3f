"""Contact properties: mu1, mu2, fdir1, maxVel ... of URDF and <surface> of SDF."""

from bullet_sim.description.parts import EVERYTHING
from bullet_sim.errors import ModelError
from bullet_sim.formats.xml_read import child_number, child_text, floats

MAX_STIFFNESS = 1e5  # [N/m] above which contacts are left as hard as Bullet makes them

# property -> paths in <gazebo reference=...> of a URDF, first found counts
URDF = {
    "friction": ("mu1", "mu", "collision/surface/friction/ode/mu"),
    "friction2": ("mu2", "collision/surface/friction/ode/mu2"),
    "direction": ("fdir1", "collision/surface/friction/ode/fdir1"),
    "max_speed": ("maxVel", "collision/surface/contact/ode/max_vel"),
    "min_depth": ("minDepth", "collision/surface/contact/ode/min_depth"),
    "bitmask": ("collide_bitmask", "collision/surface/contact/collide_bitmask"),
}
# property -> path in a <collision> of SDF
SDF = {
    "friction": ("surface/friction/ode/mu",),
    "friction2": ("surface/friction/ode/mu2",),
    "direction": ("surface/friction/ode/fdir1",),
    "max_speed": ("surface/contact/ode/max_vel",),
    "min_depth": ("surface/contact/ode/min_depth",),
    "bitmask": ("surface/contact/collide_bitmask", "surface/contact/bitmask"),
}


def read_surface(element, paths, surface, what, warn):
    """Take what an element says of a surface; what cannot be read is left as it was.

    Args:
        element: <gazebo> of a URDF, or <collision>.
        paths: URDF or SDF of this module.
        surface: Surface, changed.
        what: name for warnings.
        warn: function of one sentence.
    """
    for key, places in paths.items():
        for place in places:
            text = child_text(element, place)
            if text is None:
                continue
            try:
                setattr(surface, key, _READERS[key](text, f"{what} <{place}>"))
            except ModelError as error:
                warn(f"{error}; it is ignored")
            break
    if surface.direction is not None and not any(surface.direction):
        surface.direction = None


def read_stiffness(element, surface, what):
    """Take <kp> and <kd> of a URDF where they are softer than Bullet's hard contact."""
    stiffness = child_number(element, "kp", what, None)
    if stiffness is not None and 0 < stiffness < MAX_STIFFNESS:
        surface.stiffness = stiffness
        surface.damping = max(0.0, child_number(element, "kd", what, 1.0))


def _not_negative(text, what):
    return max(0.0, floats(text, 1, what)[0])


def _direction(text, what):
    return floats(text, 3, what)


def _bitmask(text, what):
    try:
        value = int(text, 0)
    except ValueError:
        value = -1
    if value < 0:
        raise ModelError(f"{what} is '{text}', must be a whole number such as 0x01")
    return value & EVERYTHING


_READERS = {
    "friction": _not_negative,
    "friction2": _not_negative,
    "direction": _direction,
    "max_speed": _not_negative,
    "min_depth": _not_negative,
    "bitmask": _bitmask,
}
