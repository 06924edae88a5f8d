"""Forms of terms: on what each depends, in words, and with what shapes."""

from __future__ import annotations

import math
from dataclasses import dataclass

from brace_drake.effects.unknown import terms

# Names of a term's parameters; lengths of shapes are in units of what is usual
# at the place, times in s.
STRENGTH, CODE = "strength", "form"
_TURN = (0.0, 0.5 * math.pi)


@dataclass(frozen=True)
class Shape:
    """One number of a form's shape.

    Attributes:
        name: Of the parameter, without its unit.
        kind: `place` or `speed`, in units of what is usual there, `time`, s,
            `frequency`, Hz, or `angle`, rad.
        lower, upper: Limits.
        starts: From which a search begins.
    """

    name: str
    kind: str
    lower: float
    upper: float
    starts: tuple[float, ...]


@dataclass(frozen=True)
class Form:
    """What a term depends on.

    Attributes:
        key: Part of its name.
        code: In `terms`.
        words: What it is like; {q} is what its place is called, {a} and {b}
            the values of its shapes.
        formula: Of the strength c and its shapes; q, v, u, t.
        per: Unit of the strength beside that of what is added, as powers of
            place, speed, load and time; those are what it is divided by.
        usual: What such a law is usually called.
        shapes: At most two.
    """

    key: str
    code: int
    words: str
    formula: str
    per: tuple[int, int, int, int] = (0, 0, 0, 0)
    usual: str = ""
    shapes: tuple[Shape, ...] = ()


_ONSETS = (-0.8, -0.6, -0.4, -0.2, 0.0, 0.2, 0.4, 0.6, 0.8)
_ONSET = Shape("onset", "place", -3.0, 3.0, _ONSETS)
# Searches begin at peaks of what is left, see `discrepancy.starts`.
_PITCH = Shape("pitch", "place", 0.04, 2.0, (0.2, 0.5))
_PHASE = Shape("phase", "angle", -7.0, 7.0, _TURN)

