"""Parts of a model that act or measure, and states of objects that can be saved and restored."""

from __future__ import annotations

import collections
from typing import Any, ClassVar, NamedTuple

import numpy as np


class Stateful:
    """An object whose state is what the attributes hold that its class and its bases name in STATE.

    Of the values, tuples, lists, dictionaries, sets, deques and arrays are copied. Other Stateful
    objects and NumPy's random generators in them are restored in place: who refers to them still
    does. Any other object is referred to, so replace it instead of changing it.
    """

    STATE: ClassVar[tuple[str, ...]] = ()
    # Attributes that change while the simulation runs and belong to no state: what is computed from
    # others, or how the world outside is. tests/unit/test_state.py knows no third sort.
    CACHE: ClassVar[tuple[str, ...]] = ()

    @classmethod
    def state_names(cls) -> tuple[str, ...]:
        """Names of the attributes of a state, bases' first."""
        return tuple(name for base in reversed(cls.__mro__) for name in vars(base).get("STATE", ()))

    def get_state(self) -> dict[str, Any]:
        """The state, which later changes leave as it is."""
        return {name: _saved(getattr(self, name)) for name in self.state_names()}

    def set_state(self, state: dict[str, Any]) -> None:
        """Restore a result of get_state, any number of times."""
        for name, value in state.items():
            setattr(self, name, _restored(value))


class _Saved(NamedTuple):
    """An object that is restored in place, and its state."""

    item: Any
    state: Any


def _saved(value: Any) -> Any:
    if isinstance(value, Stateful):
        return _Saved(value, value.get_state())
    if isinstance(value, np.random.Generator):
        return _Saved(value, value.bit_generator.state)
    return _copied(value, _saved)


def _restored(value: Any) -> Any:
    if not isinstance(value, _Saved):
        return _copied(value, _restored)
    if isinstance(value.item, Stateful):
        value.item.set_state(value.state)
    else:
        value.item.bit_generator.state = value.state
    return value.item


def _copied(value: Any, each: Any) -> Any:
    """A container with each(item) for its items; anything else as it is."""
    if isinstance(value, np.ndarray):
        return value.copy()
    if isinstance(value, dict):
        return {key: each(item) for key, item in value.items()}
    if isinstance(value, collections.deque):
        return collections.deque(map(each, value), value.maxlen)
    if type(value) in (tuple, list, set):
        return type(value)(map(each, value))
    return value


class Component(Stateful):
    """Part of one model that acts or measures while the simulation runs."""

    def start(self, time: float) -> None:
        """Start: a controller is switched on, a sensor has its first subscriber.

        Args:
            time: of the component's clock [s].
        """

    def update(self, time: float, period: float) -> None:
        """Act or measure: controllers before a physics step, others after one.

        Args:
            time: now [s].
            period: since the last update [s].
        """

    def stop(self) -> None:
        """Stop: a controller is switched off, a sensor has lost its last subscriber."""

    def reset(self, time: float) -> None:
        """Start as configured, after a reset of the world; `time` [s] as start()'s."""
        self.start(time)

    def close(self) -> None:
        """Shut down: the model is deleted."""
