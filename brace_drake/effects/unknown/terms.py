"""Terms that laws of unknown forces are made of: one function of few signals.

A term is a strength times a function of a place q, its rate v, a load u or the
time t, with up to two numbers of its shape. q, v, u and t are in units of what
is usual at their place, so that a strength is what the term gives there.
"""

import math

from brace_drake.laws.compiled import compiled_law
from brace_drake.laws.lanes.elementary import exp, sin, tanh
from brace_drake.laws.lanes.functions import every, lead, of_copy, where
from brace_drake.laws.lanes.kinds import COUNT

SPRING, EVEN, CUBIC, ABOVE, BELOW, RIPPLE = range(6)
VISCOUS, DRAG, EVEN_SPEED, DIRECTION, WEAKENING = range(6, 11)
MEMORY, LOOP = range(11, 13)
CONSTANT, DRIFT, DECAY, PULSE, OSCILLATION = range(13, 18)
PLACE_DIRECTION, PLACE_SPEED = range(18, 20)
LOAD_SQUARE, LOAD_EVEN, LOAD_DIRECTION = range(20, 23)

# Of what is usual: from this speed on a direction is one.
_SLOW = 0.05
# Of a pulse's length: what its edges take.
_EDGE = 0.1


@compiled_law
def _box(t, start, length):
    """0, 1 from start on, 0 after its end, with smooth edges."""
    edge = max(_EDGE * length, 1e-3)
    rise = 0.5 + 0.5 * tanh((t - start) / edge)
    fall = 0.5 + 0.5 * tanh((t - start - length) / edge)
    return rise - fall


@compiled_law
def term_of_place(code, a, b, q, v):
    """Terms of place and speed, no memory."""
    if code == SPRING:
        return q
    if code == EVEN:
        return q * q
    if code == CUBIC:
        return q * q * q
    if code == ABOVE:
        return max(0.0, q - a)
    if code == BELOW:
        return max(0.0, a - q)
    if code == RIPPLE:
        return sin(2.0 * math.pi * q / a + b)
    if code == VISCOUS:
        return v
    if code == DRAG:
        return v * abs(v)
    if code == EVEN_SPEED:
        return abs(v)
    if code == DIRECTION:
        return tanh(v / a)
    if code == WEAKENING:
        return tanh(v / _SLOW) * exp(-abs(v) / a)
    if code == PLACE_DIRECTION:
        return q * tanh(v / _SLOW)
    if code == PLACE_SPEED:
        return q * v
    return 0.0


@compiled_law
def term_of_time(code, a, b, t, s):
    """Terms of time t, s; s: t in units of what is usual."""
    if code == CONSTANT:
        return 1.0
    if code == DRIFT:
        return s
    if code == DECAY:
        return exp(-t / a)
    if code == PULSE:
        return _box(t, a, b)
    if code == OSCILLATION:
        return sin(2.0 * math.pi * a * t + b)
    return 0.0


@compiled_law
def term_of_load(code, u, v):
    """Terms of a load."""
    if code == LOAD_SQUARE:
        return u * abs(u)
    if code == LOAD_EVEN:
        return abs(u)
    if code == LOAD_DIRECTION:
        return abs(u) * tanh(v / _SLOW)
    return 0.0


@compiled_law
def term_with_memory(code, a, dt, q, v, x):
    """Terms with a state x: what lags behind, or turns round, in place.

    Returns:
        The term, and its state dt later.
    """
    if code == MEMORY:
        # An arm of spring and damper in series: (q - x), x' = (q - x) / a.
        after = x + (q - x) * (1.0 - exp(-dt / a))
        return q - after, after
    # Dahl: z' = v (1 - z sign(v)) / a, integrated implicitly.
    after = (x + dt * v / a) / (1.0 + dt * abs(v) / a)
    return after, after


@compiled_law
def _term(code, a, b, q, v, u, t, s, dt, x):
    """A term, and its state afterwards."""
    if code <= WEAKENING or code == PLACE_DIRECTION or code == PLACE_SPEED:
        return term_of_place(code, a, b, q, v), x
    if code <= LOOP:
        return term_with_memory(code, a, dt, q, v, x)
    if code <= OSCILLATION:
        return term_of_time(code, a, b, t, s), x
    return term_of_load(code, u, v), x


@compiled_law
def term_value(code, a, b, q, v, u, t, s, dt, x):
    """A term without its strength.

    Args:
        code: Which, see the constants of this module; copies may differ in it.
        a, b: Of its shape.
        q, v, u, s: Place, speed, load and time in units of what is usual.
        t, dt: s.
        x: State.

    Returns:
        The term, and its state dt later.
    """
    value, state = _term(lead(code), a, b, q, v, u, t, s, dt, x)
    if every(code == lead(code)):
        return value, state
    for copy in range(1, COUNT):
        own = of_copy(code, copy)
        term, after = _term(own, a, b, q, v, u, t, s, dt, x)
        value = where(code == own, term, value)
        state = where(code == own, after, state)
    return value, state
