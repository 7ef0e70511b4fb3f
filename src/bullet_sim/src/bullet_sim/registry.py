"""Names of types, and the classes or functions that stand for them."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable, Iterable
from typing import Any, Dict, Generic, TypeVar

T = TypeVar("T")
E = TypeVar("E")


def load_files(package: str, folders: Iterable[str]) -> None:
    """Import each module of a package's folders, its __path__, which enters what it has."""
    for module in pkgutil.iter_modules(folders):
        importlib.import_module(f"{package}.{module.name}")


class ByClass(Dict[type, T]):
    """What stands for the objects of classes, and of subclasses that have nothing of their own."""

    def enter(self, *classes: type) -> Callable[[E], E]:
        """Decorator that enters what stands for classes."""

        def decorate(entry: Any) -> Any:
            self.update(dict.fromkeys(classes, entry))
            return entry

        return decorate

    def of(self, item: object) -> T:
        """What stands for an object; KeyError: nothing does."""
        for base in type(item).__mro__:
            if base in self:
                return self[base]
        raise KeyError(type(item))


class Registry(Generic[T]):
    """Built-in entries by name, and those that others add.

    Args:
        label: of an entry in messages, e.g. "controller type".
    """

    def __init__(self, label: str) -> None:
        self.label = label
        self._entries: dict[str, T] = {}
        self._sources: list[tuple[Callable[[str], T | None], Callable[[], tuple[str, ...]]]] = []

    def register(self, *names: str, **facts: Any) -> Callable[[T], T]:
        """Decorator that enters a class or a function under names.

        Args:
            facts: attributes that it gets.

        Raises:
            ValueError: a name is taken.
        """

        def enter(entry: T) -> T:
            for name in names:
                if name in self._entries:
                    raise ValueError(f"{self.label} '{name}' is registered already")
                self._entries[name] = entry
            for key, value in facts.items():
                setattr(entry, key, value)
            return entry

        return enter

    def add_source(
        self, find: Callable[[str], T | None], names: Callable[[], tuple[str, ...]]
    ) -> Callable[[], None]:
        """Add entries that are looked up when none is built in, in the order of these calls.

        Args:
            find: function: name -> entry, or None for an unknown name.
            names: function that returns all names that it knows.

        Returns:
            Function that removes the source.
        """
        source = (find, names)
        self._sources.append(source)
        return lambda: self._sources.remove(source)

    def find(self, name: str) -> T:
        """The entry of a name.

        Raises:
            KeyError: unknown.
        """
        if name in self._entries:
            return self._entries[name]
        for find, _ in self._sources:
            entry = find(name)
            if entry is not None:
                return entry
        raise KeyError(name)

    def is_built_in(self, name: str) -> bool:
        """Whether it is registered itself, without a source."""
        return name in self._entries

    def names(self) -> tuple[str, ...]:
        """All names, the built-in ones first."""
        others = [name for _, names in self._sources for name in names()]
        return tuple(dict.fromkeys([*self._entries, *others]))
