"""The nominal axis of a campaign: what it states, and what its runs show."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import lsq_linear

from brace_drake.core.errors import CampaignError
from brace_drake.devices.axis.follower_numbers import find_numbers
from brace_drake.devices.axis.motion import MakeAxisMotion
from brace_drake.recording.columns import AXIS, DEVICES
from brace_drake.recording.recording import Campaign, Run
from brace_drake.recording.ways import AXIS_WAYS, AxisWay, describe_ways
from brace_drake.scenario.axis import AxisScenario
from brace_drake.scenario.pad_noise import (
    estimate_noise_by_band,
    estimate_white_noise,
    rises_above_noise,
)

_TERMS = ("mass", "viscous", "stiffness", "offset")
# A number counts where it is this many times what scatter alone makes of it.
_SHOWN = 2.0
# Over these parts of half the travel dry friction may build up; over longer
# ones it is a spring.
_WAYS = np.geomspace(1e-3, 0.03, 3)
# Steps of an effect between two samples.
_STEP_PARTS = 4.0


def MakeAxisScenario(campaign: Campaign) -> AxisScenario:
    """The nominal axis of a campaign.

    Mass, viscous friction and stiffness are the campaign's `nominal` where it
    has them, and one that is stated as 0 is not there; the others are those
    that its fit runs show by least squares. All of these are fitted to a
    machine, and with them the offset and the gain of each extra input.

    Raises:
        CampaignError: Runs are not of one kind, or have no column of motion
            or force.
    """
    way = _way_of(campaign)
    runs = campaign.split("fit")
    position, moved_by = way.columns
    for name in (position, moved_by):
        if not rises_above_noise([r.channels[name] for r in runs]):
            raise CampaignError(
                f"{campaign.path}: {name} shows no more than its noise in the"
                " fit runs: nothing can be learned"
            )
    # Of two encoders both are in what is compared.
    read = [position, *[moved_by] * (way.command == "motor")]
    sigma = np.hypot.reduce(
        [estimate_white_noise([r.channels[n] for r in runs]) for n in read]
    )
    scenario = AxisScenario(
        kind=way.kind,
        command=way.command,
        answer=way.answer,
        position_noise=float(sigma),
        time_step=1.0 / campaign.rate_hz / _STEP_PARTS,
    )
    if scenario.is_imposed:
        _take_forces(scenario, campaign, position, moved_by)
    else:
        _take_answers(scenario, runs, position)
    return scenario


def _take_forces(
    scenario: AxisScenario, campaign: Campaign, position: str, force: str
) -> None:
    """Numbers and sizes of an axis whose motion is imposed."""
    runs = campaign.split("fit")
    shared = set.intersection(*(set(r.channels) for r in campaign.runs))
    extra = [n for n in runs[0].channels if n.startswith(DEVICES[AXIS].inputs)]
    inputs = tuple(n for n in extra if n in shared)
    scenario.gains = dict.fromkeys(inputs, 0.0)
    scenario.force_noise = estimate_noise_by_band(
        runs, (force, position), campaign.rate_hz
    )
    sigma = scenario.position_noise
    paths = [MakeAxisMotion(r, position, inputs, sigma) for r in runs]
    path = np.vstack([m.path() for m in paths])
    beside = np.vstack([m.inputs for m in paths])
    measured = np.concatenate([r.channels[force] for r in runs])
    _take_sizes(scenario, path)
    scenario.force_scale = _half_range(measured)
    scenario.input_scales = {
        n: float(10.0 ** np.floor(np.log10(_size(v))))
        for n, v in zip(inputs, beside.T, strict=True)
    }
    doubts = scenario.most_mass, scenario.force_doubt
    trust = np.concatenate([m.trust(*doubts) for m in paths])
    _estimate(scenario, campaign.nominal, path, beside, measured, trust)


def _take_sizes(scenario: AxisScenario, path: np.ndarray) -> None:
    """Sizes of the motions of a path (N, 3)."""
    scenario.length_scale = _half_range(path[:, 0])
    scenario.speed_scale = _size(path[:, 1])
    scenario.acceleration_scale = _size(path[:, 2])


def _take_answers(
    scenario: AxisScenario, runs: Sequence[Run], position: str
) -> None:
    """Sizes and numbers of an axis that follows a command, or its motor."""
    sigma = scenario.position_noise
    paths = [MakeAxisMotion(r, position, (), sigma).path() for r in runs]
    if scenario.answer == "speed":
        times = [r.time_s for r in runs]
        paths = [_from_speed(*both) for both in zip(paths, times, strict=True)]
    _take_sizes(scenario, np.vstack(paths))
    find_numbers(scenario, runs)


def _from_speed(path: np.ndarray, time: np.ndarray) -> np.ndarray:
    """A path (N, 3) whose position is a speed as that of the position."""
    way = np.cumsum(path[:, 0] * np.gradient(time))
    return np.column_stack([way, path[:, 0], path[:, 1]])


def _way_of(campaign: Campaign) -> AxisWay:
    """How a campaign's axis is moved and read, by columns of all runs."""
    shared = set.intersection(*(set(r.channels) for r in campaign.runs))
    for way in AXIS_WAYS:
        if {*way.columns} <= shared:
            return way
    pairs = describe_ways([way.columns for way in AXIS_WAYS])
    raise CampaignError(f"{campaign.path}: an axis needs {pairs} in all runs")


