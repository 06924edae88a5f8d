"""`Lanes`, a float of each copy, and `LaneMask`, a truth of each, for numba.

Arithmetic is that of vectors in LLVM: operation by operation what the scalar
law does, so that a copy comes out as it would alone. Types and lowering as in
numba's manual, "Low-level extension API".
"""

import math
import operator

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.typeconv import Conversion
from numba.core.typing.templates import (
    AbstractTemplate,
    infer_global,
    signature,
)
from numba.extending import (
    lower_builtin,
    lower_cast,
    models,
    register_model,
)

# Copies in a vector: what a processor with 256-bit registers takes at once.
COUNT = 4

VECTOR = ir.VectorType(ir.DoubleType(), COUNT)
_MASK = ir.VectorType(ir.IntType(1), COUNT)
_INDEX = ir.IntType(32)


class Lanes(types.Type):
    """A float64 of each copy."""

    def __init__(self):
        super().__init__(name=f"Lanes{COUNT}")

    def can_convert_from(self, typingctx, other):
        """Numbers become the same in every copy."""
        return Conversion.safe if _is_number(other) else None

    def unify(self, typingctx, other):
        """With a number: lanes."""
        return self if _is_number(other) else None


class LaneMask(types.Type):
    """A truth of each copy."""

    def __init__(self):
        super().__init__(name=f"LaneMask{COUNT}")


LANES, MASK = Lanes(), LaneMask()


def _is_number(kind) -> bool:
    return isinstance(kind, types.Float | types.Integer)


@register_model(Lanes)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, dmm, fe_type):
        super().__init__(dmm, fe_type, VECTOR)


@register_model(LaneMask)
class _LaneMaskModel(models.PrimitiveModel):
    def __init__(self, dmm, fe_type):
        super().__init__(dmm, fe_type, _MASK)


def index(place: int):
    """A constant place in a vector."""
    return ir.Constant(_INDEX, place)


def join_lanes(builder, values):
    """A vector of scalar values."""
    kind = ir.VectorType(values[0].type, COUNT)
    vector = ir.Constant(kind, ir.Undefined)
    for place, value in enumerate(values):
        vector = builder.insert_element(vector, value, index(place))
    return vector


@lower_cast(types.Float, Lanes)
@lower_cast(types.Integer, Lanes)
def _cast_number(context, builder, fromty, toty, value):
    value = context.cast(builder, value, fromty, types.float64)
    one = ir.Constant(ir.VectorType(value.type, COUNT), ir.Undefined)
    one = builder.insert_element(one, value, index(0))
    places = ir.Constant(ir.VectorType(_INDEX, COUNT), [0] * COUNT)
    return builder.shuffle_vector(one, one, places)


def _register(function, takes, returns, lower):
    """Lets compiled code call a function with kinds of lanes.

    Args:
        function: As laws call it.
        takes: Kinds of its arguments; where lanes are taken numbers may stand,
            but not in all places.
        returns: Kind of the result.
        lower: (context, builder, values) -> value.
    """

    class Template(AbstractTemplate):
        def generic(self, args, kws):
            fits = len(args) == len(takes) and all(
                a == t or (t == LANES and _is_number(a))
                for a, t in zip(args, takes, strict=True)
            )
            if fits and any(a in (LANES, MASK) for a in args):
                return signature(returns, *takes)
            return None

    infer_global(function)(Template)

    @lower_builtin(function, *takes)
    def _lower(context, builder, sig, args):
        return lower(context, builder, args)


def call_llvm(builder, name, *values):
    """An intrinsic of LLVM, on floats or vectors."""
    kind = ir.FunctionType(values[0].type, [v.type for v in values])
    size = "f64" if values[0].type == ir.DoubleType() else f"v{COUNT}f64"
    full = f"llvm.{name}.{size}"
    function = cgutils.get_or_insert_function(builder.module, kind, full)
    return builder.call(function, values)


def _binary(instruction):
    return lambda context, builder, args: getattr(builder, instruction)(*args)


def _compare(sign):
    def lower(context, builder, args):
        # A number that is none differs from all, as for floats.
        if sign == "!=":
            return builder.fcmp_unordered(sign, *args)
        return builder.fcmp_ordered(sign, *args)

    return lower


def _least(sign):
    def lower(context, builder, args):
        a, b = args
        # As Python's: the first where the second is not less, or greater.
        return builder.select(builder.fcmp_ordered(sign, b, a), b, a)

    return lower


def _intrinsic(name):
    return lambda context, builder, args: call_llvm(builder, name, *args)


def call_each(context, builder, function, args):
    """A function of floats, copy by copy where there are several."""
    floats = (types.float64,) * len(args)
    kind = context.typing_context.resolve_value_type(function)
    context.typing_context.resolve_function_type(kind, floats, {})
    call = context.get_function(kind, signature(types.float64, *floats))
    if args[0].type != VECTOR:
        return call(builder, args)
    values = [
        call(builder, [builder.extract_element(a, index(k)) for a in args])
        for k in range(COUNT)
    ]
    return join_lanes(builder, values)


for _operators, _instruction in (
    ((operator.add, operator.iadd), "fadd"),
    ((operator.sub, operator.isub), "fsub"),
    ((operator.mul, operator.imul), "fmul"),
    ((operator.truediv, operator.itruediv), "fdiv"),
):
    for _operator in _operators:
        _register(_operator, (LANES, LANES), LANES, _binary(_instruction))
for _operator, _sign in (
    (operator.lt, "<"),
    (operator.le, "<="),
    (operator.gt, ">"),
    (operator.ge, ">="),
    (operator.eq, "=="),
    (operator.ne, "!="),
):
    _register(_operator, (LANES, LANES), MASK, _compare(_sign))
_register(operator.and_, (MASK, MASK), MASK, _binary("and_"))
_register(operator.or_, (MASK, MASK), MASK, _binary("or_"))
_register(min, (LANES, LANES), LANES, _least("<"))
_register(max, (LANES, LANES), LANES, _least(">"))
_register(
    operator.neg, (LANES,), LANES, lambda c, builder, a: builder.fneg(a[0])
)
_register(abs, (LANES,), LANES, _intrinsic("fabs"))
_register(math.sqrt, (LANES,), LANES, _intrinsic("sqrt"))
_register(np.sqrt, (LANES,), LANES, _intrinsic("sqrt"))
# To the nearest whole number, half to even, as Python's.
_register(round, (LANES,), LANES, _intrinsic("rint"))
