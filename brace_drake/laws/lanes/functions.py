"""What a law says where copies may answer an `if` differently.

With plain floats each is the plain thing, and costs nothing.
"""

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from brace_drake.laws.lanes.kinds import COUNT, LANES, MASK, index


@intrinsic
def lead(typingctx, value):
    """The first copy's value: for what is alike in all of them, or may be
    decided for all by one.
    """
    if value == LANES:

        def take_first(context, builder, sig, args):
            return builder.extract_element(args[0], index(0))

        return types.float64(value), take_first
    return value(value), lambda context, builder, sig, args: args[0]


@intrinsic
def of_copy(typingctx, value, copy):
    """One copy's value."""
    if value == LANES:

        def take(context, builder, sig, args):
            return builder.extract_element(*args)

        return types.float64(value, types.int64), take
    return value(value, copy), lambda context, builder, sig, args: args[0]


@intrinsic
def where(typingctx, condition, a, b):
    """Copy by copy: a where the condition holds, else b."""
    if condition == MASK:
        sig = LANES(MASK, LANES, LANES)
    elif LANES in (a, b):
        sig = LANES(types.boolean, LANES, LANES)
    else:
        sig = types.float64(types.boolean, types.float64, types.float64)

    def select(context, builder, signature, args):
        return builder.select(*args)

    return sig, select


def _gathered(condition, passes):
    """Whether the bits of a mask, taken as a number, pass a test."""

    def gather(context, builder, sig, args):
        kind = ir.IntType(COUNT)
        bits = builder.bitcast(args[0], kind)
        return passes(builder, bits, kind)

    if condition == MASK:
        return types.boolean(condition), gather
    return types.boolean(types.boolean), lambda c, b, s, args: args[0]


@intrinsic
def every(typingctx, condition):
    """Whether a condition holds in all copies."""
    return _gathered(
        condition,
        lambda builder, bits, kind: builder.icmp_unsigned(
            "==", bits, ir.Constant(kind, 2**COUNT - 1)
        ),
    )


@intrinsic
def some(typingctx, condition):
    """Whether a condition holds in any copy."""
    return _gathered(
        condition,
        lambda builder, bits, kind: builder.icmp_unsigned(
            "!=", bits, ir.Constant(kind, 0)
        ),
    )
