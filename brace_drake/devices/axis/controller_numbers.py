"""What the controller of an axis under a command has beside its loop."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from scipy.optimize import least_squares

from brace_drake.core.errors import BraceError
from brace_drake.devices.axis.follower import AxisFollower
from brace_drake.devices.axis.follower_subject import (
    FASTEST_RAD_S,
    loop_damping,
)
from brace_drake.effects.card import Effect
from brace_drake.effects.stack import Use
from brace_drake.recording.recording import Run
from brace_drake.scenario.axis import AxisScenario

# How much less than another a kind of follower leaves, in squares, to be taken.
LESS = 0.8
# Damping ratios that a search may begin with.
RATIOS = 0.3, 0.7, 1.2
# Lags, s, and rates of an integral and the machine's own damping, both over the
# controller's, that a search begins with.
_LAGS_S = 0.01, 0.03, 0.1
_INTEGRALS, _VISCOUS = (0.02, 0.1, 0.3), 0.05
# Both are at most this much of the controller's, a logarithm.
_FASTEST = np.log(0.5)
# Effects that hide what a controller is: it is searched beside them too.
_HIDE = "coulomb_friction", "acceleration_limit", "speed_limit", "command_delay"
# A feed-forward below the one is none; an integral is at its fastest within the
# other.
_LITTLE, _NEAR = 1e-3, 0.05
# Squares over those of noise that leave nothing to be found.
_AT_NOISE = 1.1
# Steps of each search, and of a first look.
_STEPS, _FEW_STEPS = 20, 8
# Beyond this logarithm no lag is one.
_FARTHEST = 50.0
# What a follower that breaks down leaves of each reading.
_BROKEN = 1e9


@dataclass(frozen=True)
class _Form:
    """What a controller has, and which effect it is searched beside.

    Its numbers are logarithms, but for the feed-forward: lag and damping ratio;
    then feed-forward, rate of the integral and the machine's own damping over
    the controller's, and those of the effect, each where it is there.
    """

    has_forward: bool = False
    has_integral: bool = False
    integrates: str = "loop"
    beside: Effect | None = None

    def begins(self, x: np.ndarray) -> Iterator[np.ndarray]:
        """Numbers that a search may begin with.

        Args:
            x: Of the loop, and then of the effect where they are known.
        """
        loops, forwards, integrals, effects = [x[:2]], [()], [()], [x[2:]]
        if self.has_forward:
            # A command that is followed at once hides how fast the loop is.
            loops += [np.log([lag, RATIOS[1]]) for lag in _LAGS_S]
            forwards = [(0.0,), (1.0,)]
        if self.has_integral:
            integrals = [np.log([n, _VISCOUS]) for n in _INTEGRALS]
        if self.beside is not None and len(x) == 2:
            effects = [np.log(v) for v in self.beside.starts()]
        for parts in product(loops, forwards, integrals, effects):
            yield np.concatenate(parts)

    def is_within(self, x: np.ndarray) -> bool:
        """Whether an integral is none of the fastest that a search allows."""
        at = 2 + self.has_forward
        return not self.has_integral or bool(
            np.all(x[at : at + 2] < _FASTEST - _NEAR)
        )

    def take(self, scenario: AxisScenario, x: np.ndarray) -> list[Use]:
        """Gives a scenario the numbers, and returns the effect with its own."""
        set_loop(scenario, x)
        more = [float(v) for v in x[2:]]
        forward = more.pop(0) if self.has_forward else 0.0
        scenario.feed_forward = forward if forward > _LITTLE else 0.0
        scenario.integral = scenario.viscous = 0.0
        scenario.integrates = self.integrates
        if self.has_integral:
            # Without one its own damping is no other than the controller's.
            damping = loop_damping(scenario)
            scenario.integral = float(np.exp(more.pop(0))) * damping
            scenario.viscous = float(np.exp(more.pop(0))) * damping
        if self.beside is None:
            return []
        limits = [(p.lower, p.upper) for p in self.beside.parameters]
        return [(self.beside, np.clip(np.exp(more), *np.transpose(limits)))]


def find_controller(scenario: AxisScenario, runs: Sequence[Run]) -> None:
    """Gives a follower an integral, a feed-forward, or both, where they leave
    less.

    Dry friction and limits of the drive hide them; they are searched beside
    the one of these that takes most, too.

    Args:
        scenario: With lag and damping ratio of the loop.
        runs: To be fitted.
    """
    twin = AxisFollower(scenario)
    # Where runs begin depends little on what is searched.
    data = _compared(twin, runs)
    loop = np.log([scenario.lag, scenario.damping_ratio])

    def search(form, start, steps):
        return _search(scenario, data, form, start, steps)

    rest = _rest(twin, data, [])
    best, least, form = loop, float(rest @ rest), _Form()
    if least < _AT_NOISE * len(rest) * twin.answer_noise(runs) ** 2:
        return
    hidden, hidden_least = None, least
    for card in scenario.own_effects().values():
        if card.name in _HIDE:
            x, cost = search(_Form(beside=card), loop, _FEW_STEPS)
            if cost < hidden_least:
                hidden, hidden_least = (card, x), cost
    if hidden is not None:
        card, x = hidden
        x, hidden_least = search(_Form(beside=card), x, _STEPS)
        hidden = card, x
        if hidden_least < LESS * least:
            best, least, form = x, hidden_least, _Form(beside=card)
    richer = [_Form(True), _Form(True, True)]
    if scenario.command == "position":
        richer.append(_Form(True, True, "error"))
    for other in richer:
        for card, start in [(None, loop), *[hidden] * (hidden is not None)]:
            mine = replace(other, beside=card)
            x, cost = search(mine, start, _STEPS)
            if cost < LESS * least and mine.is_within(x):
                best, least, form = x, cost, mine
    form.take(scenario, best)


def _search(
    scenario, data, form: _Form, start: np.ndarray, steps: int
) -> tuple[np.ndarray, float]:
    """Numbers of least squares, from the best of a form's begins, and these."""

    def rest(x):
        uses = form.take(scenario, x)
        return _rest(AxisFollower(scenario), data, uses)

    begin = min(form.begins(start), key=lambda x: float(np.sum(rest(x) ** 2)))
    # No controller sends less the faster its command changes, and none has an
    # integral as fast as its loop: those would be dead times.
    least, most = np.full((2, len(begin)), [[-np.inf], [np.inf]])
    at = 2 + form.has_forward
    least[2:at] = 0.0
    most[at : at + 2 * form.has_integral] = _FASTEST
    found = least_squares(
        rest,
        begin,
        bounds=(least, most),
        x_scale=0.1,
        diff_step=1e-4,
        max_nfev=steps,
    )
    return found.x, 2.0 * float(found.cost)