SPRING = Form(
    "spring", terms.SPRING, "in proportion to {q}", "c q", (1, 0, 0, 0),
    "a spring",
)  # fmt: skip
EVEN = Form(
    "square", terms.EVEN, "with the square of {q}", "c q^2", (2, 0, 0, 0),
    "a spring that is softer one way",
)  # fmt: skip
CUBIC = Form(
    "cube", terms.CUBIC, "with the cube of {q}", "c q^3", (3, 0, 0, 0),
    "hardening",
)  # fmt: skip
ABOVE = Form(
    "above", terms.ABOVE, "where {q} is above {a}", "c max(0, q - a)",
    (1, 0, 0, 0), "a one-sided spring: a cable, a stop or a cushion", (_ONSET,),
)  # fmt: skip
BELOW = Form(
    "below", terms.BELOW, "where {q} is below {a}", "c max(0, a - q)",
    (1, 0, 0, 0), "a one-sided spring: a cable, a stop or a cushion", (_ONSET,),
)  # fmt: skip
RIPPLE = Form(
    "ripple", terms.RIPPLE, "periodic in {q} with a pitch of {a}",
    "c sin(2 pi q / a + b)", (0, 0, 0, 0), "cogging or the ripple of a screw",
    (_PITCH, _PHASE),
)  # fmt: skip
VISCOUS = Form(
    "damper", terms.VISCOUS, "in proportion to the speed", "c v",
    (0, 1, 0, 0), "a damper",
)  # fmt: skip
DRAG = Form(
    "drag", terms.DRAG, "with the square of the speed, against or with it",
    "c v |v|", (0, 2, 0, 0), "drag of a fluid",
)  # fmt: skip
EVEN_SPEED = Form(
    "even_speed", terms.EVEN_SPEED, "with the size of the speed", "c |v|",
    (0, 1, 0, 0), "a damper that differs by direction",
)  # fmt: skip
DIRECTION = Form(
    "direction", terms.DIRECTION, "with the direction of motion",
    "c tanh(v / a)", (0, 0, 0, 0), "dry friction",
    (Shape("speed", "speed", 1e-3, 1.0, (0.02, 0.2)),),
)  # fmt: skip
WEAKENING = Form(
    "weakening", terms.WEAKENING, "with the direction of slow motion",
    "c sign(v) exp(-|v| / a)", (0, 0, 0, 0), "break-away (Stribeck)",
    (Shape("speed", "speed", 1e-2, 2.0, (0.1, 0.5)),),
)  # fmt: skip
MEMORY = Form(
    "memory", terms.MEMORY, "with what {q} has changed by in the last {a}",
    "c (q - x), x' = (q - x) / a", (1, 0, 0, 0),
    "an arm of spring and damper in series",
    (Shape("time", "time", 5e-3, 60.0, (0.02, 0.2, 1.0, 5.0)),),
)  # fmt: skip
LOOP = Form(
    "loop", terms.LOOP, "in a loop over {q} that turns within {a}",
    "c z, z' = (v - |v| z) / a", (0, 0, 0, 0),
    "hysteresis: friction behind a spring",
    (Shape("width", "place", 1e-3, 2.0, (0.02, 0.1, 0.4)),),
)  # fmt: skip
CONSTANT = Form("constant", terms.CONSTANT, "that is constant", "c")
DRIFT = Form(
    "drift", terms.DRIFT, "that grows with time", "c t", (0, 0, 0, 1), "drift",
)  # fmt: skip
DECAY = Form(
    "decay", terms.DECAY, "that dies out from the start in {a}",
    "c exp(-t / a)", (0, 0, 0, 0), "warming up or settling",
    (Shape("time", "time", 0.1, 60.0, (0.5, 2.0, 8.0)),),
)  # fmt: skip
PULSE = Form(
    "pulse", terms.PULSE, "from {a} on for {b}", "c in a < t < a + b",
    (0, 0, 0, 0), "a knock, a pull or a cough",
    (
        Shape("start", "time", 0.0, 30.0, (1.0, 3.0, 5.0, 7.0, 9.0)),
        Shape("length", "time", 0.05, 20.0, (0.5, 2.0)),
    ),
)  # fmt: skip
OSCILLATION = Form(
    "oscillation", terms.OSCILLATION, "that swings at {a}",
    "c sin(2 pi a t + b)", (0, 0, 0, 0), "a motor, a pump, breath or tremor",
    (
        Shape(
            "frequency", "frequency", 0.03, 12.0, (0.3, 1.0)
        ),
        _PHASE,
    ),
)  # fmt: skip
PLACE_DIRECTION = Form(
    "place_direction", terms.PLACE_DIRECTION,
    "with {q} and the direction of motion", "c q sign(v)", (1, 0, 0, 0),
    "friction that grows with the way",
)  # fmt: skip
PLACE_SPEED = Form(
    "place_speed", terms.PLACE_SPEED, "with {q} times the speed", "c q v",
    (1, 1, 0, 0), "a damper that depends on place",
)  # fmt: skip
LOAD_SQUARE = Form(
    "load_square", terms.LOAD_SQUARE, "with the square of the load",
    "c u |u|", (0, 0, 2, 0), "a gain that changes with the load",
)  # fmt: skip
LOAD_EVEN = Form(
    "load_even", terms.LOAD_EVEN, "with the size of the load", "c |u|",
    (0, 0, 1, 0), "a gain that differs by direction",
)  # fmt: skip
LOAD_DIRECTION = Form(
    "load_direction", terms.LOAD_DIRECTION,
    "with the load and the direction of motion", "c |u| sign(v)",
    (0, 0, 1, 0), "friction that grows with the load",
)  # fmt: skip

OF_PLACE = (SPRING, EVEN, CUBIC, ABOVE, BELOW, RIPPLE)
OF_SPEED = (VISCOUS, DRAG, EVEN_SPEED, DIRECTION, WEAKENING)
OF_BOTH = (MEMORY, LOOP, PLACE_DIRECTION, PLACE_SPEED)
OF_TIME = (CONSTANT, DRIFT, DECAY, PULSE, OSCILLATION)
OF_LOAD = (LOAD_SQUARE, LOAD_EVEN, LOAD_DIRECTION)
