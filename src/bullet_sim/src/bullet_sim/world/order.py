"""The order of a world's models, of which the last bits of the results depend."""

from collections.abc import Iterable


class ModelOrder:
    """Models of the world file in file order, then the others by name.

    The last bits of the engine's results depend on the order in which bodies were loaded, and
    programs that spawn models at the same time do so in any order.
    """

    def __init__(self) -> None:
        self._of_file: tuple[str, ...] = ()
        self._fresh = True  # no step since the start or the last reset
        self._changed = self._deleted = False  # models were spawned or deleted; deleted

    def add_of_file(self, names: Iterable[str]) -> None:
        """Add names of models that a world file holds, in its order."""
        self._of_file += tuple(names)

    def sorted(self, names: Iterable[str]) -> list[str]:
        """Names in the order in which their models are loaded."""
        first = {name: number for number, name in enumerate(self._of_file)}
        return sorted(names, key=lambda name: (first.get(name, len(first)), name))

    def spawned(self) -> None:
        """Note that a model was spawned."""
        self._changed = True

    def deleted(self) -> None:
        """Note that a model was deleted."""
        self._changed = self._deleted = True

    def stepped(self) -> None:
        """Note that time has advanced: from now on models stay as they were loaded."""
        self._fresh = False

    def reset(self) -> None:
        """Note that all models were loaded into a cleared engine."""
        self._fresh, self._changed, self._deleted = True, False, False

    def take_change(self) -> tuple[bool, bool]:
        """What has happened to the models before the first step, since this was asked last.

        Returns:
            (whether models were spawned or deleted, whether some were deleted).
        """
        if not (self._fresh and self._changed):
            return False, False
        deleted, self._changed, self._deleted = self._deleted, False, False
        return True, deleted


def reload_in_place(models, reload):
    """Reload models; poses and joint positions set since they were loaded stay.

    Args:
        models: the Models, iterable twice.
        reload: function that loads all models into a cleared engine.
    """
    saved = [model.save_state() for model in models]
    reload()
    for model, state in zip(models, saved):
        model.restore_state(state)