def _half_range(values: np.ndarray) -> float:
    return 0.5 * float(np.ptp(values)) or 1.0


def _size(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2))) or 1.0


def _estimate(scenario, stated, path, beside, measured, trust) -> None:
    """Numbers of the machine by least squares, samples weighed by how far their
    motion is known; those that are not seen stay out of what is fitted.
    """
    names = [*_TERMS, *scenario.gains]
    terms = np.column_stack(
        [path[:, 2], path[:, 1], path[:, 0], np.ones(len(path)), beside]
    )
    terms, measured = trust[:, None] * terms, trust * measured
    known = {
        "mass": stated.get("mass_kg"),
        "viscous": stated.get("viscous_N_s_m"),
        "stiffness": stated.get("stiffness_N_m"),
    }
    values = dict(zip(names, np.zeros(len(names)), strict=True))
    values |= {n: v for n, v in known.items() if v is not None}
    able = [n for n in names if known.get(n) is None]
    friction = trust[:, None] * _friction_terms(path, beside)
    shown = _shown(names, able, terms, friction, measured)
    fitted = [n for n in names if n in shown or values[n]]
    open_ = [n for n in fitted if known.get(n) is None]
    rest = measured - terms @ np.array([values[n] for n in names])
    found = _solve(names, open_, terms, rest)
    values |= dict(zip(open_, found, strict=True))
    for name, value in values.items():
        if name in scenario.gains:
            scenario.gains[name] = float(value)
        else:
            setattr(scenario, name, float(value))
    scenario.fitted = fitted


def _friction_terms(path: np.ndarray, beside: np.ndarray) -> np.ndarray:
    """Dry friction of 1 on a path that builds up over several ways, and the
    same growing with each extra input (N, F).
    """
    position = path[:, 0]
    ways = _WAYS * _half_range(position)
    place = np.repeat(position[0], len(ways))
    held = np.empty((len(path), len(ways)))
    for y, row in zip(position, held, strict=True):
        place = np.clip(place, y - ways, y + ways)
        row[:] = y - place
    held /= ways
    return np.hstack([held, *(held * i[:, None] for i in np.abs(beside).T)])


def _shown(names, able, terms, friction, measured) -> set[str]:
    """Numbers of those that are not stated that the force shows beside dry
    friction, which may be there and hides a small mass; the offset always is
    one.
    """
    shown, count = list(able), friction.shape[1]
    while True:
        of_shown = terms[:, [names.index(n) for n in shown]]
        columns = np.hstack([of_shown, friction])
        size = np.maximum(np.linalg.norm(columns, axis=0), 1e-30)
        limits = _limits_of([*shown, *["friction"] * count])
        values = lsq_linear(columns / size, measured, limits).x
        rest = measured - columns @ (values / size)
        # Neighbours are not independent: as many values as the rest has turns.
        turns = max(2, np.count_nonzero(np.diff(np.sign(rest))))
        covariance = np.linalg.pinv((columns / size).T @ (columns / size))
        error = np.sqrt(np.diag(covariance) * (rest @ rest) / turns)
        weight = (np.abs(values) / np.maximum(error, 1e-30))[: len(shown)]
        weight[shown.index("offset")] = np.inf
        worst = int(np.argmin(weight))
        if weight[worst] > _SHOWN:
            return set(shown)
        del shown[worst]


def _solve(names, chosen: Sequence[str], terms, measured) -> np.ndarray:
    """Least squares with no mass, damper or spring below zero."""
    if not chosen:
        return np.zeros(0)
    columns = terms[:, [names.index(n) for n in chosen]]
    size = np.maximum(np.linalg.norm(columns, axis=0), 1e-30)
    found = lsq_linear(columns / size, measured, _limits_of(chosen))
    return found.x / size


def _limits_of(chosen: Sequence[str]) -> tuple[list[float], float]:
    """Least value of each number, and the largest of all."""
    above = "mass", "viscous", "stiffness"
    return [0.0 if n in above else -np.inf for n in chosen], np.inf
