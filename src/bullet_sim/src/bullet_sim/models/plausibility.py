"""States that no vehicle should have: not finite, far away, or very fast."""

import math

FARTHEST = 2e3  # [m] from the origin
FASTEST = 200.0  # [m/s]
PERIOD = 0.25  # [s] of simulated time between two looks


def implausible_state(model, engine):
    """Describe what is implausible about a model's position and velocity, or None.

    Args:
        model: of the world.
        engine: the Engine.

    Returns:
        One sentence that names the model.
    """
    position, _, linear, _ = engine.link_motion(model.body, -1)
    place = ", ".join(f"{value:.4g}" for value in position)
    if not all(math.isfinite(value) for value in (*position, *linear)):
        return (
            f"model '{model.name}' has no finite position or velocity any more ({place}); delete "
            "and spawn it again, and look at its masses, inertias and gains"
        )
    speed = math.hypot(*linear)
    if speed > FASTEST:
        return (
            f"model '{model.name}' moves at {speed:.4g} m/s at ({place}), faster than makes sense "
            f"(above {FASTEST:g} m/s); look at its masses, inertias, gains and where it was spawned"
        )
    if math.hypot(*position) > FARTHEST:
        return (
            f"model '{model.name}' has left: it is at ({place}), more than {FARTHEST:g} m from the "
            "origin; is there a ground below it?"
        )
    return None
