"""Contacts beside the solver: friction of pairs, slip, release, links without weight."""

from bullet_sim.models.friction import Friction
from bullet_sim.models.release import Release
from bullet_sim.models.sanity import PERIOD, trouble
from bullet_sim.models.slip import Slip
from bullet_sim.models.weight import Weight

LOOK = 10  # steps between two looks at contacts while nothing slides


class Contacts:
    """Everything about contacts that needs a look between steps.

    Looks happen at fixed step counts, so that results do not depend on the size of batches.

    Args:
        engine: the Engine.
        on_trouble: function of one sentence, called once a model that has gone astray.
    """

    def __init__(self, engine, on_trouble=None):
        self._engine = engine
        self.on_trouble = on_trouble
        self._friction, self._slip = Friction(engine), Slip(engine)
        self._release, self._weight = Release(engine), Weight(engine)
        self._models, self._changed, self._astray = {}, False, set()

    def came(self, model):
        """A model was spawned, put somewhere, or loaded anew."""
        self._changed = True
        self._release.suspect(model)

    def placed(self, model):
        """A model was put somewhere."""
        self._release.suspect(model)

    def went(self, model):
        """A model goes."""
        self._changed = True
        self._release.forget(model)
        self._astray.discard(model.name)

    def clear(self):
        """All models are about to be loaded anew."""
        self._changed, self._astray = True, set()
        self._release.clear()

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
            return min(count, LOOK - step % LOOK)
        return count

    def act(self):
        """Act on the coming step."""
        if self._release.active:
            self._release.move()
        if self._weight.active:
            self._weight.lift()
        if self._slip.active:
            self._slip.push()

    def look(self, step):
        """After a stride, `step` steps having been made."""
        due = step % LOOK == 0
        if self._slip.watching and (due or self._slip.active):
            self._slip.look()
        if due and self._friction.watched:
            self._friction.follow()

    def check(self):
        """Say once of each model that it has gone astray."""
        for name, model in self._models.items():
            if name in self._astray or model.is_static or self.on_trouble is None:
                continue
            text = trouble(model, self._engine)
            if text is not None:
                self._astray.add(name)
                self.on_trouble(text)


__all__ = ["LOOK", "PERIOD", "Contacts"]
