"""A state of a world from which it goes on, to the bit, as if it had never stopped."""

from dataclasses import dataclass

from bullet_sim.models.model import Model
from bullet_sim.system.object_state import ObjectState

# Modules whose objects hold a state; of the models alone what set_state has set.
MODULES = ("bullet_sim.controllers.", "bullet_sim.models.", "bullet_sim.world.order")
COLD = (
    "contacts start anew, as models were reloaded, deleted or pushed out of each other since: the "
    "last digits will differ from those that followed then"
)


@dataclass(frozen=True)
class WorldState:
    """State of a world.

    Attributes:
        models: the models by name, in order.
        bodies: their numbers in the engine.
        controllers: of each model, as they were loaded.
        engine: what the engine saved, see engine.saving.
        objects: ObjectState of controllers, forces and contacts.
        placed: what Model.set_state has set, of each model.
        time_step: [s].
        step_count: steps made.
        next_check: time of the next look for implausible states [s].
    """

    models: dict
    bodies: tuple
    controllers: tuple
    engine: object
    objects: ObjectState
    placed: tuple
    time_step: float
    step_count: int
    next_check: float


def save(world, order, next_check):
    """Save a world's state.

    Args:
        world: World.
        order: its ModelOrder.
        next_check: see WorldState.

    Returns:
        WorldState.
    """
    models = list(world.models.values())
    roots = [world.forces, world.contacts, order]
    for model in models:
        roots += [model.joints, model.mimics, model.manager]
    return WorldState(
        dict(world.models),
        bodies_of(world.models),
        tuple(controllers_of(model) for model in models),
        world.engine.save_bodies(clear=world.contacts.is_releasing),
        ObjectState(roots, MODULES, leave=(Model,)),
        tuple(model.placed for model in models),
        world.time_step,
        world.step_count,
        next_check,
    )


def restore(world, state, reload):
    """Restore a checked state.

    Args:
        world: World.
        state: WorldState.
        reload: function that loads all models into a cleared engine.

    Returns:
        What is not as it was: one sentence, or ''.
    """
    pursued = [(each, each.goal) for loaded in state.controllers for each in loaded]
    world.contacts.begin_restore()
    world.models = dict(state.models)
    known = state.engine.is_cleared or world.engine.layout == state.engine.layout
    if bodies_of(world.models) != state.bodies or not known and are_first(state.bodies):
        reload()
    world.contacts.prepare(world.models)
    state.objects.restore()
    world.contacts.end_restore()
    same = world.engine.restore_bodies(state.engine)
    for model, placed in zip(state.models.values(), state.placed):
        model.placed = placed
    for controller, goal in pursued:
        controller.resume(goal)
    return "" if same else COLD


def bodies_of(models):
    return tuple(model.body for model in models.values())


def are_first(bodies):
    """Whether a cleared engine gives bodies these numbers."""
    return bodies == tuple(range(len(bodies)))


def controllers_of(model):
    return () if model.manager is None else model.manager.controllers()
