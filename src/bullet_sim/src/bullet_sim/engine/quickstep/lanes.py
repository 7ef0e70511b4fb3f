"""Four or eight numbers in one register of the processor, for functions that numba compiles.

numba computes with single numbers. A value of the type Lanes has four, or eight, and each operation
is done on all at once; processors with narrower registers do the same in parts, with the same bits.
Nothing is fused or reordered.
"""

from __future__ import annotations

import operator
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, models, register_model

_NUMBER, _PLACE = ir.DoubleType(), ir.IntType(32)
_TWO, _FOUR, _EIGHT = (ir.VectorType(_NUMBER, count) for count in (2, 4, 8))


class LanesType(types.Type):
    """numba's type of a number of numbers."""

    def __init__(self, count: int) -> None:
        super().__init__(name=f"Lanes{count}")
        self.count = count


LANES, EIGHT_LANES = LanesType(4), LanesType(8)


@register_model(LanesType)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, ir.VectorType(_NUMBER, kind.count))


def _pointer(context: Any, builder: Any, signed: Any, args: Any, kind: Any) -> Any:
    """Address of the number `args[1]` of a flat array, as that of a vector."""
    array = context.make_array(signed.args[0])(context, builder, args[0])
    place = builder.gep(array.data, [args[1]], inbounds=True)
    return builder.bitcast(place, kind.as_pointer())


def _shuffled(builder: Any, vector: Any, places: tuple[int, ...]) -> Any:
    chosen = ir.Constant(
        ir.VectorType(_PLACE, len(places)), [ir.Constant(_PLACE, i) for i in places]
    )
    return builder.shuffle_vector(vector, ir.Constant(vector.type, ir.Undefined), chosen)


def _loading(kind: LanesType, vector: Any) -> Any:
    def typed(typing: Any, array: Any, place: Any) -> Any:
        def generate(context: Any, builder: Any, signed: Any, args: Any) -> Any:
            return builder.load(_pointer(context, builder, signed, args, vector), align=8)

        return kind(array, types.int64), generate

    return intrinsic(typed)


# numbers of a flat array (float64) from a place on
load, load_eight = _loading(LANES, _FOUR), _loading(EIGHT_LANES, _EIGHT)


@intrinsic
def load_twice(typing: Any, array: Any, place: Any) -> Any:
    """Two numbers of a flat array, in the first two lanes and in the last two."""

    def generate(context: Any, builder: Any, signed: Any, args: Any) -> Any:
        two = builder.load(_pointer(context, builder, signed, args, _TWO), align=8)
        return _shuffled(builder, two, (0, 1, 0, 1))

    return LANES(array, types.int64), generate


@intrinsic
def store(typing: Any, array: Any, place: Any, lanes: Any) -> Any:
    """Write lanes into a flat array from a place on."""

    def generate(context: Any, builder: Any, signed: Any, args: Any) -> Any:
        builder.store(args[2], _pointer(context, builder, signed, args, args[2].type), align=8)
        return context.get_dummy_value()

    return types.void(array, types.int64, lanes), generate


def _repeating(places: tuple[int, ...]) -> Any:
    def typed(typing: Any, lanes: Any) -> Any:
        def generate(_context: Any, builder: Any, _signed: Any, args: Any) -> Any:
            return _shuffled(builder, args[0], places)

        return LANES(lanes), generate

    return intrinsic(typed)


first_two = _repeating((0, 1, 0, 1))  # the first two lanes, also in the last two
last_two = _repeating((2, 3, 2, 3))  # the last two lanes, also in the first two


def _choosing(comparison: str) -> Any:
    def typed(typing: Any, one: Any, two: Any) -> Any:
        def generate(_context: Any, builder: Any, _signed: Any, args: Any) -> Any:
            one, two = args
            return builder.select(builder.fcmp_ordered(comparison, one, two), one, two)

        return one(one, two), generate

    return intrinsic(typed)


least, greatest = _choosing("<"), _choosing(">")  # of each lane; the second where one is no number


@intrinsic
def spread(typing: Any, number: Any) -> Any:
    """A number in eight lanes."""

    def generate(_context: Any, builder: Any, _signed: Any, args: Any) -> Any:
        one = builder.insert_element(ir.Constant(_EIGHT, ir.Undefined), args[0], _PLACE(0))
        return _shuffled(builder, one, (0,) * 8)

    return EIGHT_LANES(types.float64), generate


@intrinsic
def choose(typing: Any, small: Any, large: Any, one: Any, two: Any) -> Any:
    """One where small <= large, else, and where either is no number, the other."""

    def generate(_context: Any, builder: Any, _signed: Any, args: Any) -> Any:
        return builder.select(builder.fcmp_ordered("<=", args[0], args[1]), args[2], args[3])

    return one(small, large, one, two), generate


@intrinsic
def roots(typing: Any, lanes: Any) -> Any:
    """Square roots of eight lanes; NaN of what is below 0."""

    def generate(_context: Any, builder: Any, _signed: Any, args: Any) -> Any:
        kind = ir.FunctionType(_EIGHT, [_EIGHT])
        root = cgutils.get_or_insert_function(builder.module, kind, "llvm.sqrt.v8f64")
        return builder.call(root, args)

    return lanes(lanes), generate


def _reducing(comparison: str) -> Any:
    def typed(typing: Any, lanes: Any) -> Any:
        def generate(_context: Any, builder: Any, _signed: Any, args: Any) -> Any:
            one, count = args[0], 8
            while count > 1:
                count //= 2
                halves = tuple(range(count)), tuple(range(count, 2 * count))
                one, two = (_shuffled(builder, one, half) for half in halves)
                one = builder.select(builder.fcmp_ordered(comparison, one, two), one, two)
            return builder.extract_element(one, _PLACE(0))

        return types.float64(lanes), generate

    return intrinsic(typed)


lowest, highest = _reducing("<"), _reducing(">")  # of eight lanes


class _Operation(AbstractTemplate):
    def generic(self, args: Any, _kws: Any) -> Any:
        one, two = args
        return signature(one, one, two) if one == two and isinstance(one, LanesType) else None


def _enter(operation: Any, instruction: str) -> None:
    infer_global(operation)(type(f"_Lanes_{instruction}", (_Operation,), {}))

    def generate(_context: Any, builder: Any, _signed: Any, args: Any) -> Any:
        return getattr(builder, instruction)(*args)

    lower_builtin(operation, LanesType, LanesType)(generate)


for _operation, _instruction in (
    (operator.add, "fadd"),
    (operator.iadd, "fadd"),
    (operator.sub, "fsub"),
    (operator.isub, "fsub"),
    (operator.mul, "fmul"),
    (operator.truediv, "fdiv"),
):
    _enter(_operation, _instruction)
