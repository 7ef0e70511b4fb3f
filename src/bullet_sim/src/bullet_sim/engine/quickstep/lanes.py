"""Four numbers in one register of the processor, for functions that numba compiles.

numba computes with single numbers. A value of the type Lanes has four, and each operation is done
on all four at once; processors with narrower registers do the same in two halves, with the same
bits. Nothing is fused or reordered.
"""

import operator
from typing import Any

from llvmlite import ir
from numba import types
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, models, register_model

_NUMBER, _PLACE = ir.DoubleType(), ir.IntType(32)
_TWO, _FOUR = ir.VectorType(_NUMBER, 2), ir.VectorType(_NUMBER, 4)


class LanesType(types.Type):
    """numba's type of four numbers."""

    def __init__(self) -> None:
        super().__init__(name="Lanes")


LANES = LanesType()


@register_model(LanesType)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _FOUR)


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


@intrinsic
def load(typing: Any, array: Any, place: Any) -> Any:
    """Four numbers of a flat array (float64) from a place on."""

    def generate(context: Any, builder: Any, signed: Any, args: Any) -> Any:
        return builder.load(_pointer(context, builder, signed, args, _FOUR), align=8)

    return LANES(array, types.int64), generate


@intrinsic
def load_twice(typing: Any, array: Any, place: Any) -> Any:
    """Two numbers of a flat array, in the first two lanes and in the last two."""

    def generate(context: Any, builder: Any, signed: Any, args: Any) -> Any:
        two = builder.load(_pointer(context, builder, signed, args, _TWO), align=8)
        return _shuffled(builder, two, (0, 1, 0, 1))

    return LANES(array, types.int64), generate


@intrinsic
def store(typing: Any, array: Any, place: Any, lanes: Any) -> Any:
    """Write four numbers into a flat array from a place on."""

    def generate(context: Any, builder: Any, signed: Any, args: Any) -> Any:
        builder.store(args[2], _pointer(context, builder, signed, args, _FOUR), align=8)
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

        return LANES(one, two), generate

    return intrinsic(typed)


least, greatest = _choosing("<"), _choosing(">")  # of each lane; the second where one is no number


class _Operation(AbstractTemplate):
    def generic(self, args: Any, _kws: Any) -> Any:
        return signature(LANES, *args) if args == (LANES, LANES) else None


def _enter(operation: Any, instruction: str) -> None:
    infer_global(operation)(type(f"_Lanes_{instruction}", (_Operation,), {}))

    def generate(_context: Any, builder: Any, _signed: Any, args: Any) -> Any:
        return getattr(builder, instruction)(*args)

    lower_builtin(operation, LANES, LANES)(generate)


for _operation, _instruction in (
    (operator.add, "fadd"),
    (operator.iadd, "fadd"),
    (operator.sub, "fsub"),
    (operator.isub, "fsub"),
    (operator.mul, "fmul"),
):
    _enter(_operation, _instruction)
