"""Numbers that an axis under a command, or behind its motor, is fitted from."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import OptimizeResult, minimize

from brace_drake.devices.axis.controller_numbers import (
    LESS,
    RATIOS,
    find_controller,
    set_loop,
    squares_left,
)
from brace_drake.devices.axis.follower_subject import ELASTIC, FASTEST_RAD_S
from brace_drake.recording.recording import Run
from brace_drake.recording.ways import axis_columns
from brace_drake.scenario.axis import AxisScenario

# Lags, s, that the search may begin with, and the longest step of a follower,
# s.
_LAGS_S = tuple(0.005 * 2.0**i for i in range(9))
_STEP_S = 1e-3
_ROUGH = {"maxfev": 60, "xatol": 1e-3, "fatol": 0.0}
# Steps of a lag, as effects act on what a step begins with, and the shortest.
_LAG_STEPS, _SHORTEST_STEP_S = 40.0, 2e-4
# Logarithms of lag and damping ratio of a rigid one.
_RIGID = (-np.log(FASTEST_RAD_S), 0.0)


def find_numbers(scenario: AxisScenario, runs: Sequence[Run]) -> None:
    """Sets lag, frequency, damping ratio, offset and step of a follower: the
    best of a few, as a fit goes on from there.
    """
    time_step, scenario.time_step = scenario.time_step, _STEP_S
    if scenario.command == "motor":
        _find_spring(scenario, runs)
    else:
        _find_follower(scenario, runs)
    step = min(scenario.lag / _LAG_STEPS, time_step)
    scenario.time_step = min(_STEP_S, max(step, _SHORTEST_STEP_S))


def _find_follower(scenario: AxisScenario, runs: Sequence[Run]) -> None:
    """A lag or an oscillator, whether its command is held, and what else its
    controller has.
    """
    # Of a speed the ratio is no number.
    is_speed = scenario.command == "speed"
    ratios = (1.0,) if is_speed else RATIOS
    begins = [np.log([lag, z]) for lag in _LAGS_S for z in ratios]

    def left(x):
        set_loop(scenario, x)
        return squares_left(scenario, runs)

    best = _nearest_least(left, begins)
    if not is_speed:
        scenario.is_held = False
        straight = _nearest_least(left, begins)
        if straight.fun < LESS * best.fun:
            best = straight
        else:
            scenario.is_held = True
    set_loop(scenario, best.x)
    find_controller(scenario, runs)


def _find_spring(scenario: AxisScenario, runs: Sequence[Run]) -> None:
    """The spring between motor and load, if there is one.

    It is searched beside a dry friction of the load, which winds it up and
    hides it, and compared with a rigid joint with play.
    """
    position, motor = axis_columns(scenario.kind, scenario.command)
    more = [r.channels[position] - r.channels[motor] for r in runs]
    scenario.offset = float(np.mean(np.concatenate(more)))
    twist = float(np.std(np.concatenate(more)))
    cards = {card.name: card for card in scenario.own_effects().values()}
    friction, play = cards["coulomb_friction"], cards["backlash"]

    def elastic(x):
        set_loop(scenario, x)
        wound = scenario.frequency**2 * twist * np.exp(x[2])
        most = friction.parameters[0].upper
        return squares_left(
            scenario, runs, [(friction, np.array([min(wound, most)]))]
        )

    def rigid(x):
        set_loop(scenario, _RIGID)
        width = 2.0 * twist * np.exp(x[0])
        return squares_left(scenario, runs, [(play, np.array([width]))])

    shares = np.log([0.01, 1.0])
    begins = [
        np.array([*np.log([lag, z]), share])
        for lag in _LAGS_S
        for z in RATIOS
        for share in shares
    ]
    loose = _nearest_least(rigid, list(shares[:, None]))
    best = _nearest_least(elastic, begins)
    if best.fun < LESS * loose.fun:
        scenario.fitted = list(ELASTIC)
        set_loop(scenario, best.x)
    else:
        set_loop(scenario, _RIGID)
    scenario.wound = scenario.frequency**2 * twist


def _nearest_least(left, begins) -> OptimizeResult:
    """From the best of a rough grid to the nearest least."""
    begin = min(begins, key=left)
    return minimize(left, begin, method="Nelder-Mead", options=_ROUGH)
