"""Attributes of plugins do not take the place of their bases' methods."""

import ast
import inspect
import textwrap

import bullet_bridge.plugins
import pytest
from bullet_bridge.plugins.base import ROS_SIDE

CLASSES = sorted(set(ROS_SIDE.values()), key=lambda found: found.__qualname__)


def attributes(cls):
    """Names that a class' methods assign to self; none of a class that is made without a text."""
    if not any(map(inspect.isroutine, vars(cls).values())):
        return []
    tree = ast.parse(textwrap.dedent(inspect.getsource(cls)))
    targets = [
        name
        for node in ast.walk(tree)
        if isinstance(node, (ast.Assign, ast.AnnAssign, ast.AugAssign))
        for target in (node.targets if isinstance(node, ast.Assign) else [node.target])
        for name in (target.elts if isinstance(target, ast.Tuple) else [target])
    ]
    return {
        name.attr
        for name in targets
        if isinstance(name, ast.Attribute) and getattr(name.value, "id", "") == "self"
    }


@pytest.mark.parametrize("cls", CLASSES, ids=lambda cls: cls.__name__)
def test_no_attribute_hides_a_method(cls):
    for base in cls.__mro__[:-1]:
        if base.__module__.startswith(("bullet_bridge", "bullet_sim")):
            for name in attributes(base):
                assert not inspect.isfunction(getattr(cls, name, None)), f"{base.__name__}.{name}"


def test_all_plugins_are_looked_at():
    assert bullet_bridge.plugins and len(CLASSES) > 15
