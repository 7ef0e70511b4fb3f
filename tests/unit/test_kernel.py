"""The kernel of the solver 'ode': its table of colliders, its choice of functions, its records."""

import ast
import itertools
from pathlib import Path

import pytest
from bullet_sim.engine.quickstep import collision, compiled, state
from bullet_sim.engine.quickstep import layout as col

FOLDER = Path(collision.__file__).parent


def test_each_two_kinds_of_solids_have_one_collider_whichever_is_first():
    kinds = col.SPHERE, col.CYLINDER, col.BOX
    assert set(collision.COLLIDERS) == set(itertools.product(kinds, repeat=2))
    for (one, two), (collider, swapped) in collision.COLLIDERS.items():
        other, other_swapped = collision.COLLIDERS[two, one]
        assert collider is other
        assert (one == two) or swapped is not other_swapped


@compiled.compiled
def _plus(a, b):
    return a + b


@compiled.compiled
def _minus(a, b):
    return a - b


@compiled.compiled
def _times(a, b):
    return a * b


def test_a_switch_calls_the_function_of_its_code_and_else_the_last():
    chosen = compiled.switch({5: _plus, 7: _minus, 2: _times})
    assert [chosen(code, 9, 4) for code in (5, 7, 2, 0)] == [13, 5, 36, 36]
    assert compiled.switch({1: _minus})(3, 9, 4) == 5


@pytest.mark.parametrize("record", state.KINDS)
def test_each_array_of_a_record_has_a_kind(record):
    assert len(record._fields) == len(state.KINDS[record])


COMPILED = sorted(set(FOLDER.glob("*.py")) - {FOLDER / "law.py"})  # which takes plain numbers


@pytest.mark.parametrize("path", COMPILED, ids=lambda path: path.stem)
def test_no_function_has_more_than_eight_parameters(path):
    found = {
        node.name: len(node.args.args)
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.FunctionDef)
    }
    assert not {name: count for name, count in found.items() if count > 8}
