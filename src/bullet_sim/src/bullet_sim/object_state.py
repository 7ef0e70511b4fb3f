"""State of Python objects, restored in place: whoever holds one of them sees what it was."""

import collections
import copy
import dataclasses

import numpy as np

_CONTAINERS = (list, dict, set, collections.deque)


class ObjectState:
    """What objects and all that they refer to hold now.

    Walked are attributes, containers, arrays and random generators. Objects of other modules than
    the named ones and frozen dataclasses are not: they stay as they are.

    Args:
        roots: objects to begin with.
        modules: prefixes of the modules whose classes' objects are walked.
        leave: classes whose objects are left alone all the same.
    """

    def __init__(self, roots, modules, leave=()):
        self._modules, self._leave = tuple(modules), tuple(leave)
        self._saved = {}  # id -> (object, copy of its content)
        waiting = list(roots)
        while waiting:
            item = waiting.pop()
            if id(item) not in self._saved:
                waiting += self._save(item)

    def _save(self, item):
        """Save the content of one object; returns what it refers to."""
        if isinstance(item, _CONTAINERS):
            self._saved[id(item)] = item, copy.copy(item)
            return item.values() if isinstance(item, dict) else item
        if isinstance(item, tuple):
            return item
        if isinstance(item, np.ndarray):
            self._saved[id(item)] = item, item.copy()
        elif isinstance(item, np.random.Generator):
            self._saved[id(item)] = item, item.bit_generator.state
        elif self._is_walked(item):
            self._saved[id(item)] = item, dict(vars(item))
            return vars(item).values()
        return ()

    def _is_walked(self, item):
        kind = type(item)
        if not kind.__module__.startswith(self._modules) or isinstance(item, (type, *self._leave)):
            return False
        frozen = dataclasses.is_dataclass(kind) and kind.__dataclass_params__.frozen
        return hasattr(item, "__dict__") and not frozen and not callable(item)

    def restore(self):
        """Give all objects their content back."""
        for item, content in self._saved.values():
            if isinstance(item, np.ndarray):
                item[...] = content
            elif isinstance(item, np.random.Generator):
                item.bit_generator.state = content
            elif isinstance(item, (list, collections.deque)):
                item.clear()
                item.extend(content)
            elif isinstance(item, (dict, set)):
                item.clear()
                item.update(content)
            else:
                vars(item).clear()
                vars(item).update(content)
