"""Elementary functions of floats and of lanes, alike to the last bit.

Rational approximations as in Moshier, Methods and Programs for Mathematical
Functions, 1989 (Cephes), good to about an ulp, near 0, where a brace works;
elsewhere those of the C library, copy by copy.
"""

import math

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from brace_drake.laws.compiled import compiled_law
from brace_drake.laws.lanes.functions import every, where
from brace_drake.laws.lanes.kinds import COUNT, LANES, call_each, call_llvm

_EIGHTH_TURN = 0.78539816339744830962
# A quarter turn in three parts, so that multiples of the first two are exact.
_QUARTER_TURN = (
    1.57079625129699707031,
    7.54978941586159635335e-8,
    5.39030285815811905290e-15,
)
# Beyond so many quarter turns they are not.
_MOST_TURNS = 1e6
_TAN_22_5 = 0.41421356237309504880
# ln 2 in two parts, so that multiples of it are exact.
_LN2_HIGH, _LN2_LOW = 6.93145751953125e-1, 1.42860682030941723212e-6
_LARGEST = 700.0


@intrinsic
def floor(typingctx, x):
    """The whole number at or below x."""
    return x(x), lambda c, builder, s, a: call_llvm(builder, "floor", a[0])


@intrinsic
def _times_power_of_two(typingctx, x, n):
    """x 2^n of whole n; the result must neither overflow nor be subnormal."""

    def scale(context, builder, sig, args):
        whole, first, last = ir.IntType(64), 1023, 52
        if sig.return_type == LANES:
            whole = ir.VectorType(whole, COUNT)
            first, last = [first] * COUNT, [last] * COUNT
        power = builder.fptosi(args[1], whole)
        power = builder.add(power, ir.Constant(whole, first))
        power = builder.shl(power, ir.Constant(whole, last))
        return builder.fmul(args[0], builder.bitcast(power, args[0].type))

    return x(x, n), scale


def _lower_each(function):
    def lower(context, builder, sig, args):
        return call_each(context, builder, function, args)

    return lower


@intrinsic
def _library_sin(typingctx, x):
    return x(x), _lower_each(math.sin)


@intrinsic
def _library_cos(typingctx, x):
    return x(x), _lower_each(math.cos)


@intrinsic
def power(typingctx, x, y):
    """x^y, of the C library, copy by copy."""
    kind = LANES if LANES in (x, y) else types.float64
    return kind(kind, kind), _lower_each(math.pow)


@intrinsic
def _library_atan2(typingctx, y, x):
    kind = LANES if LANES in (y, x) else types.float64
    return kind(kind, kind), _lower_each(math.atan2)


@compiled_law
def exp(x):
    """e^x, of -700 to 700."""
    x = max(min(x, _LARGEST), -_LARGEST)
    n = floor(x * 1.4426950408889634074 + 0.5)
    x = x - n * _LN2_HIGH - n * _LN2_LOW
    z = x * x
    p = x * (
        (1.26177193074810590878e-4 * z + 3.02994407707441961300e-2) * z
        + 9.99999999999999999910e-1
    )
    q = (
        (3.00198505138664455042e-6 * z + 2.52448340349684104192e-3) * z
        + 2.27265548208155028766e-1
    ) * z + 2.00000000000000000009
    return _times_power_of_two(1.0 + 2.0 * p / (q - p), n)


@compiled_law
def tanh(x):
    """The hyperbolic tangent."""
    z = x * x
    p = (
        -9.64399179425052238628e-1 * z - 9.92877231001918586564e1
    ) * z - 1.61468768441708447952e3
    q = (
        (z + 1.12811678491632931402e2) * z + 2.23548839060100448583e3
    ) * z + 4.84406305325125486048e3
    near = x + x * z * p / q
    is_near = abs(x) < 0.625
    if every(is_near):
        return near
    far = 1.0 - 2.0 / (exp(2.0 * abs(x)) + 1.0)
    return where(is_near, near, where(x < 0.0, -far, far))


@compiled_law
def _sin_near(x):
    z = x * x
    p = 1.58962301576546568060e-10 * z - 2.50507477628578072866e-8
    p = p * z + 2.75573136213857245213e-6
    p = p * z - 1.98412698295895385996e-4
    p = p * z + 8.33333333332211858878e-3
    p = p * z - 1.66666666666666307295e-1
    return x + x * z * p


@compiled_law
def _cos_near(x):
    z = x * x
    p = -1.13585365213876817300e-11 * z + 2.08757008419747316778e-9
    p = p * z - 2.75573141792967388112e-7
    p = p * z + 2.48015872888517045348e-5
    p = p * z - 1.38888888888730564116e-3
    p = p * z + 4.16666666666665929218e-2
    return 1.0 - 0.5 * z + z * z * p


@compiled_law
def _quarters(x):
    # Whole quarter turns (0 to 3) in x, and the rest of it.
    n = floor(x * (0.5 / _EIGHTH_TURN) + 0.5)
    rest = x - n * _QUARTER_TURN[0] - n * _QUARTER_TURN[1]
    return n - 4.0 * floor(0.25 * n), rest - n * _QUARTER_TURN[2]


@compiled_law
def _turned(quarters, sine, cosine):
    # The sine, so many quarter turns on.
    value = where(quarters - 2.0 * floor(0.5 * quarters) == 0.0, sine, cosine)
    return where(quarters >= 2.0, -value, value)


@compiled_law
def sin(x):
    """The sine."""
    if every(abs(x) <= _EIGHTH_TURN):
        return _sin_near(x)
    quarters, rest = _quarters(x)
    found = _turned(quarters, _sin_near(rest), _cos_near(rest))
    is_small = abs(x) <= _MOST_TURNS
    if every(is_small):
        return found
    return where(is_small, found, _library_sin(x))


@compiled_law
def cos(x):
    """The cosine."""
    if every(abs(x) <= _EIGHTH_TURN):
        return _cos_near(x)
    quarters, rest = _quarters(x)
    found = _turned(
        where(quarters == 3.0, 0.0, quarters + 1.0),
        _sin_near(rest),
        _cos_near(rest),
    )
    is_small = abs(x) <= _MOST_TURNS
    if every(is_small):
        return found
    return where(is_small, found, _library_cos(x))


@compiled_law
def atan2(y, x):
    """The angle of (x, y)."""
    is_near = abs(y) <= _TAN_22_5 * x
    r = y / x
    z = r * r
    p = -8.750608600031904122785e-1 * z - 1.615753718733365076637e1
    p = p * z - 7.500855792314704667340e1
    p = p * z - 1.228866684490136173410e2
    p = p * z - 6.485021904942025371773e1
    q = z + 2.485846490142306297962e1
    q = q * z + 1.650270098316988542046e2
    q = q * z + 4.328810604912902668951e2
    q = q * z + 4.853903996359136964868e2
    q = q * z + 1.945506571482613964425e2
    near = r + r * z * p / q
    if every(is_near):
        return near
    return where(is_near, near, _library_atan2(y, x))
