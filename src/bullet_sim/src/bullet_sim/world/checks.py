"""What a world refuses, with a sentence that says why."""

from bullet_sim.description.world import MIN_STEP
from bullet_sim.errors import ModelError, WorldError
from bullet_sim.world.state import are_first, bodies_of, controllers_of


def check_name(name, taken):
    """Check the name of a new model.

    Raises:
        ModelError: it is empty or taken.
    """
    if not name:
        raise ModelError("a model needs a name, this one is empty")
    if name in taken:
        raise ModelError(f"model '{name}' exists already; models are {', '.join(taken)}")


def check_time_step(world, time_step):
    """Check a new physics step [s].

    Raises:
        WorldError: out of bounds, or a period is counted in steps of the present length.
    """
    if not MIN_STEP <= time_step < 1:
        raise WorldError(f"time_step is {time_step} s, must be from {MIN_STEP:g} to below 1")
    busy = [
        name
        for name, model in world.models.items()
        if model.manager is not None or model.description.sensors
    ]
    if busy:
        raise WorldError(
            f"time_step cannot change while models with controllers or sensors "
            f"exist, their periods count in steps: {', '.join(busy)}"
        )
    if world.forces.active:
        raise WorldError(
            "time_step cannot change while a wrench or an effort is applied; clear it first"
        )


def check_state(world, state):
    """Refuse a state that the world cannot go back to.

    Raises:
        WorldError: names what has come and gone.
    """
    for name, model in state.models.items():
        if name not in world.models:
            raise WorldError(f"the state has the model '{name}', which was deleted since")
        if world.models[name] is not model:
            raise WorldError(
                f"model '{name}' was deleted and spawned again since the state was saved"
            )
    for name in world.models:
        if name not in state.models:
            raise WorldError(f"model '{name}' was spawned since the state was saved; delete it")
    for model, loaded in zip(state.models.values(), state.controllers):
        present = controllers_of(model)
        if present != loaded:
            raise WorldError(
                f"controllers of '{model.name}' were loaded or unloaded since the state was saved; "
                f"they were {_names(loaded)} and are {_names(present)}"
            )
    if world.time_step != state.time_step:
        raise WorldError(
            f"the physics step is {world.time_step:g} s, and was {state.time_step:g} s when the "
            "state was saved"
        )
    if bodies_of(state.models) != state.bodies and not are_first(state.bodies):
        raise WorldError(
            "models had been deleted before the state was saved, and the world was reset since; "
            "save a new state"
        )


def _names(controllers):
    return ", ".join(controller.spec.name for controller in controllers) or "(none)"
