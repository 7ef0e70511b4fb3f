"""Saved states forget nothing: each attribute that changes while a simulation runs is named."""

import ast
import importlib
import inspect
import pkgutil
import sys
import textwrap

import numpy as np
import pytest
from bullet_sim.component import Component, Stateful

import bullet_bridge
import bullet_sim

# Methods before the simulation runs, or after: what they assign is configured, not state.
BEFORE = {"__init__", "attach", "close", "configure", "make_output"}
CHANGES = {*"add append appendleft clear discard extend insert pop popleft remove".split()}
CHANGES |= {"setdefault", "update"}


def classes():
    """All Stateful classes of both packages."""
    for package in (bullet_sim, bullet_bridge):
        for found in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            if found.name.rpartition(".")[2] not in ("worker", "relay_process"):  # programs
                importlib.import_module(found.name)
    waiting, known = [Stateful], set()
    while waiting:
        for kind in waiting.pop().__subclasses__():
            if kind not in known and kind.__module__.startswith(("bullet_sim", "bullet_bridge")):
                known.add(kind)
                waiting.append(kind)
    return sorted(known - {Component}, key=lambda kind: (kind.__module__, kind.__name__))


def own_attribute(node):
    """Name of an attribute of self that an expression is, or is an item of."""
    while isinstance(node, ast.Subscript):
        node = node.value
    if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
        return node.attr if node.value.id == "self" else None
    return None


def is_made_stateful(value, kind):
    """Whether an expression makes objects with a state."""
    names = vars(sys.modules[kind.__module__])
    return any(
        isinstance(node, ast.Call)
        and isinstance(node.func, ast.Name)
        and isinstance(names.get(node.func.id), type)
        and issubclass(names[node.func.id], Stateful)
        for node in ast.walk(value)
    )


def changed(kind):
    """(method, attribute) that the methods of a class assign, delete or change in place.

    And attributes of objects with a state, wherever they are made.
    """
    if not any(map(inspect.isroutine, vars(kind).values())):
        return  # also those that a table makes, which have no text
    tree = ast.parse(textwrap.dedent(inspect.getsource(kind))).body[0]
    for method in tree.body:
        if not isinstance(method, ast.FunctionDef):
            continue
        for node in ast.walk(method):
            if method.name in BEFORE and not (
                isinstance(node, ast.Assign) and is_made_stateful(node.value, kind)
            ):
                continue
            targets = []
            if isinstance(node, (ast.Assign, ast.Delete)):
                targets = list(node.targets)
            elif isinstance(node, (ast.AugAssign, ast.AnnAssign)):
                targets = [node.target]
            elif isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
                targets = [node.func.value] if node.func.attr in CHANGES else []
            while targets:
                target = targets.pop()
                if isinstance(target, (ast.Tuple, ast.List)):
                    targets += target.elts
                elif own_attribute(target):
                    yield method.name, own_attribute(target)


def caches(kind):
    """Names of the attributes of a class and its bases that belong to no state."""
    return {name for base in kind.__mro__ for name in vars(base).get("CACHE", ())}


@pytest.mark.parametrize("kind", classes(), ids=lambda kind: kind.__name__)
def test_each_attribute_that_changes_is_in_state_or_cache(kind):
    known = {*kind.state_names(), *caches(kind)}
    forgotten = {f"{attribute} (in {method})" for method, attribute in changed(kind)}
    forgotten = {text for text in forgotten if text.partition(" ")[0] not in known}
    assert not forgotten, f"{kind.__name__}: name them in STATE, or in CACHE"


class Part(Stateful):
    """Something with all kinds of values."""

    STATE = ("values", "array", "random", "parts", "by_name", "other")

    def __init__(self):
        self.values, self.array = [(1, [2])], np.zeros(3)
        self.random = np.random.default_rng(1)
        self.parts, self.by_name = (Counter(), Counter()), {"a": Counter()}
        self.other = object()


class Counter(Stateful):
    """One number."""

    STATE = ("count",)
    count = 0


def test_values_are_copied_objects_are_restored_in_place():
    part = Part()
    inner, generator, other = part.by_name["a"], part.random, part.other
    state = part.get_state()
    for _ in range(2):  # a state can be restored more than once
        numbers = part.random.normal(size=3)
        part.values[0][1].append(3)
        part.array += 1.0
        inner.count = part.parts[1].count = 7
        part.by_name["b"], part.other = Counter(), None
        part.set_state(state)
        assert part.values == [(1, [2])] and not part.array.any()
        assert part.by_name == {"a": inner} and inner.count == part.parts[1].count == 0
        assert part.random is generator and part.other is other
        assert (part.random.normal(size=3) == numbers).all()
        part.set_state(state)