def set_loop(scenario: AxisScenario, x: np.ndarray) -> None:
    """Gives a follower the logarithms of lag and damping ratio, x[:2]."""
    # Of a speed the ratio is no number, and may go anywhere.
    loop = np.clip(x[:2], -_FARTHEST, _FARTHEST)
    scenario.lag, scenario.damping_ratio = map(float, np.exp(loop))
    scenario.frequency = 1.0 / scenario.lag
    if scenario.command == "motor":
        scenario.frequency = min(scenario.frequency, FASTEST_RAD_S)
        scenario.damping_ratio = min(scenario.damping_ratio, max(RATIOS))


def squares_left(
    scenario: AxisScenario, runs: Sequence[Run], uses: Sequence[Use] = ()
) -> float:
    """Squares that a follower leaves of its runs."""
    twin = AxisFollower(scenario)
    rest = _rest(twin, _compared(twin, runs), uses)
    return float(rest @ rest)


def _compared(twin: AxisFollower, runs: Sequence[Run]) -> list[tuple]:
    """Motions of runs, and what was measured of them."""
    return [(twin.motion(run), twin.measured(run)) for run in runs]


def _rest(twin: AxisFollower, data, uses: Sequence[Use]) -> np.ndarray:
    """What a follower leaves of what is compared, run after run; beyond all
    bounds where it breaks down.
    """
    subject = np.array([p.nominal for p in twin.subject])
    try:
        rest = [
            measured - twin.simulate(motion, subject, uses)
            for motion, measured in data
        ]
    except BraceError:
        return np.full(sum(len(m) for _, m in data), _BROKEN)
    return np.concatenate(rest).ravel()
