"""Contacts beside the solver: friction of pairs, slip, release, links without weight."""

from bullet_sim.models.friction import Friction
from bullet_sim.models.plausibility import implausible_state
from bullet_sim.models.release import Release
from bullet_sim.models.slip import Slip
from bullet_sim.models.weight import Weight

CHECK_STEPS = 10  # steps between two checks of contacts while nothing slides


class Contacts:
    """Everything about contacts that is computed between steps.

    Contacts are checked at fixed step counts, so that results do not depend on the size of batches.

    Args:
        engine: the Engine.
        on_implausible: function of one sentence, called once for each model whose state is
            implausible.
    """

    def __init__(self, engine, on_implausible=None):
        self._engine = engine
        self.on_implausible = on_implausible
        self._friction, self._slip = Friction(engine), Slip(engine)
        self._release, self._weight = Release(engine), Weight(engine)
        self._models, self._changed, self._reported = {}, False, set()

    def model_added(self, model):
        """A model was spawned or reloaded."""
        self._changed = True
        self._release.check_later(model)

    def model_moved(self, model):
        """The pose of a model was set."""
        self._release.check_later(model)

    def model_removed(self, model):
        """A model is about to be deleted."""
        self._changed = True
        self._release.remove(model)
        self._reported.discard(model.name)

    def clear(self):
        """All models are about to be reloaded."""
        self._changed, self._reported = True, set()
        self._release.clear()

    @property
    def is_releasing(self):
        """Whether models are on their way out of others."""
        return self._release.moving

    @property
    def is_quiet(self):
        """Whether stride, apply_forces and update have nothing to do, until a model changes."""
        return not (
            self._slip.watching
            or self._friction.watched
            or self._release.active
            or self._weight.active
        )

    def begin_restore(self):
        """A saved state is about to be restored: end what the engine does for the present one."""
        self._release.end()
        self._friction.restart()

    def end_restore(self):
        """A saved state was restored: have the engine do what belongs to it."""
        self._friction.resume()
        self._release.resume()

    def prepare(self, models):
        """Before the first step after a change.

        Args:
            models: of the world, by name.
        """
        if not self._changed:
            return
        self._changed, self._models = False, models
        self._friction.assign(models.values())
        self._slip.assign(models.values())
        self._weight.assign(models.values())

    def stride(self, step, count):
        """How many of `count` steps can be made at once, `step` steps having been made."""
        if self._slip.active or self._release.active or self._weight.active:
            return 1
        if self._slip.watching or self._friction.watched:
            return min(count, CHECK_STEPS - step % CHECK_STEPS)
        return count

    def apply_forces(self):
        """Apply forces for the next step."""
        if self._release.active:
            self._release.move()
        if self._weight.active:
            self._weight.apply()
        if self._slip.active:
            self._slip.apply()

    def update(self, step):
        """After a stride, `step` steps having been made."""
        due = step % CHECK_STEPS == 0
        if self._slip.watching and (due or self._slip.active):
            self._slip.update()
        if due and self._friction.watched:
            self._friction.update()

    def check(self):
        """Report each model with an implausible state once."""
        for name, model in self._models.items():
            if name in self._reported or model.is_static or self.on_implausible is None:
                continue
            text = implausible_state(model, self._engine)
            if text is not None:
                self._reported.add(name)
                self.on_implausible(text)
