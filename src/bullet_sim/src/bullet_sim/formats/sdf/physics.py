"""<physics> of SDF: step, pace, gravity and the settings of ODE."""

from bullet_sim.description.world import (
    DEFAULT_STEP,
    MAX_CONTACTS,
    MIN_STEP,
    OdeSettings,
    WorldDescription,
)
from bullet_sim.xml_reader import (
    Node,
    add_child,
    child_floats,
    child_number,
    child_text,
    is_true,
    warn_replaced,
)

MAX_ITERATIONS = 10_000  # of the solver per step
MAX_THREADS = 1024  # for islands
DEFAULT_GRAVITY = (0.0, 0.0, -9.8)  # [m/s^2] where a world gives none, as in sdformat
DEFAULT_RATE = 1000.0  # [Hz] steps a second of wall time where a world gives no rate
_OLD_PHYSICS = {
    "update_rate": "real_time_update_rate",
    "ode/solver/dt": "max_step_size",
    "bullet/dt": "max_step_size",
}


def convert_physics(world: Node) -> None:
    """Give the <physics> of SDF 1.2 and 1.3 the elements of 1.4."""
    for physics in world.findall("physics"):
        for old, new in _OLD_PHYSICS.items():
            text = child_text(physics, old)
            if text is not None and physics.find(new) is None:
                add_child(physics, new, text)


def choose_physics(world: Node) -> None:
    """Leave of several <physics> the first one that is the default, or the first one."""
    every = world.findall("physics")
    chosen = next((physics for physics in every if is_true(physics.get("default"))), None)
    for physics in every:
        if chosen is not None and physics is not chosen:
            world.remove(physics)


def read_physics(world: Node, described: WorldDescription, label: str) -> None:
    """Read the <physics> and the <gravity> of a <world>."""
    described.gravity = child_floats(world, "gravity", 3, label, DEFAULT_GRAVITY)
    step = child_number(world, "physics/max_step_size", label, DEFAULT_STEP)
    if not MIN_STEP <= step < 1:
        warn_replaced(
            world.find("physics/max_step_size"),
            f"{label} <max_step_size>",
            f"{step:g}",
            f"{label} <max_step_size> is {step}, must be at least {MIN_STEP:g} and below 1 [s]",
            DEFAULT_STEP,
        )
        step = DEFAULT_STEP
    described.step = step
    described.ode = _ode_settings(world, label)
    rate = child_number(world, "physics/real_time_update_rate", label, DEFAULT_RATE)
    described.real_time_factor = max(0.0, rate) * step


def _ode_settings(world: Node, label: str) -> OdeSettings:
    default = OdeSettings()

    def number(path: str, value: float, lower: float) -> float:
        return max(lower, child_number(world, f"physics/ode/{path}", label, value))

    most = child_number(world, "physics/max_contacts", label, float(default.max_contacts))
    even = child_text(world, "physics/ode/solver/use_dynamic_moi_rescaling", "false")
    return OdeSettings(
        iterations=int(min(number("solver/iters", default.iterations, 0.0), MAX_ITERATIONS)),
        relaxation=number("solver/sor", default.relaxation, 0.0),
        cfm=number("constraints/cfm", default.cfm, 0.0),
        erp=number("constraints/erp", default.erp, 0.0),
        max_speed=number("constraints/contact_max_correcting_vel", default.max_speed, 0.0),
        evens_inertias=is_true(even),
        max_contacts=int(most) if most > 0 else MAX_CONTACTS,
        surface_layer=number("constraints/contact_surface_layer", default.surface_layer, 0.0),
        precon_iterations=int(number("solver/precon_iters", default.precon_iterations, 0.0)),
        island_threads=int(min(number("solver/island_threads", 0.0, 0.0), MAX_THREADS)),
    )
