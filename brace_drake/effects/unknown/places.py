"""Places where an unknown force or error may act: plug points of the twin.

The compiled laws take p = [strength, a, b, code] of one term and add it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from brace_drake.effects.unknown import forms
from brace_drake.effects.unknown.forms import Form
from brace_drake.effects.unknown.terms import term_value
from brace_drake.laws.hooks import plug
from brace_drake.laws.lanes.functions import lead, where

# What is usual: of a way, a depth, m; a speed, m/s; a load, N; a time, s.
WAY, DEPTH, SPEED, LOAD, FORCE, TIME = 5e-3, 2e-3, 0.02, 10.0, 10.0, 10.0
_LEGS = 6


@dataclass(frozen=True)
class Place:
    """Where a term acts, and what it depends on there.

    Attributes:
        key: Part of its name.
        block: To which it belongs.
        words: What is added, and where.
        point: Plug point.
        law: Compiled.
        num_states: It keeps.
        forms: That make sense there.
        variable: What q is called.
        scales: What is usual of q, v, u and t.
        units: Of q, v, u and t.
        unit: Of what is added.
        strength: To begin with, small: a strong ripple would hold a leg.
        needs: As of an effect.
    """

    key: str
    block: str
    words: str
    point: str
    law: Callable
    num_states: int
    forms: tuple[Form, ...]
    variable: str
    scales: tuple[float, float, float, float]
    units: tuple[str, str, str, str] = ("m", "m/s", "N", "s")
    unit: str = "N"
    strength: float = 0.05
    needs: tuple[str, ...] = ()


@plug("drive", lanes=True)
def _law_of_legs(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741
    # x: state of each leg, its first length, whether that is known.
    n = f.shape[0]
    if lead(x[2 * n]) == 0.0:
        for k in range(n):
            x[n + k] = l[k]
        x[2 * n] = 1.0
    for k in range(n):
        term, x[k] = term_value(
            p[3], p[1], p[2], (l[k] - x[n + k]) / WAY, l_dot[k] / SPEED,
            u[k] / LOAD, t, t / TIME, dt, x[k],
        )  # fmt: skip
        f[k] += p[0] * term


def _law_of_ring(axis: int):
    @plug("ring", lanes=True)
    def law(t, dt, p_R, r_R, V, F, p, x):
        term, x[0] = term_value(
            p[3], p[1], p[2], p_R[1] / WAY, V[4] / SPEED, 0.0, t, t / TIME,
            dt, x[0],
        )  # fmt: skip
        F[3 + axis] += p[0] * term

    return law


def _law_of_torso(axis: int):
    @plug("torso", lanes=True)
    def law_of_torso(t, dt, p_T, r_T, V, law, F, p, x):
        term, x[0] = term_value(
            p[3], p[1], p[2], p_T[1] / WAY, V[4] / SPEED, 0.0, t, t / TIME,
            dt, x[0],
        )  # fmt: skip
        F[3 + axis] += p[0] * term

    return law_of_torso


@plug("contact", lanes=True)
def _law_of_pads(t, dt, pad, d, law, N, p, x):
    touches = d[0] > 0.0
    term, after = term_value(
        p[3], p[1], p[2], d[0] / DEPTH, d[1] / SPEED, N[0] / FORCE, t,
        t / TIME, dt, x[pad],
    )  # fmt: skip
    N[0] = where(touches, N[0] + p[0] * term, N[0])
    x[pad] = where(touches, after, x[pad])


def _law_of_force_reading(axis: int):
    @plug("sensing", lanes=True)
    def law_of_reading(t, h, u, l, F, p, x):  # noqa: E741
        # x: state, the force before, whether that is known.
        rate = where(x[2] != 0.0, (F[1] - x[1]) / h, 0.0)
        x[1], x[2] = F[1], 1.0
        term, x[0] = term_value(
            p[3], p[1], p[2], F[1] / FORCE, rate / FORCE, F[1] / FORCE, t,
            t / TIME, h, x[0],
        )  # fmt: skip
        F[axis] += p[0] * term

    return law_of_reading


@plug("sensing", lanes=True)
def _law_of_length_reading(t, h, u, l, F, p, x):  # noqa: E741
    n = l.shape[0]
    if lead(x[n]) == 0.0:
        for k in range(n):
            x[k] = l[k]
        x[n] = 1.0
    for k in range(n):
        term, x[n + 1] = term_value(
            p[3], p[1], p[2], (l[k] - x[k]) / WAY, 0.0, 0.0, t, t / TIME, h,
            x[n + 1],
        )  # fmt: skip
        l[k] += p[0] * term


_MOTION = (WAY, SPEED, LOAD, TIME)
_READ = (
    forms.EVEN, forms.CUBIC, forms.MEMORY, forms.LOOP, forms.DIRECTION,
    *forms.OF_TIME,
)  # fmt: skip
LEGS = Place(
    "legs", "actuation", "a force along each leg", "drive", _law_of_legs,
    2 * _LEGS + 1,
    (*forms.OF_PLACE, *forms.OF_SPEED, *forms.OF_BOTH, *forms.OF_TIME,
     *forms.OF_LOAD),
    "its way", _MOTION, needs=("drive of its own", "brace"),
)  # fmt: skip


_ACROSS = (
    forms.SPRING, forms.EVEN, forms.ABOVE, forms.BELOW, forms.DIRECTION,
)  # fmt: skip


def _ring(axis: int) -> Place:
    name = "xyz"[axis]
    every = (*forms.OF_PLACE, *forms.OF_SPEED, *forms.OF_BOTH, *forms.OF_TIME)
    if axis != 1:
        # The brace pushes along y: what acts across goes with y as well.
        every = (*_ACROSS, *forms.OF_TIME)
    return Place(
        f"ring_{name}", "mechanism", f"a force along {name} on the ring",
        "ring", _law_of_ring(axis), 1, every, "y", _MOTION,
    )  # fmt: skip


def _torso(axis: int) -> Place:
    name = "xyz"[axis]
    every = (
        *forms.OF_PLACE[1:], *forms.OF_SPEED[1:], *forms.OF_BOTH,
        *forms.OF_TIME[1:],
    )  # fmt: skip
    if axis != 1:
        every = forms.OF_TIME[1:]
    return Place(
        f"torso_{name}", "torso", f"a force along {name} on the torso",
        "torso", _law_of_torso(axis), 1, every, "y", _MOTION,
    )  # fmt: skip


def _force_reading(axis: int) -> Place:
    name = "xyz"[axis]
    return Place(
        f"force_reading_{name}", "sensing",
        f"an error of the force along {name} that is read", "sensing",
        _law_of_force_reading(axis), 3,
        _READ if axis == 1 else (forms.SPRING, forms.EVEN, *forms.OF_TIME[1:]),
        "the force along y", (FORCE, FORCE, FORCE, TIME),
        ("N", "N/s", "N", "s"),
        needs=("force reading", "contact", *["brace"] * (axis != 1)),
    )  # fmt: skip


PADS = Place(
    "pads", "contact", "a force at each pad", "contact", _law_of_pads, 2,
    (
        forms.EVEN, forms.CUBIC, forms.ABOVE, *forms.OF_SPEED[1:],
        *forms.OF_BOTH, *forms.OF_TIME, *forms.OF_LOAD,
    ),
    "the depth", (DEPTH, SPEED, FORCE, TIME),
)  # fmt: skip
LENGTH_READING = Place(
    "length_reading", "sensing", "an error of each length that is read",
    "sensing", _law_of_length_reading, _LEGS + 2,
    (forms.SPRING, forms.EVEN, forms.RIPPLE, *forms.OF_TIME[1:]), "the length",
    _MOTION, unit="m", strength=2e-5, needs=("length reading", "brace"),
)  # fmt: skip
_AXES = (1, 0, 2)
PLACES = (
    LEGS,
    *map(_ring, _AXES),
    *map(_torso, _AXES),
    PADS,
    *map(_force_reading, _AXES),
    LENGTH_READING,
)
