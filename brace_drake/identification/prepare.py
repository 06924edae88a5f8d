"""From a campaign to prepared runs with their noise floors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from brace_drake.core.errors import CampaignError
from brace_drake.devices.replays import is_dithered, simulate_noisy
from brace_drake.devices.twin import HIGHEST_HZ, Request
from brace_drake.effects.stack import Use
from brace_drake.identification.evaluation import PreparedRun
from brace_drake.identification.noise_floor import (
    NoiseFloor,
    estimate_floor,
    on_grid,
    repeat_ratio,
    written_quantum,
)
from brace_drake.recording.recording import Campaign, Run

_REPLICATES = 24
# Deviations of a repeat's noise from the twin's that count as real, in
# standard errors of the estimate.
_SIGNIFICANT = 5.0


def noise_replicates(
    twin,
    motion,
    subject: np.ndarray,
    uses: Sequence[Use],
    seeds: Sequence[Sequence[int]],
) -> np.ndarray:
    """Deviations of noisy from exact replays, one for each seed (n, N, C).

    Where an effect makes noise act as a dither, an exact replay is not what
    noisy ones scatter about: then their mean is taken.
    """
    noisy = simulate_noisy(twin, Request(motion, subject, uses), seeds)
    if len(seeds) > 1 and is_dithered(twin, uses):
        free = len(seeds) / (len(seeds) - 1)
        return np.sqrt(free) * (noisy - noisy.mean(axis=0))
    return noisy - twin.simulate(motion, subject, uses)


def estimate_floors(
    twin, campaign: Campaign, subject: np.ndarray, seed: int
) -> tuple[dict[bool, NoiseFloor], dict[str, float]]:
    """Floors with and without contact, carried through the twin's loop.

    Where a fit run was repeated, the difference of the two checks each
    channel's variance; a channel that deviates significantly takes the
    repeat's.

    Returns:
        Floors by contact, and the variance ratios that were applied, by
        channel.
    """
    floors = {}
    for contact in (False, True):
        runs = [r for r in campaign.runs if r.contact == contact]
        if runs:
            floors[contact] = _floor_of(
                twin, runs, subject, campaign.rate_hz, seed
            )
    return _checked_with_repeats(twin, campaign, floors)


def _floor_of(
    twin, runs: Sequence[Run], subject: np.ndarray, rate: float, seed: int
) -> NoiseFloor:
    """The floor of runs of one kind, from replays of some of them."""
    chosen = _spread_choice(runs, 3)
    each = _REPLICATES // len(chosen)
    # Of what is held back only how it moved is known here; where nothing else
    # was recorded, its last digits too.
    run = next((r for r in runs if r.split == "fit"), runs[0])
    quantum = written_quantum(twin.written(run), twin.reading_steps)
    noise, rounding = [], []
    for i, run in enumerate(chosen):
        motion = twin.motion(run)
        seeds = [[seed + i, 7, k] for k in range(each)]
        found = noise_replicates(twin, motion, subject, (), seeds)
        exact = twin.simulate(motion, subject, ())
        # Of samples that count in full: each run has its own share of others.
        share = _counted(twin, motion)
        noise.append(found / share)
        rounding.append(_rounding_of(exact + found, quantum, seed + i))
    samples = min(n.shape[1] for n in noise)
    return estimate_floor(
        np.concatenate([n[:, :samples] for n in noise]),
        rate,
        np.concatenate([r[:, :samples] for r in rounding]),
    )


def _counted(twin, motion) -> float:
    """How far the samples of a run count, as a root mean square; 1 where none
    does.
    """
    return float(np.sqrt(np.mean(np.square(twin.trust(motion))))) or 1.0


def _rounding_of(
    readings: np.ndarray, quantum: np.ndarray, seed: int
) -> np.ndarray:
    """What writing readings down adds (n, N, C).

    Where a reading lies between two steps is not known: that is drawn for each
    replicate, so that a rest that reads wrong by half a step counts as noise.
    """
    generator = np.random.default_rng([seed, 9])
    place = generator.random((len(readings), 1, len(quantum))) * quantum
    return on_grid(readings + place, quantum) - readings - place


def _spread_choice(runs: Sequence[Run], count: int) -> list[Run]:
    indices = np.unique(np.linspace(0, len(runs) - 1, count).round())
    return [runs[int(i)] for i in indices]


def _checked_with_repeats(twin, campaign, floors):
    by_file = {run.file: run for run in campaign.split("fit")}
    applied: dict[str, float] = {}
    for contact, floor in floors.items():
        ratios = []
        for run in campaign.split("fit"):
            original = by_file.get(run.repeat_of or "")
            if original is None or run.contact != contact:
                continue
            first, second = twin.measured(original), twin.measured(run)
            samples = min(len(first), len(second))
            difference = first[:samples] - second[:samples]
            difference = difference / _counted(twin, twin.motion(run))
            ratio = repeat_ratio(difference, floor, campaign.rate_hz)
            both = twin.recorded(original) & twin.recorded(run)
            # What is the same to the last digit is a copy, not a repeat.
            both &= np.any(difference != 0.0, axis=0)
            ratios.append(np.where(both, ratio, np.nan))
        if not ratios:
            continue
        told = np.isfinite(ratios).sum(axis=0)
        ratio = np.where(told > 0, np.nansum(ratios, axis=0), np.nan)
        ratio = ratio / np.maximum(told, 1)
        # Standard error of a median of exponentials over half the samples.
        error = 1.44 / np.sqrt(0.5 * samples * np.maximum(told, 1))
        off = np.isfinite(ratio) & (np.abs(ratio - 1.0) > _SIGNIFICANT * error)
        floors[contact] = floor.scaled(np.where(off, ratio, 1.0))
        for c in np.flatnonzero(off):
            applied[twin.channels[c]] = float(ratio[c])
    return floors, applied


def prepare_runs(
    twin,
    runs: Sequence[Run],
    floors: Mapping[bool, NoiseFloor],
    rate: float,
    seed: int,
) -> list[PreparedRun]:
    """Runs with motion, measurement and weights, 0 where not recorded."""
    prepared = []
    for i, run in enumerate(runs):
        measured = twin.measured(run)
        one = prepare_run(twin, run, measured, floors, rate, seed, i)
        recorded = one.weights * twin.recorded(run)
        prepared.append(replace(one, weights=recorded))
    return prepared


def prepare_run(
    twin,
    run: Run,
    measured: np.ndarray,
    floors: Mapping[bool, NoiseFloor],
    rate: float,
    seed: int,
    index: int,
) -> PreparedRun:
    """The run at a place among others, with the channels to compare with."""
    floor = floors[run.contact]
    weights = floor.weights(len(measured), rate, HIGHEST_HZ)
    motion = twin.motion(run)
    weights = weights * twin.active(run) / _counted(twin, motion)
    return PreparedRun(
        run, motion, measured, weights, floor, seed + index, index
    )


def check_motion(path, runs: Sequence[PreparedRun]) -> None:
    """Refuses fit runs of which none shows more than its noise: there any twin
    would be right.

    Args:
        path: Of the campaign.
        runs: Prepared.

    Raises:
        CampaignError: None does.
    """
    for run in runs:
        rest = run.weigh(run.measured - run.measured.mean(axis=0))
        error = np.sqrt(2.0 / max(1, run.count))
        if run.count and np.mean(rest**2) > 1.0 + _SIGNIFICANT * error:
            return
    raise CampaignError(
        f"{path}: no fit run moves by more than its noise: nothing can be"
        " learned from them"
    )
